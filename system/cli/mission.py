"""The verbs `noctule mission SYSTEM`, yield of a robot's mission, and `noctule merge`, of its parts."""

from __future__ import annotations

import re
from collections.abc import Sequence
from functools import partial
from pathlib import Path

from circuits.errors import ParameterError
from circuits.units import parse_quantity
from system.cli.mission_output import blame_document, document, print_blame, print_mission, status_of
from system.cli.mission_verb import Merge, Mission
from system.cli.option_names import replay_of
from system.cli.output import print_json, print_line, progress_bar
from system.cli.verb import words_given
from system.cli.workers import workers_of
from system.notice import say
from system.plot import check_picture, save_picture
from system.reader import with_params
from system.study.blame.blame import BUDGET
from system.study.campaign import here
from system.study.mission.blamed import Blamed, blame_failing, to_blame
from system.study.mission.folder import begin, merge
from system.study.mission.found import Found
from system.study.mission.mission import Asked, mission_of
from system.study.mission.mission import Mission as Made
from system.study.mission.page import write_page
from system.study.mission.picture import draw_mission
from system.study.mission.running import ALL, Part, run_mission
from system.study.report.growing import Going, Growing

_NOT_THE_RUNS = ("blame", "output", "resume", "shard", "threads", "workers", "scheduler", "plot", "as_json")
_SHARD = re.compile(r"([0-9]{1,6})/([0-9]{1,6})")


def mission_command(asked: Mission) -> int:
    """Run a mission, print it, and keep its page; returns the status, `NO` where no run could be made."""
    check_picture(asked.plot)
    part = part_of(asked.shard)
    _check_blame(asked.blame, part)
    if asked.output is None and (asked.resume or part != ALL):
        raise ParameterError(
            f"{'resume' if asked.resume else 'shard'}: of which mission, must come with `output`"
        )
    made = mission_of(asked_of(asked))
    folder, command = None if asked.output is None else Path(asked.output), command_of(asked)
    if folder is not None:
        begin(folder, made, part, command, resume=asked.resume)
    growing = _growing(folder, made, command)
    try:
        with (
            progress_bar(f"{asked.system}, {made.runs} runs") as progress,
            workers_of(asked.threads, asked.workers, asked.scheduler) as workers,
        ):
            found = run_mission(
                made, folder, workers=workers, progress=progress, told=growing, command=command, part=part
            )
        blamed = _blamed(asked, made, found, folder)
    except KeyboardInterrupt:
        growing.leave()
        if folder is not None:
            say(f"{folder}: go on with --resume")
        raise
    return _tell(made, found, folder, command, (asked.plot, asked.as_json), blamed)


def _check_blame(count: int, part: Part) -> None:
    if count < 0:
        raise ParameterError(f"blame: {count}, must be at least 0")
    if count and part != ALL:
        raise ParameterError(
            "blame: with `shard`, which has some of the dies; merge the parts, and go on by `resume`"
        )


def _blamed(
    asked: Mission, made: Made, found: Sequence[Found], folder: Path | None
) -> tuple[Blamed, ...] | None:
    """Blame failing dies, as many as are asked for; None where none are."""
    if not asked.blame:
        return None
    failing = to_blame(found, asked.blame)
    budget = f"blame: {len(failing)} failing dies, at most {BUDGET} runs each"
    if not asked.as_json:
        say(budget)
    alone = asked.workers is None and asked.scheduler is None
    with progress_bar(budget) as progress:
        return blame_failing(
            made, failing, folder, progress=progress,
            workers=here if alone else partial(workers_of, None, asked.workers, asked.scheduler),
        )  # fmt: skip


def merge_command(asked: Merge) -> int:
    """Put the parts of a mission together, and print it as one run does."""
    check_picture(asked.plot)
    output = Path(asked.output)
    made, command, found = merge([Path(part) for part in asked.parts], output)
    return _tell(made, found, output, command, (asked.plot, asked.as_json), None)


def _tell(
    made: Made,
    found: Sequence[Found],
    folder: Path | None,
    command: Sequence[str],
    output: tuple[str | None, bool],
    blamed: Sequence[Blamed] | None,
) -> int:
    """Draw, write and print what was found, as a picture and a JSON document ask for it."""
    plot, as_json = output
    title = f"{made.asked.system}, {made.definition}"
    save_picture(plot, lambda figure: draw_mission(found, figure, title))
    page = None if folder is None else write_page(folder, made, found, command, replay_of, blamed or ())
    if as_json:
        told = {**document(made, found, folder, replay_of), **blame_document(blamed)}
        print_json({**told, "report": None if page is None else str(page)})
    else:
        print_mission(made, found, folder, replay_of)
        print_blame(blamed or ())
        if page is not None:
            print_line(f"report: {page}")
    return status_of("mission", found)


def _growing(folder: Path | None, made: Made, command: Sequence[str]) -> Growing[Sequence[Found]]:
    """Writes the page again and again while the mission runs, the first time at once."""

    def write(found: Sequence[Found], refresh: int) -> None:
        if folder is not None:
            write_page(folder, made, found, command, replay_of, (), Going(refresh))

    return Growing(write, first=0.0)


def asked_of(asked: Mission) -> Asked:
    """Give what is asked for in numbers."""
    given = with_params({}, asked.param)
    if asked.calibrated_at is not None:
        if "calibrated_at" in given:
            raise ParameterError("calibrated_at: is given by `param` too; leave one out")
        given["calibrated_at"] = f"{parse_quantity(asked.calibrated_at, 'degC', '--calibrated-at'):g}degC"
    celsius = tuple(parse_quantity(text, "degC", "--temperature") for text in asked.temperature)
    until = None if asked.until is None else _share(asked.until)
    return Asked(
        asked.system, asked.success, asked.first_die, asked.dies, asked.worlds, asked.trials, celsius,
        asked.bias_kind, given, asked.level, asked.change, asked.silicon, asked.chunk, until,
    )  # fmt: skip


def _share(text: str) -> float:
    """`2%` or `0.02`."""
    number = parse_quantity(text.strip().removesuffix("%"), "", "--until")
    return number / 100.0 if text.strip().endswith("%") else number


def part_of(text: str | None) -> Part:
    """Read which part of a mission is run, as `3/8`; all of it unless given."""
    if text is None:
        return ALL
    found = _SHARD.fullmatch(text.strip())
    if found is None or not 1 <= int(found[1]) <= int(found[2]):
        raise ParameterError(f'shard: "{text}", must be I/N with I from 1 to N; write as in 3/8')
    return Part(int(found[1]), int(found[2]))


def command_of(asked: Mission) -> tuple[str, ...]:
    """Give the words of the command that decide what runs there are, always the same for the same runs."""
    return ("noctule", "mission", asked.system, *words_given(asked, ("system", *_NOT_THE_RUNS)))
