"""Many runs of the Pushbot, a chip at a time, kept in a campaign's file.

Dies and seeds from FIRST on report; those below tuned. Every run has noise of its own; a die comes again
every `dies` runs. All runs on a chip are one piece of work (`system.study.campaign`), so that it is
calibrated once for them, whoever makes it; an interrupted campaign loses the chips in work.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from importlib.metadata import version
from math import sqrt

import msgspec
import numpy as np

from circuits.arrays import F64
from circuits.errors import ParameterError
from circuits.silicon.die import Die
from system.pushbot.body import Pushbot
from system.pushbot.brain import GYRO_ANGLE
from system.pushbot.loop import Brain
from system.pushbot.network.biases import CODES, LEVELS, MODIFIED
from system.pushbot.network.calibration import EVENTS, RATES, TURN_EVENTS, TURN_RATE
from system.pushbot.network.modified import MODIFIED_LEVELS
from system.pushbot.network.modified_calibration import EVENTS as MODIFIED_EVENTS
from system.pushbot.network.modified_calibration import RATES as MODIFIED_RATES
from system.pushbot.run import Scenario, Trace, make_brain, run_with, scene_of, summarise
from system.study.campaign import ALONE, Campaign, Execution, Numbered
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


@dataclass(frozen=True, slots=True)
class Drive:
    """A run of a campaign: what is kept of it, and where it is; with its path, if that is to be drawn.

    keep and world are functions of modules, which other processes can find.
    """

    scenario: Scenario
    keep: Keep = summarise
    world: World = scene_of
    with_path: bool = False

    def __repr__(self) -> str:
        """Alike in every process, and wherever the functions stand."""
        named = [f.__qualname__ for f in (self.keep, self.world)]
        return f"{self.scenario!r} {named} {self.with_path}"


@dataclass(frozen=True, slots=True, eq=False)
class Driven:
    """What was kept of a run; path: float64[n, 2], m, every EVERY steps, empty unless asked for."""

    summary: Summary
    path: F64


class Kept(msgspec.Struct, frozen=True, omit_defaults=True):
    """Of a run in the file: its summary, and its path if that was asked for, m to a tenth of a millimetre."""

    summary: Summary
    path: tuple[tuple[float, float], ...] | None = None


class Piece(msgspec.Struct, frozen=True):
    """Runs on one chip."""

    runs: tuple[Kept, ...]


@dataclass(frozen=True, slots=True)
class Chips:
    """Runs by their chips; makes all runs of the chip that a key numbers."""

    drives: tuple[tuple[Drive, ...], ...]
    make: Make = make_brain

    def __call__(self, key: Numbered) -> Piece:
        """Drive them all."""
        drives = self.drives[key[1]]
        brain = self.make(drives[0].scenario)
        return Piece(tuple(_kept(brain, each) for each in drives))


def _kept(brain: Brain, drive: Drive) -> Kept:
    trace = _trace(brain, drive)
    if not drive.with_path:
        return Kept(drive.keep(trace))
    path = np.round(np.array(trace.drive.path)[::EVERY, 1:3], 4)
    return Kept(drive.keep(trace), tuple((x, y) for x, y in path.tolist()))


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


def drive_all(
    execution: Execution,
    name: str,
    drives: Sequence[Drive],
    progress: Callable[[float], None] | None = None,
    make: Make = make_brain,
) -> list[Driven]:
    """Every run, in the order given, as a campaign of this name; a chip is made once."""
    groups = _by_chip([d.scenario for d in drives])
    chips = Chips(tuple(tuple(drives[k] for k in group) for group in groups), make)
    keys = [Numbered(f"die {drives[group[0]].scenario.die.number}", j) for j, group in enumerate(groups)]
    found: dict[int, Driven] = {}
    numbers = (
        version("noctule"), Dvs(), Pushbot(), COLOURS, LEVELS, CODES, MODIFIED, EVENTS, RATES,
        TURN_EVENTS, TURN_RATE, MODIFIED_LEVELS, MODIFIED_EVENTS, MODIFIED_RATES, GYRO_ANGLE, chips.drives,
    )  # fmt: skip
    campaign = Campaign(name, chips, Numbered, Piece, numbers)
    with closing(execution.results(campaign, keys)) as pieces:
        for group, piece in zip(groups, pieces, strict=True):
            for k, run in zip(group, piece.runs, strict=True):
                found[k] = Driven(run.summary, np.array(run.path or (), dtype=float).reshape(-1, 2))
            if progress is not None:
                progress(len(found) / len(drives))
    return [found[k] for k in range(len(drives))]


def _by_chip(scenarios: Sequence[Scenario]) -> list[list[int]]:
    """Numbers of the scenarios on each chip, in the order of the chips."""
    groups: dict[tuple[object, ...], list[int]] = {}
    keys = [
        (
            s.die.number or 0, s.temperature_c, s.bias_kind, repr(s.architecture()), s.calibrated,
            repr(s.device_noise()),
        )
        for s in scenarios
    ]  # fmt: skip
    for k in sorted(range(len(scenarios)), key=keys.__getitem__):
        groups.setdefault(keys[k], []).append(k)
    return list(groups.values())


def drive_each(
    scenarios: Sequence[Scenario],
    keep: Keep = summarise,
    progress: Callable[[float], None] | None = None,
    make: Make = make_brain,
    world: World = scene_of,
) -> list[Summary]:
    """What `keep` says of every run, in the order of the scenarios, in this process and no file."""
    drives = [Drive(s, keep, world) for s in scenarios]
    return [driven.summary for driven in drive_all(ALONE, "runs", drives, progress, make)]


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
    """Of a mean."""
    return deviation / sqrt(max(count, 1))
