"""Figure 7 of Stöckel 2017: states over time of the two Bug 2 of Figure 6.

The program and a network of Bug 2 drive on the map of Figure 6, and their states over time are compared with
the paper's words: the neurons take significant time to memorise directions and distances, which the program
does at once, so that they arrive later. The program has no phase of its own for it: 0 s.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
from matplotlib.figure import Figure

from circuits.arrays import I64
from system.bug.body import STEP
from system.bug.brain import FOLLOW, GO, MEMORISE, STATES, STORE
from system.bug.neural2 import AFTER
from system.bug.run import Trace, run
from system.bug.scenario import Scenario
from system.experiment import Experiment, Progress, Report
from system.papers.stockel2017.fig6 import DURATION, MAP
from system.plot import COLOURS, PALE
from system.rule import Judged, Rule, Value, above, equal, shown_of
from system.statement import Statement
from system.verdict.null import Null, nulls_of, shuffled

SEED = 1000
STILL, DRAWN = "never changes its state", "states drawn anew"
NULLS = (STILL, DRAWN)


def reproduce(progress: Progress) -> Report:
    """Drive the program and the neurons on one map."""
    program = run(Scenario("bug2", "reference", map=MAP, duration=DURATION))
    neurons = run(Scenario("bug2", "ideal", map=MAP, seed=SEED, duration=DURATION), progress)
    progress(1.0)
    return Report(
        rows(program, neurons), lambda figure: _draw(program, neurons, figure), nulls=_nulls(program, neurons)
    )


def _nulls(program: Trace, neurons: Trace) -> tuple[Null, ...]:
    """Robots that stay in their first state and do not arrive, and stays in an order that means nothing."""
    pair = program, neurons
    still = [replace(t, state=np.full_like(t.state, t.state[0]), reached=False) for t in pair]
    ends = [np.flatnonzero(np.diff(t.state)) + 1 for t in pair]
    stays = [np.split(t.state, end) for t, end in zip(pair, ends, strict=True)]

    def drawn(order: I64) -> list[Trace]:
        orders = [[k for k in order if k < len(each)] for each in stays]
        return [
            replace(t, state=np.concatenate([each[k] for k in mine]))
            for t, each, mine in zip(pair, stays, orders, strict=True)
        ]

    return (
        *nulls_of(lambda both: rows(*both), {STILL: still}),
        shuffled(DRAWN, lambda both: rows(*both), drawn, max(len(each) for each in stays)),
    )


def order(trace: Trace) -> list[str]:
    """List the states of a run as they follow each other."""
    return [STATES[k] for k in trace.state[np.diff(trace.state, prepend=-1) != 0]]


def spent(trace: Trace, *states: str) -> float:
    """Give the time spent in these states, s."""
    return STEP * float(np.isin(trace.state, [STATES.index(s) for s in states]).sum())


def in_order(states: list[str]) -> bool:
    """Tell whether states begin with memorising, and each is the one that comes after the last."""
    return states[:1] == [MEMORISE] and all(AFTER[a] == b for a, b in pairwise(states))


def _each_follows(ours: Judged, paper: Value) -> bool:
    """Whether states in words are in order, and at least as many as the paper's."""
    found, cycle = (str(shown_of(x)).split() for x in (ours, paper))
    return in_order(found) and len(found) >= len(cycle)


FOLLOWING = Rule("each after the one before it", None, _each_follows)


def rows(program: Trace, neurons: Trace) -> tuple[Statement, ...]:
    """Make the statements of the figure."""
    found, cycle = order(neurons), [MEMORISE, GO, STORE, FOLLOW, GO]
    later = above(0.0).unless(not (neurons.reached and program.reached), "one of them does not arrive")
    learning = [spent(t, MEMORISE, STORE) for t in (program, neurons)]
    return (
        Statement("states_of_neurons", " ".join(cycle), " ".join(found), FOLLOWING),
        Statement("states_of_program", f"{GO} {FOLLOW} {GO}", " ".join(order(program)), equal()),
        Statement(
            "neurons_memorise_s",
            "longer than the program",
            learning[1],
            above(learning[0], "above {limit:g} s"),
        ),
        Statement("neurons_arrive_later_s", "later", neurons.time - program.time, later),
    )


def _draw(program: Trace, neurons: Trace, figure: Figure) -> None:
    """A bar for each stay in a state, beside it the time spent there in all."""
    figure.set_size_inches(7.0, 4.2)
    axes = figure.subplots(2, 1, sharex=True)
    for ax, trace, name in zip(axes, (program, neurons), ("program", "neurons"), strict=True):
        time = STEP * np.arange(len(trace.state) + 1)
        ends = [*np.flatnonzero(np.diff(trace.state, prepend=-1)), len(trace.state)]
        ax.step(time[:-1], trace.state, color=PALE, where="post", linewidth=1.0)
        for begin, end in pairwise(ends):
            k = int(trace.state[begin])
            ax.plot(time[[begin, end]], [k, k], color=COLOURS[k], linewidth=7, solid_capstyle="butt")
        beside = {"xycoords": ax.get_yaxis_transform(), "fontsize": 8}
        for k, state in enumerate(STATES):
            ax.annotate(f"{spent(trace, state):.1f} s", (1.02, k), va="center", **beside)
        ax.annotate("in all", (1.02, -0.6), va="bottom", **beside)
        ax.set_yticks(range(len(STATES)), STATES)
        ax.set_ylim(len(STATES) - 0.4, -0.6)
        ax.set_title(f"{name}: {trace.ended} after {trace.time:.1f} s", fontsize=9)
    axes[-1].set_xlabel("time (s)")


EXPERIMENT = Experiment(
    "stockel2017-fig7", "states of Bug 2 over time: neurons take time to memorise", reproduce, nulls=NULLS
)
