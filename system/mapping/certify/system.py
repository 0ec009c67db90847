"""A mapped network at its task on a die, as studies run it: what a mission takes in a robot's place.

Its score stands beside that of the network that was asked for, in the same world; a run has succeeded where
it loses no more than `NEAR` of it. `healed` names parts of the chip that do not deviate on the die, so that a
mission tells what their deviations cost; the die is calibrated as it then is.
"""

from __future__ import annotations

import hashlib
import math
from dataclasses import dataclass
from functools import lru_cache
from numbers import Real
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from circuits.errors import DataError, ParameterError
from circuits.silicon.process import ROLLS_180
from circuits.silicon.silicon import Silicon
from system.files.document import toml_file
from system.mapping.certify.chips import CERTIFIED, HEALED, NOTHING, Where, certified, check_part
from system.mapping.certify.player import Player
from system.mapping.certify.task import Samples, Task, task_of
from system.mapping.chips import AnyMapped, chip_of, read_any_program
from system.meaning import meanings, of_run
from system.option import check_options, option
from system.options.block import describe_run
from system.options.code import code_of
from system.options.noise import Noisy, check_device_noise, device_noise, noise_option, noise_seed_option
from system.options.on_silicon import OnSilicon
from system.system import Account, RunTrace, System

if TYPE_CHECKING:
    from matplotlib.figure import Figure

NAME = "program"
NEAR = 0.03  # of the score that may be lost: the bar of 3 points
NUMBERS = meanings("""
score        number   -  score of the task on the die, 0 to 1
ideal_score  number   -  that of the network that was asked for, in the same world
lost         number   -  by how much the die's is lower
events_lost  integer  -  events that the chip's buses or its router lost
""")


@dataclass(frozen=True, slots=True)
class Scenario(OnSilicon):
    """A program at its task on a die."""

    program: str = option(
        "", "A network on its chip, as noctule map wrote it", metavar="FILE.toml", study=True
    )
    task: str = option("", "FILE.npz, an environment of Gymnasium, or FILE.py:NAME", study=True)
    samples: int = option(0, "Samples or episodes of a run", least=0, study=True)
    reach: str = option("", "Of each number that an environment shows, by commas", study=True)
    contents: str = option("", "Hash of the files, which a study checks", study=True)
    codes: Literal["calibrated", "default"] = option("calibrated", "As of a run", silicon=True, study=True)
    area: float = option(
        1.0, "Of all devices, over the circuit's", unit="", above=0.0, silicon=True, study=True
    )
    healed: str = option(
        NOTHING, "Parts that do not deviate", choices=tuple(HEALED), silicon=True, study=True
    )
    silicon_noise: Noisy = noise_option()
    noise_seed: int | None = noise_seed_option()

    def __post_init__(self) -> None:
        """Raise `ParameterError` naming the field that breaks its rule."""
        check_options(self)
        check_device_noise(self)

    @property
    def silicon(self) -> Silicon:
        """What it runs on, with devices of the circuit's area."""
        die = self.die.healed(*HEALED[self.healed]) if HEALED[self.healed] else self.die
        return Silicon(ROLLS_180.under(self.law), self.temperature_c, die)


@dataclass(frozen=True, slots=True, eq=False)
class Trace(RunTrace[Scenario]):
    """What a run leaves: both scores, events that were lost, and the chip's name."""

    score: float
    ideal: float
    lost_events: int
    chip: str


def contents_of(program: str, task: str) -> str:
    """Return the hash of a program's files and of the task's; raises `DataError` where one is missing."""
    code = code_of(task)
    named = [Path(program), Path(program).with_suffix(".npz"), code.path if code else Path(task)]
    found = [path for path in (*named[1:], *_functions(program)) if path.exists()]
    try:
        return hashlib.sha256(b"".join(path.read_bytes() for path in (named[0], *found))).hexdigest()[:16]
    except OSError as error:
        raise DataError(f"{error.filename}: {error.strerror}; name a program of noctule map") from None


