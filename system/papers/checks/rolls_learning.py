"""A ROLLS chip learns two patterns of mean rates, at least nine of ten held-out presentations told right.

No figure of a paper. Dies are taught and tested, and the share of presentations that each tells right, its
weights, and the moves of weights in its steps and in transistors are compared with limits of ours. Two
populations of 16 neurons with 64 plastic inputs each (`chips.rolls.setups.learning`, numbers chosen on
dies below 1000) are taught 40 jittered presentations and tested on 40 others without a teacher, weights held;
every die has patterns, first weights and events of its own, by its number. Rules, stated before the dies from
1000 on were run:

* at least 90 % told right over 20 dies with ideal biases;
* at least 99 % of the weights within 50 mV of a rail a second after the teaching, and all weights as they
  were after 100 s of silence;
* a weight with its learning circuit at transistor level, driven by the same random spikes on ten dies from 0
  to 50 degC, is moved by the same events as in the chip's steps, 95 % of them at least
  (`chips.rolls.plastic.reference`).

Without a rule: before the teaching, while learning goes on in the tests, fixed gates, and the share that one
neuron of either population tells right with all mismatch, with that of one group of devices, and with none.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from importlib.metadata import version

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from chips.rolls.chip import STEP, RollsChip
from chips.rolls.plastic.reference import Stimulus, moves, simulated, stepped
from chips.rolls.setups.learning import CLASSES, Lesson, Task, chips_of, lesson
from chips.rolls.setups.learning_groups import GROUPS, of_group
from circuits.silicon.die import Die
from circuits.silicon.process import ROLLS_180_IDEAL
from circuits.silicon.silicon import Silicon
from system.experiment import Experiment, Progress, Report
from system.plot import COLOURS, INK
from system.rule import all_of, at_least, unjudged
from system.statement import Statement
from system.study.campaign import ALONE, Campaign, Execution, Numbered

FIRST_DIE, DIES = 1000, 20
GATE_DIES = 10
SILENCE = 100.0  # s
RIGHT, AT_RAILS, ALIKE = 0.9, 0.99, 0.95
NEAR = 0.05  # V
TASK = Task()
TEMPERATURES = (0.0, 27.0, 50.0)  # degC, of the transistor level
PAIRS = 10  # dies of it
LIMIT = 1.8  # V
IDEAL, GATES, TRANSISTORS = "ideal", "gates", "transistors"


@dataclass(frozen=True, slots=True)
class Agreement:
    """How well the chip's steps agree with the transistors on a die.

    `alike` of `events` move the weight alike; `error` (rms) and `worst` are of the weight's voltage, V.
    """

    alike: int
    events: int
    error: float  # root of the mean square
    worst: float


@dataclass(frozen=True, slots=True)
class Taught:
    """Of a die: its lesson, what pairs of neurons tell right by groups of devices, and the transistor level.

    What was not asked for is None, or empty.
    """

    lesson: Lesson | None = None
    shares: dict[str, float] = field(default_factory=dict)
    agreement: Agreement | None = None


@dataclass(frozen=True, slots=True)
class Lessons:
    """Teaches the die of a key's number: with ideal biases or fixed gates, or at transistor level."""

    task: Task

    def __call__(self, key: Numbered) -> Taught:
        """Teach once."""
        die, task = key.number, self.task
        if key.condition == TRANSISTORS:
            return Taught(agreement=agreement(die, TEMPERATURES[(die - FIRST_DIE) % len(TEMPERATURES)]))
        if key.condition == GATES:
            return Taught(lesson(chips_of(task, silicon_of(die), "gate", die), task, die))
        chips = chips_of(task, silicon_of(die), "ideal", die)
        taught = lesson(chips, task, die, SILENCE, going_on=True)
        return Taught(taught, dict(group_shares(chips, task, die)))


