"""Null robots in the place of the Pushbot: what their runs would come to, by the names of a run's summary.

Each takes the place of the robot in every run of an experiment, whose own rules then judge it
(`system.verdict.null`). None of them senses anything.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TypeVar

from system.pushbot.campaign import Summary

Cell = TypeVar("Cell")
Robot = Callable[[Summary], Summary]
Found = Mapping[Cell, Sequence[Summary]]

WAY, TIME = 1.0, 2.0  # m and s until what drives straight on is at its first obstacle, of most scenes; ours


def always(**told: float | None) -> Robot:
    """A robot whose runs all come to this, and else to what ours come to."""
    return lambda summary: summary | told


COLLIDES = always(
    collided=1.0, crossed=0.0, between=0.0, distance_cm=0.0, passed=None, path_m=WAY, time_s=TIME, stood=0.0,
    walked_into=0.0, reached=0.0, touched_block=1.0, touched_robot=0.0, touched_wall=0.0,
    touched_visible=1.0, touched_early=1.0, on_target=None,
)  # fmt: skip
STANDS = always(
    collided=0.0, crossed=0.0, between=0.0, distance_cm=None, passed=None, path_m=0.0, stood=1.0,
    walked_into=0.0, reached=0.0, touched_block=0.0, touched_robot=0.0, touched_wall=0.0,
    touched_visible=0.0, touched_early=0.0, on_target=None,
)  # fmt: skip
ROBOTS: Mapping[str, Robot] = {"always collides": COLLIDES, "never moves": STANDS}


def runs_of(robots: Mapping[str, Robot], found: Found[Cell]) -> dict[str, dict[Cell, list[Summary]]]:
    """The runs of an experiment by its cells, with each null robot in the place of ours, by its name."""
    return {
        name: {cell: [robot(run) for run in runs] for cell, runs in found.items()}
        for name, robot in robots.items()
    }
