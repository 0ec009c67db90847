"""An experiment in which a ROLLS chip learns to tell two patterns of mean rates; every number is ours.

64 plastic columns reach two populations of 16 neurons, one a class. A pattern is which 32 of the columns are
active, drawn at random for either class; a presentation of it is jittered: each column is flipped with a
small probability, its rate multiplied by a lognormal factor, its events Poisson.

While a pattern is taught, the population of its class gets teacher events on virtual synapses, so that it
fires with its membranes high and its active synapses go up; the other one gets inhibition and a few strong
events, so that it fires now and then from low membranes and its active synapses go down. In a test there are
neither, and the weights are held by giving both moves fine code 0, as the software's default file has them;
the class is that of the population that spikes more.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from chips.rolls.chip import NO_INPUTS, ChipState, Inputs, RollsChip
from chips.rolls.plastic.biases import LEARNING_CODES, MOVES, with_learning
from chips.rolls.plastic.circuit import Learning
from chips.rolls.plastic.program import PlasticArray
from chips.rolls.program.address import NEURONS, NONPLASTIC, VIRTUAL_EXCITATORY
from chips.rolls.program.bias_file import BiasTable
from chips.rolls.program.program import Program, VirtualInput
from chips.rolls.setups.populations import QUIET, table
from circuits.arrays import F32, F64, I64, Bools
from circuits.blocks.rolls.bias import Code
from circuits.circuit import BiasKind
from circuits.errors import ParameterError
from circuits.silicon.silicon import Silicon
from circuits.units import quantity

FIRST_COLUMN = 192  # of the plastic columns that carry a pattern: their neurons get no input
BACKGROUND, VETO = 128, 129  # presynaptic neurons whose columns bring strong events, and inhibition
TEACHER = "teacher"
CLASSES = 2
_SLOW: Code = (7, 60)  # code of a filter's leak and gain: 11 ms
CODES = QUIET | dict.fromkeys(("VDPIE_TAU_P", "VDPIE_THR_P", "NPDPII_TAU_P", "NPDPII_THR_P"), _SLOW)
CODES |= dict.fromkeys(("NPDPIE_TAU_P", "NPDPIE_THR_P"), (6, 100))
WEIGHTS = {"VA_EXC_N": 40e-9, "NPA_WEIGHT_EXC_P": 200e-9, "NPA_WEIGHT_INH_N": 20e-9}  # A
SETTLING = 1.0  # s after the teaching, in which every weight drifts to a rail


@dataclass(frozen=True, slots=True)
class Task:
    """Sizes, rates and times of the experiment.

    jitter: standard deviation of the logarithm of a column's rate; flipped: share of columns that are
    flipped.
    """

    columns: int = quantity(64, "")
    population: int = quantity(16, "")
    active: int = quantity(32, "")
    high: float = quantity(50.0, "Hz")
    low: float = quantity(5.0, "Hz")
    jitter: float = quantity(0.2, "")
    flipped: float = quantity(0.05, "")
    teacher: float = quantity(400.0, "Hz")
    background: float = quantity(35.0, "Hz")
    veto: float = quantity(400.0, "Hz")
    presentation: float = quantity(0.4, "s")
    pause: float = quantity(0.1, "s")
    training: int = quantity(40, "")
    tests: int = quantity(40, "")

    def __post_init__(self) -> None:
        if not 1 <= self.columns <= NEURONS - FIRST_COLUMN:
            raise ParameterError(f"task.columns: {self.columns}, must be 1 to {NEURONS - FIRST_COLUMN}")
        if not 1 <= self.population <= BACKGROUND // CLASSES:
            raise ParameterError(f"task.population: {self.population}, must be 1 to {BACKGROUND // CLASSES}")
        if not 1 <= self.active <= self.columns:
            raise ParameterError(f"task.active: {self.active}, must be 1 to {self.columns}, the columns")

    def neurons(self, which: int) -> range:
        """Return the neurons of a class."""
        return range(which * self.population, (which + 1) * self.population)

    def everyone(self) -> I64:
        """Return the neurons of both classes."""
        return np.arange(CLASSES * self.population)


@dataclass(frozen=True, slots=True)
class Answers:
    """Tests one after another: the class shown, int64[tests], and all rates, Hz, float64[tests, 256]."""

    shown: I64
    rates: F64
    lost: int

    def right(self, task: Task) -> Bools:
        """Return whether the population of the class spiked more, bool[tests]."""
        sums = np.stack([self.rates[:, list(task.neurons(c))].sum(axis=1) for c in range(CLASSES)])
        each = np.arange(self.shown.size)
        return np.asarray(sums[self.shown, each] > sums[1 - self.shown, each])

    def pairs_right(self, task: Task) -> float:
        """Return the share of tests that one neuron of each population gets right, the mean over pairs.

        A tie counts half.
        """
        first, second = (self.rates[:, list(task.neurons(c))] for c in range(CLASSES))
        gap = np.where(self.shown == 0, 1.0, -1.0)[:, None] * (first - second)
        return float(np.mean((gap > 0.0) + 0.5 * (gap == 0.0)))


def learning_biases() -> BiasTable:
    """Return biases to learn with."""
    return with_learning(table(CODES, WEIGHTS), LEARNING_CODES)


def held(biases: BiasTable) -> BiasTable:
    """Return the biases with both moves off, so that weights only drift to their rails."""
    for name in MOVES:
        biases = biases.with_code(name, 7, 0)
    return biases


def patterns(task: Task, seed: int) -> tuple[Bools, Bools]:
    """Return which columns are active in the pattern of each class."""
    draw = np.random.default_rng((seed, 0))
    found = np.zeros((CLASSES, task.columns), np.bool_)
    for pattern in found:
        pattern[draw.permutation(task.columns)[: task.active]] = True
    return found[0], found[1]


def learning_program(task: Task, seed: int, biases: BiasTable) -> Program:
    """Return the program; half of the weights, drawn at random, are high to begin with."""
    out, columns = task.everyone(), FIRST_COLUMN + np.arange(task.columns)
    latches = np.zeros((NEURONS, NEURONS), np.bool_)
    latches[np.ix_(out, columns)] = True
    start = latches & (np.random.default_rng((seed, 1)).random(latches.shape) < 0.5)
    levels = np.zeros((NEURONS, NEURONS), np.int8)
    levels[out, BACKGROUND], levels[out, VETO] = 1, -1
    inputs = (VirtualInput(TEACHER, tuple(out.tolist())),)
    return Program(levels, biases, inputs=inputs, plastic=PlasticArray(latches, start))


def presentation(
    task: Task, pattern: Bools, taught: int | None, start: float, draw: np.random.Generator
) -> Inputs:
    """Return the events of one presentation that begins at `start` s; taught: the class, None in a test."""
    active = pattern ^ (draw.random(task.columns) < task.flipped)
    rates = np.where(active, task.high, task.low) * np.exp(task.jitter * draw.standard_normal(task.columns))
    times, columns = _poisson(rates, start, task.presentation, draw)
    everyone = task.everyone()
    each = everyone.size
    parts = [(np.repeat(times, each), np.tile(everyone, times.size), FIRST_COLUMN + np.repeat(columns, each))]
    if taught is not None:
        own, other = task.neurons(taught), task.neurons(1 - taught)
        for group, rate, column in (
            (own, task.teacher, VIRTUAL_EXCITATORY),
            (other, task.background, NONPLASTIC + BACKGROUND),
            (other, task.veto, NONPLASTIC + VETO),
        ):
            when, who = _poisson(np.full(len(group), rate), start, task.presentation, draw)
            parts.append((when, who + group.start, np.full(who.size, column)))
    t, n, c = (np.concatenate(each) for each in zip(*parts, strict=True))
    order = np.argsort(t, kind="stable")
    return Inputs(t[order], n[order], c[order])


def _poisson(rates: F64, start: float, length: float, draw: np.random.Generator) -> tuple[F64, I64]:
    """Times, not in order, and which of the trains."""
    counts = draw.poisson(rates * length)
    which = np.repeat(np.arange(rates.size), counts)
    return start + length * draw.random(which.size), which


def teach(chip: RollsChip, task: Task, state: ChipState, seed: int, count: int) -> tuple[ChipState, Answers]:
    """Teach the patterns in turn, `count` times; return the state, and what was answered meanwhile."""
    return _present(chip, task, state, seed, count, teaching=True)


def ask(chip: RollsChip, task: Task, state: ChipState, seed: int, count: int) -> Answers:
    """Show the patterns in turn without a teacher, `count` times."""
    return _present(chip, task, state, seed, count, teaching=False)[1]


def _present(
    chip: RollsChip, task: Task, state: ChipState, seed: int, count: int, *, teaching: bool
) -> tuple[ChipState, Answers]:
    draw = np.random.default_rng((seed, 2 if teaching else 3))
    shown, known = np.arange(count) % CLASSES, patterns(task, seed)
    rates, lost = np.zeros((count, NEURONS)), 0
    for k, which in enumerate(shown.tolist()):
        events = presentation(task, known[which], which if teaching else None, state.time, draw)
        spikes, state = chip.run(state, task.presentation, events)
        rates[k] = np.bincount(spikes.neurons, minlength=NEURONS) / task.presentation
        lost += spikes.lost_in + spikes.lost_out
        _, state = chip.run(state, task.pause)
    return state, Answers(shown, rates, lost)


def chips_of(
    task: Task, silicon: Silicon, kind: BiasKind, seed: int, learning: Learning | None = None
) -> tuple[RollsChip, RollsChip]:
    """Return the chip as it learns, and as it is tested, with the moves off."""
    program = learning_program(task, seed, learning_biases())
    chosen = Learning() if learning is None else learning
    still = replace(program, biases=held(program.biases))
    one, other = (RollsChip(each, silicon, kind, learning=chosen) for each in (program, still))
    return one, other


@dataclass(frozen=True, slots=True)
class Lesson:
    """What a chip did that was taught: tests before, after with held weights, and after while it learns on.

    weights: of the latched synapses after the teaching, V, float32[neurons, columns]; start, bits, later: as
    bits, before it, after it, and after a silence; spikes: of the first tests after it, at times from 0 s.
    """

    before: Answers
    after: Answers
    learning: Answers | None
    weights: F32
    start: Bools
    bits: Bools
    later: Bools
    spikes: tuple[F64, I64]


def lesson(
    chips: tuple[RollsChip, RollsChip], task: Task, seed: int, silence: float = 0.0, *, going_on: bool = False
) -> Lesson:
    """Test, teach, and test a chip again.

    chips: as it learns and as it is tested (`chips_of`); silence: s without events after the teaching;
    going_on: whether it is also tested while it learns.
    """
    chip, still = chips
    square = np.ix_(task.everyone(), FIRST_COLUMN + np.arange(task.columns))
    state = chip.at_rest()
    start = chip.weights(state)[square]
    before = ask(still, task, state, seed, task.tests)
    state, _ = teach(chip, task, state, seed, task.training)
    _, state = chip.run(state, SETTLING)
    silent = chip.run(state, silence)[1] if silence > 0.0 else state
    return Lesson(
        before,
        ask(still, task, state, seed, task.tests),
        ask(chip, task, state, seed, task.tests) if going_on else None,
        chip.weight_voltages(state)[square],
        start,
        chip.weights(state)[square],
        chip.weights(silent)[square],
        _shown(still, task, state, seed),
    )


def _shown(chip: RollsChip, task: Task, state: ChipState, seed: int) -> tuple[F64, I64]:
    """Spikes of a test of either class, at times from the first one's beginning."""
    draw, known = np.random.default_rng((seed, 4)), patterns(task, seed)
    begin, times, neurons = state.time, [], []
    for which in range(CLASSES):
        events = presentation(task, known[which], None, state.time, draw)
        for length, given in ((task.presentation, events), (task.pause, NO_INPUTS)):
            spikes, state = chip.run(state, length, given)
            times.append(spikes.times - begin)
            neurons.append(spikes.neurons)
    return np.concatenate(times), np.concatenate(neurons)
