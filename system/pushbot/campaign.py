"""Many runs of the Pushbot, in cells of like ones, kept in a campaign's file.

Dies and seeds from FIRST on report; those below tuned. Every run has noise of its own; a die comes again
every `dies` runs. Runs are made a chip at a time, so that each process calibrates a chip once; a run depends
on none before it (`system.study.campaign`).
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, fields, replace
from functools import lru_cache
from importlib.metadata import version
from math import sqrt
from typing import Any, NamedTuple, TypeVar

import msgspec
import numpy as np

from circuits.arrays import F64
from circuits.errors import ParameterError
from circuits.silicon.die import Die
from circuits.silicon.process import ROLLS_180
from system.options.codes import CALIBRATED, DEFAULT
from system.options.noise import device_noise
from system.pushbot.body import Pushbot
from system.pushbot.brain import GYRO_ANGLE
from system.pushbot.loop import Brain
from system.pushbot.network.biases import CODES, FULL_LAW, FULL_LAW_MODIFIED, LEVELS, MODIFIED
from system.pushbot.network.calibration import EVENTS, RATES, TURN_EVENTS, TURN_RATE
from system.pushbot.network.modified import MODIFIED_LEVELS
from system.pushbot.network.modified_calibration import EVENTS as MODIFIED_EVENTS
from system.pushbot.network.modified_calibration import RATES as MODIFIED_RATES
from system.pushbot.run import Trace, make_brain, run_with, summarise
from system.pushbot.scenario import Scenario, scene_of
from system.study.campaign import ALONE, Campaign, Execution
from system.study.statistics.share import Share, share_where
from system.worlds.arena.scene import COLOURS, Scene
from system.worlds.camera.sensor import Dvs

FIRST = 9400  # of dies and seeds that report; those below were seen while codes and levels were chosen
DIES = 10  # of a campaign; ours
EVERY = 10  # steps of the sensor between two points of a path that is kept; ours
Summary = dict[str, float | None]
Make = Callable[[Scenario], Brain]
Keep = Callable[[Trace], Summary]
World = Callable[[Scenario], Scene]
Cell = TypeVar("Cell")


# Fields that the name of every drive tells, in their order there; others only where they are given.
_TOLD = (
    "scene", "speed_factor", "turn_factor", "window", "readout", "modified", "dropped", "colour", "light",
    "target", "duration", "way", "exc", "seed", "die", "temperature_c", "bias_kind", "calibrated", "frame",
    "raise_lateral", "silicon_noise", "noise_seed",
)  # fmt: skip
# `calibrated` says whether codes are of a calibration
_UNTOLD = {"law": "ideal"}  # what a name that does not tell a field means by it, where no default does


@dataclass(frozen=True, slots=True)
class Drive:
    """A run of a campaign: what is kept of it, and where it is; with its path, if that is to be drawn.

    keep and world are functions of modules, which other processes can find.

    scenario : what is asked for.
    with_path : whether the path is kept too.
    """

    scenario: Scenario
    keep: Keep = summarise
    world: World = scene_of
    with_path: bool = False

    def __repr__(self) -> str:
        """Alike in every process, and wherever the functions stand.

        What kept files' runs had no option for is named where it is asked for, so that the files stay whole.
        """
        named = [f.__qualname__ for f in (self.keep, self.world)]
        whether = {"calibrated": self.scenario.code_choice != DEFAULT}
        told = (f"{name}={whether.get(name, getattr(self.scenario, name, None))!r}" for name in _TOLD)
        later = (
            f"{each.name}={getattr(self.scenario, each.name)!r}"
            for each in fields(self.scenario)
            if each.name not in _TOLD
            and not (each.name == "codes" and self.scenario.codes in {CALIBRATED, DEFAULT})
            and getattr(self.scenario, each.name) != _UNTOLD.get(each.name, each.default)
        )
        return f"Scenario({', '.join([*told, *later])}) {named} {self.with_path}"


@dataclass(frozen=True, slots=True, eq=False)
class Driven:
    """What was kept of a run; path: float64[n, 2], m, every EVERY steps, empty unless asked for.

    summary : what was kept of the run, by name.
    """

    summary: Summary
    path: F64


class Runs(NamedTuple):
    """How often a cell is driven, on how many dies, and the first die and seed."""

    number: int
    dies: int
    first: int = FIRST


class Key(NamedTuple):
    """Of a run: its chip's die, and a digest of all that it is asked to do."""

    die: str
    drive: str


