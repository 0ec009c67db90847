"""The verb `noctule certify`: a mission of a mapped network at a task, whose scores are told beside."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from circuits.errors import ParameterError
from circuits.units import parse_quantity
from system.cli.certify_verb import NO_CHANGE, Certify
from system.cli.mission_output import document, print_mission, status_of
from system.cli.option_names import replay_of
from system.cli.output import print_json, print_line, print_table, progress_bar
from system.cli.verb import words_given
from system.cli.workers import workers_of
from system.mapping.certify.chips import NOTHING, check_part, usual_changes
from system.mapping.certify.resolution import Resolved, bits_of, fewest_bits, resolved
from system.mapping.certify.system import NAME, Scenario, contents_of
from system.mapping.certify.task import Episodes, Samples, task_of
from system.mapping.chips import chip_of_program, read_any_program
from system.mapping.train.recipe import UNSEEN
from system.notice import say
from system.options.silicon import SiliconChoice
from system.plot import check_picture, save_picture
from system.study.mission.folder import begin
from system.study.mission.found import Found
from system.study.mission.mission import Asked, mission_of
from system.study.mission.page import write_page
from system.study.mission.picture import draw_mission
from system.study.mission.running import Part, run_mission
from system.study.plan import seeds_of
from system.study.statistics.clustered import mean_of_shares
from system.study.statistics.summary import means_of_dies

_SCORES = ("score", "ideal_score")
_NOT_THE_RUNS = ("program", "output", "resume", "threads", "plot", "as_json")


def certify_command(asked: Certify) -> int:
    """Run a network at its task on dies, and print, draw and keep what it came to."""
    check_picture(asked.plot)
    if asked.resume and asked.output is None:
        raise ParameterError("resume: of which runs, must come with `output`")
    network, task = read_any_program(asked.program).network, task_of(asked.task, asked.samples, asked.reach)
    bits = bits_of(asked.bits)
    if isinstance(task, Samples | Episodes):
        task.check(network)
    made = mission_of(_asked(asked))
    for way in made.ways:
        check_part(chip_of_program(asked.program), str(way.study.subject.system.get("healed", NOTHING)))
    if asked.first_die < UNSEEN and asked.lot == "A":
        say(f"first-die: {asked.first_die}, noctule train may have seen dies below {UNSEEN}; take later ones")
    folder, command = None if asked.output is None else Path(asked.output), _command(asked)
    if folder is not None:
        begin(folder, made, Part(), command, resume=asked.resume)
    with (
        progress_bar(f"{asked.program}, {made.runs} runs") as progress,
        workers_of(asked.threads, None, None) as workers,
    ):
        found = run_mission(made, folder, workers=workers, progress=progress, command=command)
        coarse = resolved(_first_world(asked), bits)
    save_picture(asked.plot, lambda figure: draw_mission(found, figure, f"{asked.program}, {asked.task}"))
    page = None if folder is None else str(write_page(folder, made, found, command, replay_of))
    if asked.as_json:
        told = document(made, found, folder, replay_of)
        scores = [_scores(each) for each in found]
        own = {"program": asked.program, "task": asked.task, "scores": scores, "report": page}
        print_json({**told, **own, "bits": list(map(asdict, coarse)), "fewest_bits": fewest_bits(coarse)})
        return status_of("certify", found)
    print_mission(made, found, folder, replay_of)
    _print_scores(found)
    _print_bits(coarse)
    if page is not None:
        print_line(f"report: {page}")
    return status_of("certify", found)


def _asked(asked: Certify) -> Asked:
    options = {
        "program": asked.program, "task": asked.task, "samples": str(asked.samples), "reach": asked.reach,
        "contents": contents_of(asked.program, asked.task),
    }  # fmt: skip
    chip = chip_of_program(asked.program)
    celsius = tuple(parse_quantity(text, "degC", "temperature") for text in asked.temperature)
    return Asked(
        NAME, None, asked.first_die, asked.dies, 1, asked.trials, celsius, (asked.bias_kind,), options,
        changes=() if asked.change == (NO_CHANGE,) else asked.change or usual_changes(chip),
        silicon=SiliconChoice(lot=asked.lot, variation=asked.variation),
    )  # fmt: skip


def _first_world(asked: Certify) -> Scenario:
    """What is run in the first world of the first die."""
    seed, _ = seeds_of(asked.first_die, 0, asked.trials)
    return Scenario(
        program=asked.program, task=asked.task, samples=asked.samples, reach=asked.reach, seed=seed
    )


def _command(asked: Certify) -> tuple[str, ...]:
    return ("noctule", "certify", asked.program, *words_given(asked, _NOT_THE_RUNS))


def _scores(found: Found) -> dict[str, Any]:
    """Mean scores over the dies of a way, that on silicon with its interval, by JSON's names."""
    score, ideal = (found.table.column(name) for name in _SCORES)
    known = np.isfinite(score)
    if not known.any():
        return {"name": found.way.name, **dict.fromkeys(("score", "interval", "least", "ideal_score"))}
    dies = means_of_dies(score[known], found.table.die[known])
    ends = mean_of_shares(dies)
    return {
        "name": found.way.name,
        "score": float(score[known].mean()),
        "interval": asdict(ends),
        "least": float(dies.min()),
        "ideal_score": float(ideal[known].mean()),
    }


def _print_scores(found: Sequence[Found]) -> None:
    rows = []
    for each in map(_scores, found):
        if each["score"] is None:  # no run of it could be made
            rows.append((each["name"], "", "", "", ""))
            continue
        ends = each["interval"]
        reach = f"{ends['low']:.1%} to {ends['high']:.1%}"
        scores = (f"{each[name]:.1%}" for name in ("score", "least", "ideal_score"))
        rows.append((each["name"], *scores, reach))
    print_table(
        "scores, means over dies", ("way", "on silicon:", "worst die:", "ideal:", "95 % interval:"), rows
    )


def _print_bits(found: Sequence[Resolved]) -> None:
    if not found:
        return
    rows = [(str(each.bits), f"{each.score:.1%}", f"{100.0 * each.lost:.1f}") for each in found]
    print_table("weights of so many bits, without silicon", ("bits:", "score:", "points lost:"), rows)
    least = fewest_bits(found)
    print_line("none of these suffices" if least is None else f"{least} bits suffice")