def reproduce(
    progress: Progress,
    execution: Execution = ALONE,
    dies: int = DIES,
    gate_dies: int = GATE_DIES,
    pairs: int = PAIRS,
    task: Task = TASK,
) -> Report:
    """All dies, of which some with fixed gates, groups of devices, and the transistor level on `pairs`."""
    counts = {IDEAL: dies, GATES: gate_dies, TRANSISTORS: pairs}
    keys = [Numbered(name, FIRST_DIE + k) for name, count in counts.items() for k in range(count)]
    numbers = (version("noctule"), task, SILENCE, GROUPS, TEMPERATURES)
    campaign = Campaign(EXPERIMENT.name, Lessons(task), Numbered, Taught, numbers)
    found = execution.by_condition(campaign, keys, progress)
    lessons, fixed = ([x.lesson for x in found.get(n, ()) if x.lesson is not None] for n in (IDEAL, GATES))
    agreed = [x.agreement for x in found.get(TRANSISTORS, ()) if x.agreement is not None]
    shares = {name: [x.shares[name] for x in found[IDEAL]] for name in ("none", *GROUPS)}
    rows = (
        *_told(lessons, task),
        *_weights(lessons),
        *_beside(lessons, fixed, shares, task),
        *_alike(agreed),
    )
    return Report(rows, lambda figure: _draw(lessons, shares, task, figure), _notes(lessons, task))


def silicon_of(die: int, *, mismatch: bool = True, temperature_c: float = 27.0) -> Silicon:
    """Give a die with or without its local mismatch."""
    return Silicon(ROLLS_180_IDEAL, temperature_c, Die(number=die, mismatch=mismatch))


def group_shares(chips: tuple[RollsChip, RollsChip], task: Task, die: int) -> Mapping[str, float]:
    """Give the share that pairs of neurons tell right on a die, by the group of devices with mismatch."""
    plain = chips_of(task, silicon_of(die, mismatch=False), "ideal", die)
    found = {"none": lesson(plain, task, die).after.pairs_right(task)}
    for group in GROUPS:
        mixed = [
            a.with_tables(of_group(group, a.built(), b.built())) for a, b in zip(plain, chips, strict=True)
        ]
        found[group] = lesson((mixed[0], mixed[1]), task, die).after.pairs_right(task)
    return found


def agreement(die: int, temperature_c: float) -> Agreement:
    """Compare the transistor level with the chip's steps, driven by the same random spikes."""
    draw, step = np.random.default_rng(die), STEP
    # events and spikes in the middle of steps: the chip takes both at their beginnings
    at = step * (0.5 + draw.choice(np.arange(10, 1000), 90, replace=False))
    membrane = tuple((0.05 * k, (0.1, 0.45)[int(draw.integers(2))]) for k in range(8))
    s = Stimulus(tuple(np.sort(at[:50])), tuple(np.sort(at[50:])), membrane, 1010 * step)
    silicon = silicon_of(die, temperature_c=temperature_c)
    ours, times = stepped(s, silicon, "ideal")
    theirs = simulated(s, silicon, "ideal", times)
    pairs = zip(
        moves(ours.tolist(), times, s.events, step),
        moves(theirs.tolist(), times, s.events, step),
        strict=True,
    )
    off = ours - theirs
    alike = sum(a == b for a, b in pairs)
    return Agreement(alike, len(s.events), float(np.sqrt(np.mean(off**2))), float(np.abs(off).max()))


def _told(lessons: Sequence[Lesson], task: Task) -> tuple[Statement, ...]:
    after = float(np.mean([x.after.right(task) for x in lessons]))
    return (
        Statement("share of held-out presentations told right", None, after, at_least(RIGHT)),
        _open("the same before the teaching", float(np.mean([x.before.right(task) for x in lessons]))),
        _open("the worst die", float(min(x.after.right(task).mean() for x in lessons))),
    )


def _weights(lessons: Sequence[Lesson]) -> tuple[Statement, ...]:
    volts = np.concatenate([x.weights.ravel() for x in lessons])
    near = float(np.mean((volts < NEAR) | (volts > LIMIT - NEAR)))
    kept = float(np.mean([np.mean(x.bits == x.later) for x in lessons]))
    moved = float(np.mean([np.mean(x.bits != x.start) for x in lessons]))
    return (
        Statement("share of weights within 50 mV of a rail", None, near, at_least(AT_RAILS)),
        Statement("share of weights unchanged after 100 s of silence", None, kept, all_of(1.0)),
        _open("share of weights that the teaching changed", moved),
    )


def _beside(
    lessons: Sequence[Lesson], fixed: Sequence[Lesson], shares: Mapping[str, Sequence[float]], task: Task
) -> tuple[Statement, ...]:
    rows = []
    going_on = [x.learning.right(task) for x in lessons if x.learning is not None]
    if going_on:
        rows.append(_open("told right while learning goes on in the tests", float(np.mean(going_on))))
    if fixed:
        rows.append(
            _open("told right with fixed gates", float(np.mean([x.after.right(task) for x in fixed])))
        )
    rows.append(_open("told right by one neuron of either population", float(np.mean(_pairs(lessons, task)))))
    rows += [_open(f"the same, mismatch of {name}", float(np.mean(each))) for name, each in shares.items()]
    return tuple(rows)


