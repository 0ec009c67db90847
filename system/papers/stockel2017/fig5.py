"""Figure 5 of Stöckel 2017: the state machine of Bug 2 under a train of pulses.

The network of the state machine is run, and the states that it takes are compared with the paper's words: at
a rising edge of the input the machine goes to the next state, and to no other until the input was low; the
old state follows while the input is low and is kept while it is high; the output is delayed. The pulses are
ours, of half a second, one a second, so that it goes from memorise through go, store and follow back to go;
and so is the network's seed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure

from chips.nef.build import build
from chips.nef.network.curves import IdealCurves
from chips.nef.network.memory import state_machine, states
from chips.nef.network.network import Connection, Network, Node, Probe, join
from chips.nef.simulation import Simulation
from circuits.arrays import F64
from system.bug.brain import STATES
from system.bug.neural2 import AFTER, PUBLISHED
from system.experiment import Experiment, Progress, Report
from system.plot import COLOURS, INK, PALE
from system.rule import above, below, equal
from system.statement import Statement

SEED, PULSES, PERIOD, HIGH = 1000, 6, 1.0, 0.5  # s
SAMPLE = 0.01  # s
SETTLING = 0.3  # s in the first state, before time 0
FOLLOWS = ["memorise", "go", "store", "follow", "go", "store", "follow"]


@dataclass(frozen=True, slots=True)
class Course:
    """What happened.

    time: float64[n], s; trigger: float64[n], the input; old, current: float64[n, 2]; active, inactive:
    float64[n, 4].
    """

    time: F64
    trigger: F64
    old: F64
    current: F64
    active: F64
    inactive: F64


def course(seed: int, pulses: int = PULSES) -> Course:
    """Run the state machine under pulses of its input."""
    run = Simulation(build(_network(), IdealCurves(), seed), SAMPLE)
    run.set("one", 1.0)
    run.set("start", 2.0 * states(len(STATES))[0])
    run.advance(SETTLING)
    run.set("start", 0.0)
    time: F64 = SAMPLE * np.arange(0.0, round((pulses + 0.5) * PERIOD / SAMPLE))
    trigger = np.where((time % PERIOD >= PERIOD - HIGH) & (time < pulses * PERIOD), 1.0, 0.0)
    rows = []
    for value in trigger:
        run.set("input", value)
        run.advance(SAMPLE)
        rows.append([run.read(name) for name in ("old?", "current?", "active?", "inactive?")])
    old, current, active, inactive = (np.array(part) for part in zip(*rows, strict=True))
    return Course(time, trigger, old, current, active, inactive)


def visited(found: Course) -> list[str]:
    """List the states in the order in which they were the most active one."""
    most = found.active.argmax(axis=1)
    begins = np.flatnonzero(np.diff(most, prepend=-1))
    return [STATES[int(most[k])] for k in begins]


def rows(found: Course) -> tuple[Statement, ...]:
    """Make the statements of the figure."""
    order = visited(found)
    edges = int((np.diff(found.trigger) > 0.0).sum())
    kept = _kept(found)
    delay = _delay(found)

    return (
        Statement("order_of_states", " ".join(FOLLOWS[: edges + 1]), " ".join(order), equal()),
        Statement("transitions_a_rising_edge", 1.0, (len(order) - 1) / edges, equal()),
        Statement("old_state_while_input_is_high", "kept", kept, equal()),
        Statement("delay_of_output_s", "delayed", delay, above(0.0) & below(HIGH / 2, "below half a pulse")),
    )


def reproduce(progress: Progress) -> Report:
    """Run the state machine under six pulses."""
    found = course(SEED)
    progress(1.0)
    return Report(rows(found), lambda figure: _draw(found, figure))


def _network() -> Network:
    following = [STATES.index(AFTER[state]) for state in STATES]
    outer = Network(
        nodes=(Node("one", 1), Node("input", 1), Node("start", 2)),
        connections=(
            Connection("input", "state.trigger"),
            Connection("start", "state.old"),
            Connection("start", "state.current"),
        ),
        probes=tuple(
            Probe(f"{part}?", f"state.{part}", synapse=0.02)
            for part in ("old", "current", "active", "inactive")
        ),
    )
    return join((state_machine("state", following, PUBLISHED.machine, states(len(STATES))), outer))


def _kept(found: Course) -> str:
    """Whether the old state at the end of each pulse is still the one that it was before."""
    rises = np.flatnonzero(np.diff(found.trigger) > 0.0)
    falls = np.flatnonzero(np.diff(found.trigger) < 0.0)
    points = states(len(STATES))
    same = [
        np.argmax(points @ found.old[a]) == np.argmax(points @ found.old[b])
        for a, b in zip(rises, falls, strict=True)
    ]
    return "kept" if all(same) else "lost"


def _delay(found: Course) -> float:
    """Median time from a rising edge to the output's next state, s."""
    rises = found.time[1:][np.diff(found.trigger) > 0.0]
    changes = found.time[1:][np.diff(found.active.argmax(axis=1)) != 0]
    after = [float(changes[changes > t][0] - t) for t in rises if (changes > t).any()]
    return float(np.median(after)) if after else float("nan")


def _draw(found: Course, figure: Figure) -> None:
    """Input, inverted output, and the planes of old and current state, time from dark to light."""
    figure.set_size_inches(8.6, 5.2)
    grid = figure.add_gridspec(2, 3, width_ratios=(1.6, 1.0, 1.0))
    top, below = figure.add_subplot(grid[0, 0]), figure.add_subplot(grid[1, 0])
    top.plot(found.time, found.trigger, color=INK)
    top.set_ylabel("input")
    for k, name in enumerate(STATES):
        below.plot(found.time, found.inactive[:, k] - 1.5 * k, color=COLOURS[k], label=name)
    below.set_yticks([-1.5 * k for k in range(len(STATES))], STATES)
    below.set_xlabel("time (s)")
    below.set_title("inverted output: low is active", fontsize=9)
    shade = found.time / found.time[-1]
    for column, (part, name) in enumerate(((found.old, "old state"), (found.current, "current state")), 1):
        ax = figure.add_subplot(grid[:, column])
        ax.plot(*part.T, color=PALE, linewidth=0.6, zorder=1)
        ax.scatter(part[:, 0], part[:, 1], c=shade, cmap="viridis", s=3, zorder=2)
        for point, state in zip(states(len(STATES)), STATES, strict=True):
            ax.annotate(state, 2.7 * point, ha="center", va="center", fontsize=8)
        ax.set(xlim=(-3.4, 3.4), ylim=(-3.4, 3.4), aspect="equal")
        ax.set_title(name, fontsize=9)


EXPERIMENT = Experiment("stockel2017-fig5", "state machine of Bug 2: one transition a rising edge", reproduce)
