"""Figure 6 of Milde et al. 2017: populations and commands as the robot avoids one obstacle.

The robot drives once towards a blue block straight ahead, at speed and turn factor 0.5, on one die and with
one seed. Spikes and commands are compared with the paper's statements: one obstacle population wins and
drives the other side's drive population; the other drive is silent; the robot slows down and turns away; it
does not collide. Half of the free speed is ours.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from circuits.arrays import F64
from circuits.silicon.die import Die
from system.experiment import Experiment, Progress, Report
from system.papers.conditions import IDEAL_CURRENTS
from system.papers.milde2017.picture import draw_trace
from system.pushbot.campaign import FIRST
from system.pushbot.loop import rates
from system.pushbot.run import Trace, run, summarise
from system.pushbot.scenario import Scenario
from system.rule import at_least, at_most, equal, none
from system.statement import Statement
from system.verdict.null import nulls_of

WINS = 5.0  # times the other drive's spikes; ours
SLOW = 0.5  # of the fastest command; ours
NULLS = ("drives straight on", "turns on the spot", "never moves")


@dataclass(frozen=True, slots=True)
class Seen:
    """What the figure shows of a run.

    total: rate of each population over the run, 1/s; forward: commanded speeds, m/s, float64[n]; turned: sum
    of the commanded turns, positive to the left; collided: 1 where it touched something.
    """

    total: Mapping[str, float]
    forward: F64
    turned: float
    collided: float


def reproduce(progress: Progress) -> Report:
    """Drive once towards the block."""
    trace = run(Scenario(seed=FIRST, die=Die(number=FIRST), **IDEAL_CURRENTS), progress)
    notes = (f"Die and seed {FIRST}, window 500 ms, sliding.",)
    found = seen(trace)
    return Report(rows(found), lambda figure: draw_trace(trace, figure), notes, nulls_of(rows, _nulls(found)))


def seen(trace: Trace) -> Seen:
    """Sum up a run."""
    time = float(trace.drive.path[-1][0])
    _, found = rates(trace.brain.network, trace.record, time)
    total = {name: float(r.sum()) for name, r in found.items()}
    forward = np.array([v for _, v, _ in trace.record.commands])
    turned = sum(w for _, _, w in trace.record.commands)
    return Seen(total, forward, turned, float(summarise(trace)["collided"] or 0.0))


def _nulls(found: Seen) -> dict[str, Seen]:
    """Robots whose populations all fire alike, and which drive straight on, turn on the spot, or stand."""
    total, fastest = dict.fromkeys(found.total, 1.0), np.full_like(found.forward, found.forward.max())
    still = np.zeros_like(found.forward)
    ahead = Seen(total, fastest, 0.0, 1.0)
    turns, stands = (Seen(total, still, turned, 0.0) for turned in (1.0, 0.0))
    return dict(zip(NULLS, (ahead, turns, stands), strict=True))


def rows(found: Seen) -> tuple[Statement, ...]:
    """Make the statements that the figure shows."""
    total, forward = found.total, found.forward
    winner, other = ("DL", "DR") if total["DL"] > total["DR"] else ("DR", "DL")
    ahead, behind = ("OR", "OL") if winner == "DL" else ("OL", "OR")
    ratio = total[winner] / max(total[other], 1e-9)
    stronger = ahead if total[ahead] > total[behind] else behind
    slowest = float(forward[len(forward) // 4 :].min() / forward.max()) if forward.max() > 0.0 else None
    sides = {-1.0: "right", 0.0: "neither side", 1.0: "left"}
    return (
        Statement("collided", 0.0, found.collided, none()),
        Statement("winning_drive_over_other", "only one", ratio, at_least(WINS)),
        Statement("stronger_obstacle_drives_it", ahead, stronger, equal("the other side's")),
        Statement("slowest_over_fastest_command", "slows down", slowest, at_most(SLOW)),
        Statement(
            "turns_to",
            "left" if winner == "DL" else "right",
            sides[float(np.sign(found.turned))],
            equal("the winner's side"),
        ),
    )


EXPERIMENT = Experiment(
    "milde2017-fig6", "populations and commands round one obstacle", reproduce, nulls=NULLS
)