class Kept(msgspec.Struct, frozen=True, omit_defaults=True):
    """What the file has of a run.

    summary : numbers of the run by name, as `noctule run pushbot --json` has them; null where not defined.
    path : places that it passed, if they were asked for, x and y in m, to a tenth of a millimetre.
    """

    summary: Summary
    path: tuple[tuple[float, float], ...] | None = None


@dataclass(frozen=True, slots=True)
class Drives:
    """Makes runs by the digests of their keys, each with the scenario for which its chip is made."""

    drives: Mapping[str, tuple[Drive, Scenario]]
    make: Make = make_brain

    def __call__(self, key: Key) -> Kept:
        """Drive once; a chip is made once for runs that follow each other in a process."""
        drive, first = self.drives[key.drive]
        trace = _trace(_brain(self.make, first), drive)
        if not drive.with_path:
            return Kept(drive.keep(trace))
        path = np.round(np.array(trace.drive.path)[::EVERY, 1:3], 4)
        return Kept(drive.keep(trace), tuple((x, y) for x, y in path.tolist()))


@lru_cache(maxsize=1)
def _brain(make: Make, first: Scenario) -> Brain:
    return make(first)


def _trace(brain: Brain, drive: Drive) -> Trace:
    return run_with(brain, drive.scenario, drive.world(drive.scenario), drive.scenario.read())


def drive_again(drive: Drive) -> Trace:
    """A run of a campaign once more, with all that a picture of it shows."""
    return _trace(make_brain(drive.scenario), drive)


def trials(base: Scenario, count: int, dies: int = DIES, first: int = FIRST) -> list[Scenario]:
    """`count` runs of a scenario on `dies` dies, each with a seed of its own.

    Raises `ParameterError` for no run or no die.
    """
    if count < 1 or dies < 1:
        raise ParameterError(f"campaign: {count} runs on {dies} dies, must be at least 1 each")
    return [replace(base, seed=first + k, die=Die(number=first + k % dies)) for k in range(count)]


def drive_cells(
    execution: Execution,
    name: str,
    cells: Mapping[Cell, Sequence[Drive]],
    planned: Mapping[Cell, Sequence[Drive]],
    progress: Callable[[float], object],
    make: Make = make_brain,
) -> dict[Cell, list[Driven]]:
    """Every run of every cell, in the order given, as a campaign of this name.

    planned: the cells with the counts that the campaign has unless others are asked for. They stand in its
    mark, so that more runs lengthen a kept file.
    """
    asked = [drive for cell in cells.values() for drive in cell]
    by_chip = _by_chip(asked)
    drives = {_digest(drive): (drive, group[0].scenario) for group in by_chip for drive in group}
    keys = list(dict.fromkeys(_key(drive) for group in by_chip for drive in group))
    plan = tuple(map(tuple, _by_chip([drive for cell in planned.values() for drive in cell])))
    numbers: tuple[object, ...] = (
        version("noctule"), Dvs(), Pushbot(), COLOURS, LEVELS, CODES, MODIFIED, EVENTS, RATES,
        TURN_EVENTS, TURN_RATE, MODIFIED_LEVELS, MODIFIED_EVENTS, MODIFIED_RATES, GYRO_ANGLE, plan,
    )  # fmt: skip
    if any(drive.scenario.law == "full" for drive in asked):  # kept files of the ideal law stay whole
        numbers = (*numbers, FULL_LAW, FULL_LAW_MODIFIED)
    others = {drive.scenario.process: drive.scenario.made_in for drive in asked} | {ROLLS_180.name: None}
    numbers = (*numbers, *(others[name] for name in sorted(others) if others[name] is not None))
    found: dict[Key, Driven] = {}
    with closing(execution.results(Campaign(name, Drives(drives, make), Key, Kept, numbers), keys)) as runs:
        for key, run in zip(keys, runs, strict=True):
            found[key] = Driven(run.summary, np.array(run.path or (), dtype=float).reshape(-1, 2))
            progress(len(found) / len(keys))
    return {cell: [found[_key(drive)] for drive in each] for cell, each in cells.items()}


