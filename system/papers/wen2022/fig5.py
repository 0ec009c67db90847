"""Figure 5 of Wen & Horiuchi 2022: two pings in a scene of six obstacles.

A bat flies straight and pings ahead, with nothing remembered, and what its head and body do is compared with
the paper's words: the first ping detects three
obstacles; the winner is an arc to the middle left, where nothing was sensed yet, so that the head turns, the
body keeps its arc, and the decay of the memory halts; the second ping goes to the middle left, the winner
belongs to it, and the body turns. The places of the obstacles and of the goal are not in the paper's text:
those here are ours, the goal far ahead.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure

from circuits.arrays import F64
from system.experiment import Experiment, Progress, Report, with_progress
from system.openspace.flight import margin_of
from system.openspace.kernel import advance, choose, ping
from system.openspace.law import DIRECTIONS, MIDDLE, Arcs, Bat, arcs_of
from system.openspace.map import Forest, cells_of
from system.openspace.picture import draw_bars, draw_forest, draw_sight
from system.openspace.senses import EXACT
from system.openspace.state import ARC, HEAD, SCANNING, SEEN, WINNER, Flight, X, Y, new_flight
from system.rule import equal
from system.statement import Statement

AT = (25.0, 25.0)  # m; the bat flies left, towards the goal
# m ahead of the bat and to its left; ours
OBSTACLES = ((1.9, -0.25), (2.9, 0.35), (2.3, -1.1), (2.2, 1.9), (0.9, 2.3), (1.2, -2.2))
NAMES = ("left", "middle left", "middle", "middle right", "right")


@dataclass(frozen=True, slots=True)
class Moment:
    """A ping and what followed: pose (m, m, rad), its direction, risks, desirabilities, winner, arc flown."""

    pose: tuple[float, float, float]
    pinged: int
    detected: int
    risk: F64
    wish: F64
    winner: int
    head: int
    arc: int
    scanning: bool


def reproduce(progress: Progress, obstacles: Sequence[tuple[float, float]] = OBSTACLES) -> Report:
    """Two pings."""
    bat = Bat()
    arcs = arcs_of(bat)
    place = np.array([(AT[0] - ahead, AT[1] - left) for ahead, left in obstacles])
    cells = cells_of(Forest("scene", place), margin_of(arcs))
    flight = new_flight(*AT, -math.pi, DIRECTIONS, len(place), 0)
    moments = []
    for _ in with_progress(range(2), progress):
        pose = float(flight.pose[X]), float(flight.pose[Y]), float(flight.pose[2])
        pinged = int(flight.counts[HEAD])
        ping(arcs, EXACT, cells, flight)
        choose(arcs, EXACT, flight)
        moments.append(_moment(pose, pinged, flight))
        advance(arcs, cells, flight)
    first, second = moments
    return Report(rows(first, second, arcs), lambda figure: _draw(bat, arcs, place, moments, figure))


def rows(first: Moment, second: Moment, arcs: Arcs) -> tuple[Statement, ...]:
    """What happens at each ping."""

    def row(name: str, paper: str, ours: str) -> Statement:
        return Statement(name, paper, ours, equal())

    left = "to the left" if arcs.curvature[second.arc] > 0.0 else "not to the left"
    return (
        row("ping_1_detected", "3 obstacles", f"{first.detected} obstacles"),
        row("ping_1_winner", "middle left", NAMES[int(arcs.group[first.winner])]),
        row("ping_1_head_turns_to", "middle left", NAMES[first.head]),
        row("ping_1_body", "keeps its path", "keeps its path" if first.arc == MIDDLE else "turns"),
        row("ping_1_decay", "halted", "halted" if first.scanning else "goes on"),
        row("ping_2_direction", "middle left", NAMES[second.pinged]),
        row("ping_2_winner", "middle left", NAMES[int(arcs.group[second.winner])]),
        row("ping_2_body_turns", "to the left", left if second.arc == second.winner else "not"),
        row("ping_2_decay", "goes on", "halted" if second.scanning else "goes on"),
    )


def _moment(pose: tuple[float, float, float], pinged: int, f: Flight) -> Moment:
    return Moment(
        pose, pinged, int(f.counts[SEEN]), f.risk.copy(), f.wish.copy(), int(f.counts[WINNER]),
        int(f.counts[HEAD]), int(f.counts[ARC]), bool(f.counts[SCANNING]),
    )  # fmt: skip


def _draw(bat: Bat, arcs: Arcs, place: F64, moments: Sequence[Moment], figure: Figure) -> None:
    """Scene, memory and desirability, a column a ping."""
    figure.set_size_inches(8.0, 7.2)
    axes = figure.subplots(3, 2, height_ratios=(2.2, 1.0, 1.0))
    for k, (moment, column) in enumerate(zip(moments, axes.T, strict=True)):
        draw_forest(place, bat.zone, column[0])
        draw_sight(bat, arcs, moment.pose, moment.pinged, moment.arc, column[0])
        column[0].set(xlim=(AT[0] - 5.4, AT[0] + 0.6), ylim=(AT[1] - 3.2, AT[1] + 3.2))
        column[0].set_title(f"ping {k + 1}, {NAMES[moment.pinged]}", fontsize=9)
        draw_bars(moment.risk, arcs, "risk", column[1])
        draw_bars(moment.wish, arcs, "desirability", column[2], moment.winner)
        column[2].set_xlabel("arc, 0 to the left; colours: ping directions", fontsize=8)
    handles, labels = axes[0, 0].get_legend_handles_labels()
    winner = axes[2, 0].get_legend_handles_labels()
    entries = [*handles, *winner[0]], [*labels, *winner[1]]
    figure.legend(*entries, loc="outside lower center", ncols=3, fontsize=8)


EXPERIMENT = Experiment("wen2022-fig5", "two pings among six obstacles: head first, then body", reproduce)
