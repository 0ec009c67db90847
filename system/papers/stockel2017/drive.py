"""Runs of Bug robots with networks by number, as the campaigns of Stöckel 2017 keep them.

Of each run its statements' numbers are kept; of those that a picture shows the path too. What all runs of a
map share, its shortest path and the way of Bug 0's program, is found again where it is needed.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from importlib.metadata import version
from typing import TypeVar

import numpy as np
from matplotlib.axes import Axes

from circuits.arrays import F64
from circuits.silicon.die import Die
from system.bug.path import median_distance
from system.bug.picture import draw_paths, draw_shortest, draw_world
from system.bug.run import Trace, run
from system.bug.scenario import Scenario
from system.papers.stockel2017.fig6 import AWAY, repeats
from system.papers.stockel2017.fig6 import MAP as SPIRAL
from system.study.campaign import Campaign, Numbered

EVERY = 10  # steps of 10 ms between two points of a path that is kept; ours
NULLS = ("never moves", "always reaches the goal")
Condition = TypeVar("Condition")


@dataclass(frozen=True, slots=True)
class Drive:
    """A run.

    repeats: of Bug 0 on `bug-spiral`, whether it repeats its way; apart: of Bug 0, median distance of its
    path from its program's, map units; dropped: spikes that its chip lost; path: every `EVERY` steps, map
    units, empty unless it is shown.
    """

    reached: bool
    repeats: bool | None = None
    apart: float | None = None
    dropped: int = 0
    path: tuple[tuple[float, float], ...] = ()


@dataclass(frozen=True, slots=True)
class Drives:
    """Drives the scenario of a key's condition with the network, and on the die, of its number.

    shown: number from which on paths are not kept.
    """

    scenarios: Mapping[str, Scenario]
    shown: int

    def __call__(self, key: Numbered) -> Drive:
        """Drive once."""
        base = self.scenarios[key.condition]
        die = Die(number=key.number) if base.brain == "chip" else base.die
        return kept(run(replace(base, seed=key.number, die=die)), with_path=key.number < self.shown)

    def campaign(self, name: str) -> Campaign[Numbered, Drive]:
        """All of them under a name."""
        numbers = (version("noctule"), *self.scenarios.items(), self.shown)
        return Campaign(name, self, Numbered, Drive, numbers)


def null_drives(found: Mapping[Condition, Sequence[Drive]]) -> dict[str, dict[Condition, list[Drive]]]:
    """Runs of robots that know nothing, in the place of those of networks, by their names.

    One stands at the start, which is on every way, and so repeats its own; one is always at the goal.
    """
    still = {key: [_null(d, reached=False) for d in runs] for key, runs in found.items()}
    there = {key: [_null(d, reached=True) for d in runs] for key, runs in found.items()}
    return dict(zip(NULLS, (still, there), strict=True))


def _null(drive: Drive, *, reached: bool) -> Drive:
    """A run that stays at the goal, far from the program's way, or at its start."""
    again = None if drive.repeats is None else not reached
    apart = None if drive.apart is None else AWAY if reached else 0.0
    return replace(drive, reached=reached, repeats=again, apart=apart)


def kept(trace: Trace, *, with_path: bool) -> Drive:
    """What is kept of a run."""
    s, path = trace.scenario, trace.path
    bug0 = s.agent == "bug0"
    return Drive(
        bool(trace.reached),
        bool(repeats(trace)) if bug0 and s.map == SPIRAL else None,
        median_distance(path, program(s.map, s.duration).path) if bug0 else None,
        (trace.chip or {}).get("dropped", 0),
        tuple((x, y) for x, y in np.round(path[::EVERY], 4).tolist()) if with_path else (),
    )


@lru_cache(maxsize=4)
def program(world: str, duration: float, agent: str = "bug0") -> Trace:
    """Run an agent's program on a map, at most so many seconds."""
    return run(Scenario(agent, map=world, duration=duration))


def draw_ways(first: Trace, paths: Mapping[str, F64], ax: Axes) -> None:
    """Draw paths by their labels into the world of a program's run, with the shortest path."""
    draw_world(first.world, ax)
    draw_shortest(first.shortest, ax)
    draw_paths(paths, ax)