def drive_repeats(
    execution: Execution,
    name: str,
    cells: Mapping[Cell, Drive],
    asked: Runs,
    usual: Runs,
    progress: Callable[[float], object],
) -> dict[Cell, list[Driven]]:
    """The drive of every cell again and again, on dies and with seeds of their own.

    asked, usual: how many of a cell, and the numbers that the campaign has unless others are asked for.
    """

    def repeated(runs: Runs) -> dict[Cell, list[Drive]]:
        return {
            cell: [replace(drive, scenario=s) for s in trials(drive.scenario, *runs)]
            for cell, drive in cells.items()
        }

    return drive_cells(execution, name, repeated(asked), repeated(usual), progress)


def summaries_of(driven: Mapping[Cell, Sequence[Driven]]) -> dict[Cell, list[Summary]]:
    """What was kept of every run of every cell."""
    return {cell: [d.summary for d in each] for cell, each in driven.items()}


def _key(drive: Drive) -> Key:
    return Key(f"die {drive.scenario.die.number}", _digest(drive))


def _digest(drive: Drive) -> str:
    return hashlib.sha256(repr(drive).encode()).hexdigest()[:16]


def _by_chip(drives: Sequence[Drive]) -> list[list[Drive]]:
    """Runs on each chip, in the order of the chips."""
    groups: dict[tuple[object, ...], list[Drive]] = {}
    keys = [_chip(drive.scenario) for drive in drives]
    for k in sorted(range(len(drives)), key=keys.__getitem__):
        groups.setdefault(keys[k], []).append(drives[k])
    return list(groups.values())


def _chip(s: Scenario) -> tuple[Any, ...]:
    """What a scenario's chip depends on."""
    return (
        s.die.number or 0, repr(s.die.edits), s.temperature_c, s.course, s.law, s.bias_kind,
        repr(s.architecture()), s.code_choice, s.calibrated_c, repr(device_noise(s)), s.process,
    )  # fmt: skip


def drive_each(
    scenarios: Sequence[Scenario],
    keep: Keep = summarise,
    make: Make = make_brain,
    world: World = scene_of,
) -> list[Summary]:
    """What `keep` says of every run, in the order of the scenarios, in this process and no file."""
    cells = {"all": [Drive(s, keep, world) for s in scenarios]}
    return summaries_of(drive_cells(ALONE, "runs", cells, cells, lambda _: None, make))["all"]


def share_of(found: Sequence[Summary], name: str) -> Share:
    """Share of the runs whose number `name` is not 0."""
    return share_where(bool(s[name]) for s in found)


def mean_sd(found: Sequence[Summary], name: str) -> tuple[float, float, int]:
    """Mean, standard deviation and how many of what is defined; NaN of none."""
    values = [v for s in found if (v := s[name]) is not None]
    if not values:
        return float("nan"), float("nan"), 0
    deviation = float(np.std(values, ddof=1)) if len(values) > 1 else 0.0
    return float(np.mean(values)), deviation, len(values)


def standard_error(deviation: float, count: int) -> float:
    """Return the standard error of a mean, of the deviation of `count` values."""
    return deviation / sqrt(max(count, 1))