def _alike(agreed: Sequence[Agreement]) -> tuple[Statement, ...]:
    if not agreed:
        return ()
    share = sum(a.alike for a in agreed) / sum(a.events for a in agreed)
    return (
        Statement("events that move a weight as the transistors do", None, share, at_least(ALIKE)),
        _open(
            "error of a weight's voltage_V, median rms of the dies",
            float(np.median([a.error for a in agreed])),
        ),
    )


def _pairs(lessons: Sequence[Lesson], task: Task) -> list[float]:
    return [x.after.pairs_right(task) for x in lessons]


def _open(name: str, ours: float) -> Statement:
    return Statement(name, None, ours, unjudged())


def _notes(lessons: Sequence[Lesson], task: Task) -> tuple[str, ...]:
    low = {FIRST_DIE + k: float(x.after.right(task).mean()) for k, x in enumerate(lessons)}
    text = ", ".join(f"{die} {share:.3g}" for die, share in low.items() if share < RIGHT)
    lost = sum(each.lost for x in lessons for each in (x.before, x.after))
    return (f"Dies below 90 %: {text or 'none'}.", f"Events and spikes that a bus lost: {lost}.")


def _draw(
    lessons: Sequence[Lesson], shares: Mapping[str, Sequence[float]], task: Task, figure: Figure
) -> None:
    figure.set_size_inches(9.0, 7.0)
    axes = figure.subplots(2, 2)
    _draw_weights(lessons, axes[0, 0])
    _draw_rates(lessons, task, axes[0, 1])
    _draw_raster(lessons[0], task, axes[1, 0])
    names = ["all", *shares]
    values = [_pairs(lessons, task), *shares.values()]
    ax = axes[1, 1]
    ax.barh(range(len(names)), [100.0 * (1.0 - np.mean(v)) for v in values], 0.7, color=COLOURS[0])
    ax.set_yticks(range(len(names)), names, fontsize=8)
    ax.invert_yaxis()
    ax.set(xlabel="told wrong by one neuron of either population (%)", ylabel="mismatch of")


def _draw_weights(lessons: Sequence[Lesson], ax: Axes) -> None:
    volts = np.concatenate([x.weights.ravel() for x in lessons])
    ax.hist(volts, bins=60, range=(0.0, LIMIT), color=COLOURS[0])
    ax.set(
        yscale="log",
        ylim=(0.5, None),
        xlabel="weight a second after the teaching (V)",
        ylabel="weights of all dies",
    )


def _draw_rates(lessons: Sequence[Lesson], task: Task, ax: Axes) -> None:
    """Mean rate of the population of the class shown over that of the other one, a mark a die and class."""
    for which in range(CLASSES):
        own, other = [], []
        for x in lessons:
            rates = x.after.rates[x.after.shown == which]
            own.append(rates[:, list(task.neurons(which))].mean())
            other.append(rates[:, list(task.neurons(1 - which))].mean())
        ax.plot(other, own, "os"[which], color=COLOURS[which], markersize=5, label=f"class {'AB'[which]}")
    top = ax.get_ylim()[1]
    ax.plot((0.0, top), (0.0, top), color=INK, linewidth=0.7, linestyle="--")
    ax.set(xlabel="mean rate of the other population (Hz)", ylabel="of the class shown (Hz)")
    ax.legend(fontsize=8)


def _draw_raster(x: Lesson, task: Task, ax: Axes) -> None:
    times, neurons = x.spikes
    for which in range(CLASSES):
        mine = np.isin(neurons, list(task.neurons(which)))
        ax.plot(1e3 * times[mine], neurons[mine], "|", color=COLOURS[which], markersize=4)
        begin = 1e3 * which * (task.presentation + task.pause)
        ax.axvspan(begin, begin + 1e3 * task.presentation, color=COLOURS[which], alpha=0.08)
    ax.set(
        ylim=(-1.0, CLASSES * task.population),
        xlabel=f"time (ms); die {FIRST_DIE}, class A shown, then B",
        ylabel="neuron",
    )


EXPERIMENT = Experiment(
    "rolls-learning",
    "ROLLS: two patterns of mean rates learned by plastic synapses",
    reproduce,
    {"dies": DIES, "gate_dies": GATE_DIES, "pairs": PAIRS},
)