def _functions(program: str) -> list[Path]:
    """Files of a user's functions that a program's network has."""
    network = toml_file(Path(program)).get("network", {})
    rows = (row for key in ("connection", "probe") for row in network.get(key, ()))
    codes = (code_of(str(row.get("function", ""))) for row in rows)
    return sorted({code.path for code in codes if code is not None})


def run(scenario: Scenario, progress: object = None) -> Trace:
    """Run a scenario; raises `ParameterError` for files that are not those of its study."""
    s, contents = scenario, contents_of(scenario.program, scenario.task)
    if s.contents not in {"", contents}:
        raise ParameterError(f"program: {s.program} or {s.task} has changed since; certify anew")
    mapped, task = opened(s, contents)
    chip = chip_of(mapped.network)
    check_part(chip, s.healed)
    where = Where(s.silicon, s.area, s.bias_kind, s.codes, device_noise(s))
    player = CERTIFIED[chip].on_die(mapped, where)
    score = score_of(s.task, task, player, s.seed)
    return Trace(s, score, ideal_score(s, contents), player.lost, CERTIFIED[chip].noun)


def opened(scenario: Scenario, contents: str) -> tuple[AnyMapped, Task]:
    """Return a scenario's program and task, whose files have the hash `contents`."""
    return _opened(scenario.program, scenario.task, scenario.samples, scenario.reach, contents)


def world_of(task: Task, seed: int) -> int:
    """Return the seed of the world that a run's seed stands for: all samples are one world."""
    return 0 if isinstance(task, Samples) and not task.most else seed


def ideal_score(scenario: Scenario, contents: str) -> float:
    """Return the score of the network that was asked for, in a scenario's world; it is worked out once."""
    s = scenario
    return _ideal(s.program, s.task, s.samples, s.reach, contents, world_of(opened(s, contents)[1], s.seed))


@lru_cache(maxsize=4)
def _opened(program: str, task: str, samples: int, reach: str, contents: str) -> tuple[AnyMapped, Task]:
    return read_any_program(program), task_of(task, samples, reach)


@lru_cache(maxsize=1024)
def _ideal(program: str, task: str, samples: int, reach: str, contents: str, seed: int) -> float:
    mapped, played = _opened(program, task, samples, reach, contents)
    return score_of(task, played, certified(mapped).ideal(mapped), seed)


def score_of(name: str, task: Task, player: Player, seed: int) -> float:
    """Return what a task gives; raises `ParameterError` for what is no number from 0 to 1."""
    found: Any = task(player, seed)  # of a user's own, whatever it is
    score = float(found) if isinstance(found, Real) else math.nan
    if not 0.0 <= score <= 1.0:
        raise ParameterError(f"task: {name} gives {found!r:.40}, must be a number from 0 to 1")
    return score


def numbers(trace: Trace) -> dict[str, float | None]:
    """Return the numbers of a run by name."""
    return {
        "score": trace.score, "ideal_score": trace.ideal, "lost": trace.ideal - trace.score,
        "events_lost": trace.lost_events,
    }  # fmt: skip


def account(trace: Trace) -> Account:
    """Say whether a run lost no more than `NEAR`, and what it ran on."""
    s = trace.scenario
    return Account(
        succeeded=trace.score >= trace.ideal - NEAR,
        reason="task done",
        ran_on={"codes": s.codes, "area": s.area, "healed": s.healed, **describe_run(s)},
        parts={"network": trace.chip, "task": "program; no chip makes it"},
    )


def draw(trace: Trace, figure: Figure) -> None:
    """Fill `figure` with both scores."""
    figure.subplots().bar(("ideal", "on the die"), (trace.ideal, trace.score))


SYSTEM = System(
    name=NAME,
    summary="a mapped network at its task on a die",
    success=f"the score is within {100 * NEAR:g} points of the ideal network's",
    kind=Scenario,
    run=run,
    account=account,
    numbers=numbers,
    draw=draw,
    study_metrics=tuple(NUMBERS),
    meanings=of_run(NUMBERS, {}),
    circuits=lambda: tuple(each for chip in CERTIFIED.values() for each in chip.circuits()),
)
