"""Figure 6 of Milde et al. 2017: populations and commands as the robot avoids one obstacle.

The robot drives once towards a blue block straight ahead, at speed and turn factor 0.5, on one die and with
one seed. Spikes and commands are compared with the paper's statements: one obstacle population wins and
drives the other side's drive population; the other drive is silent; the robot slows down and turns away; it
does not collide. Half of the free speed is ours.
"""

from __future__ import annotations

import numpy as np

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

WINS = 5.0  # times the other drive's spikes; ours
SLOW = 0.5  # of the fastest command; ours


def reproduce(progress: Progress) -> Report:
    """Drive once towards the block."""
    trace = run(Scenario(seed=FIRST, die=Die(number=FIRST), **IDEAL_CURRENTS), progress)
    notes = (f"Die and seed {FIRST}, window 500 ms, sliding.",)
    return Report(rows(trace), lambda figure: draw_trace(trace, figure), notes)


def rows(trace: Trace) -> tuple[Statement, ...]:
    """Make the statements that the figure shows."""
    time = float(trace.drive.path[-1][0])
    _, found = rates(trace.brain.network, trace.record, time)
    total = {name: float(r.sum()) for name, r in found.items()}
    winner, other = ("DL", "DR") if total["DL"] > total["DR"] else ("DR", "DL")
    ahead = "OR" if winner == "DL" else "OL"
    ratio = total[winner] / max(total[other], 1e-9)
    forward = np.array([v for _, v, _ in trace.record.commands])
    turned = sum(w for _, _, w in trace.record.commands)
    collided = summarise(trace)["collided"]
    behind = "OL" if ahead == "OR" else "OR"
    stronger = ahead if total[ahead] > total[behind] else behind
    slowest = float(forward[len(forward) // 4 :].min() / forward.max())
    return (
        Statement("collided", 0.0, collided, none()),
        Statement("winning_drive_over_other", "only one", ratio, at_least(WINS)),
        Statement("stronger_obstacle_drives_it", ahead, stronger, equal("the other side's")),
        Statement("slowest_over_fastest_command", "slows down", slowest, at_most(SLOW)),
        Statement(
            "turns_to",
            "left" if winner == "DL" else "right",
            "left" if turned > 0.0 else "right",
            equal("the winner's side"),
        ),
    )


EXPERIMENT = Experiment("milde2017-fig6", "populations and commands round one obstacle", reproduce)
