"""Calibration of a ROLLS chip: bias codes and a blacklist that bring populations to their rates on a die.

What may change is what may change on the chip: the fine and coarse codes of biases, and which neurons a
population does without. A `Knob` is a bias and the populations that it moves; all populations of a knob want
one rate. Codes are searched together: each is moved by secants on (ln I, ln rate) of its populations' middle,
first into the range of currents where they fire, then closer. Then each population drops its worst neurons,
`most` at most, as long as that brings its mean nearer. Rates are measured on the chip as it runs.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from chips.rolls.chip import NO_INPUTS, STEP, Inputs, RollsChip
from chips.rolls.program.address import NEURONS
from chips.rolls.program.bias_file import BiasTable
from chips.rolls.program.population import Population
from chips.rolls.program.program import Program
from circuits.arrays import F64
from circuits.blocks.rolls.bias import Code, current_of
from circuits.circuit import BiasKind
from circuits.errors import ParameterError
from circuits.generator.code import COARSE, CODES
from circuits.silicon.silicon import Silicon

SETTLE, MEASURE = 0.2, 1.0  # s, ours
FARTHEST = 1.5  # in ln I, the largest move of a code
CLOSE = 0.02  # in ln rate, at which a code stays; ours


@dataclass(frozen=True, slots=True)
class Target:
    """A rate that a population shall have.

    rate: mean rate of the neurons of `population`, Hz. Raises `ParameterError` unless it is above 0.
    """

    population: Population
    rate: float

    def __post_init__(self) -> None:
        if not self.rate > 0.0:
            raise ParameterError(f"target.{self.population.name}: {self.rate:g} Hz, must be > 0 Hz")


@dataclass(frozen=True, slots=True)
class Knob:
    """A bias that sets the mean rate of populations.

    bias, populations: their names. slope: 1 where the rate rises with the bias's current, -1 where it falls.
    Raises `ParameterError` for another slope.
    """

    bias: str
    populations: tuple[str, ...]
    slope: int = 1

    def __post_init__(self) -> None:
        if self.slope not in {1, -1}:
            raise ParameterError(f"knob.{self.bias}.slope: {self.slope}, must be 1 or -1")


@dataclass(frozen=True, slots=True)
class Task:
    """What is calibrated, and how it is driven.

    Attributes
    ----------
    program : Program
        Program of the chip.
    targets : tuple of Target
        Rates that populations shall have.
    knobs : tuple of Knob
        Biases that are searched.
    drive : function
        Gives the inputs of a run of a duration (s), the same each time.
    most : int
        How many neurons a population may drop.
    whole : frozenset of str
        Names of populations that keep all of theirs.

    Raises
    ------
    ParameterError
        A knob is of a population without a target.
    """

    program: Program
    targets: tuple[Target, ...]
    knobs: tuple[Knob, ...]
    drive: Callable[[float], Inputs] = lambda _: NO_INPUTS
    most: int = 4
    whole: frozenset[str] = frozenset()

    def __post_init__(self) -> None:
        known = {t.population.name for t in self.targets}
        for knob in self.knobs:
            self.program.biases.code(knob.bias)
            for name in knob.populations:
                if name not in known:
                    raise ParameterError(
                        f"calibration.{knob.bias}: population {name}, must have a target; they are"
                        f" {', '.join(sorted(known))}"
                    )


@dataclass(frozen=True, slots=True)
class Calibration:
    """What a calibration has found.

    biases: those with the codes that were found. blacklist: neurons that each population drops. rates: mean
    rate of each population without its dropped neurons, Hz. before: mean rate of each population at the codes
    that the search began with, Hz. runs: how often the chip was run.
    """

    biases: BiasTable
    blacklist: Mapping[str, tuple[int, ...]]
    rates: Mapping[str, float]
    before: Mapping[str, float]
    runs: int

    def kept(self, population: Population) -> tuple[int, ...]:
        """Return the neurons of a population that are not dropped."""
        return tuple(k for k in population.neurons if k not in self.blacklist[population.name])


def code_for(current: float) -> Code:
    """Return the (coarse, fine) code whose nominal current is nearest to `current` (A), within a percent."""
    reach = [c * (CODES - 1) / CODES for c in COARSE]
    coarse = max((k for k, full in enumerate(reach) if full >= current), default=0)
    fine = round(current * CODES / COARSE[coarse])
    return coarse, min(max(fine, 1), CODES - 1)


def neuron_rates(chip: RollsChip, drive: Callable[[float], Inputs], measure: float = MEASURE) -> F64:
    """Return the rate of every neuron after it has settled, Hz, float64[256].

    Parameters
    ----------
    chip
        The chip.
    drive
        Gives the inputs of a run of a duration, s.
    measure
        How long spikes are counted, s.
    """
    spikes, _ = chip.run(chip.at_rest(), SETTLE + measure, drive(SETTLE + measure))
    late = spikes.times >= SETTLE
    return np.asarray(np.bincount(spikes.neurons[late], minlength=NEURONS) / measure)


def population_rates(
    task: Task, silicon: Silicon, kind: BiasKind = "ideal", step: float = STEP
) -> dict[str, float]:  # fmt: skip
    """Return the mean rate of each population of a task at the codes of its program, Hz, by its name.

    Arguments are those of `calibrate`.
    """
    rates = neuron_rates(RollsChip(task.program, silicon, kind, step=step), task.drive)
    return _means(rates, task)


def _means(rates: F64, task: Task) -> dict[str, float]:
    return {t.population.name: _mean(rates, t.population.neurons, ()) for t in task.targets}


def calibrate(
    task: Task, silicon: Silicon, kind: BiasKind = "ideal", rounds: int = 14, step: float = STEP
) -> Calibration:
    """Search bias codes on one die, then drop neurons.

    Parameters
    ----------
    task
        What is calibrated.
    silicon
        Process, temperature and die of the chip.
    kind
        Kind of its biases.
    rounds
        How often the chip is run at most.
    step
        Step of the chip, s.
    """
    program, given = task.program, task.drive(SETTLE + MEASURE)
    points: dict[str, list[tuple[float, float]]] = {k.bias: [] for k in task.knobs}
    wanted = {t.population.name: t for t in task.targets}
    best, kept, least, runs = program, np.zeros(NEURONS), math.inf, 0
    before: dict[str, float] = {}
    for _ in range(rounds):
        rates = neuron_rates(RollsChip(program, silicon, kind, step=step), lambda _: given)
        runs += 1
        means = _means(rates, task)
        before = before or means
        errors = {k.bias: _error(k, means, wanted) for k in task.knobs}
        worst = max((abs(e) for e in errors.values()), default=0.0)
        if worst < least:
            best, kept, least = program, rates, worst
        if worst < CLOSE:
            break
        program = _moved(program, task.knobs, errors, points)
    dropped = {name: _dropped(kept, t, 0 if name in task.whole else task.most) for name, t in wanted.items()}
    found = {name: _mean(kept, t.population.neurons, dropped[name]) for name, t in wanted.items()}
    return Calibration(best.biases, dropped, found, before, runs)


def _error(knob: Knob, means: Mapping[str, float], wanted: Mapping[str, Target]) -> float:
    """Middle of the ln of rate over target of the knob's populations, -5 for a silent one, by its slope.

    The middle and not the mean: what is left on either side is then least, for neurons to be dropped.
    """
    each = [math.log(max(means[n] / wanted[n].rate, math.exp(-5.0))) for n in knob.populations]
    return knob.slope * 0.5 * (max(each) + min(each))


def _moved(
    program: Program, knobs: Sequence[Knob], errors: Mapping[str, float],
    points: dict[str, list[tuple[float, float]]],
) -> Program:  # fmt: skip
    """Program with the next codes; points: (ln I, error) seen of each bias, added to."""
    table = program.biases
    for knob in knobs:
        code = table.code(knob.bias)
        x, error = math.log(current_of(code)), errors[knob.bias]
        seen = points[knob.bias]
        seen.append((x, error))
        if abs(error) >= CLOSE:
            table = table.with_code(knob.bias, *code_for(math.exp(_next(seen))))
    return replace(program, biases=table)


def _next(seen: Sequence[tuple[float, float]]) -> float:
    """Next ln I: between the nearest points on either side of the target, else beyond the last one."""
    low = max((p for p in seen if p[1] < 0.0), default=None)
    high = min((p for p in seen if p[1] >= 0.0), default=None)
    if low is not None and high is not None and low[0] < high[0]:
        share = -low[1] / (high[1] - low[1])
        return low[0] + min(max(share, 0.15), 0.85) * (high[0] - low[0])
    x, error = seen[-1]
    # a rate that rises like the current, or faster where little is missing
    return x - min(max(0.7 * error, -FARTHEST), FARTHEST)


def _mean(rates: F64, neurons: Sequence[int], dropped: Sequence[int]) -> float:
    return float(np.mean([rates[k] for k in neurons if k not in dropped]))


def _dropped(rates: F64, target: Target, most: int) -> tuple[int, ...]:
    """Neurons whose loss brings the mean nearest to the target, one after the other."""
    neurons = target.population.neurons
    gone: list[int] = []
    for _ in range(min(most, len(neurons) - 1)):
        left = [k for k in neurons if k not in gone]
        errors = [abs(_mean(rates, neurons, [*gone, k]) - target.rate) for k in left]
        choice, error = left[int(np.argmin(errors))], min(errors)
        if error >= abs(_mean(rates, neurons, gone) - target.rate):
            break
        gone.append(choice)
    return tuple(sorted(gone))
