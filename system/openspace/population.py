"""What a calibrated ranging chip reads of a ping's echoes: by all neurons that answer, and how soon.

The chip hears whole pings: a call, then every echo, each where the ones before have left its neurons
(`chips.ranging.kernel`). A neuron answers an echo by its first spike within `WINDOW` after it and before the
next one. The robot compares who answered, and how long after the echo, with what the bench met for an echo
alone at each of `delays`, at the chip's codes and the temperature where it was calibrated:

    misfit(d) = sum over k of ((a_k - A_k(d)) / TOLERANCE)^2
    reading = T_bench / T * median of d by the weights exp(-misfit(d) / 2)

a_k is how soon neuron k answers, s; answers later than `SOON` are alike, and none stands for `SILENT`, all
three ours. Over k go the neurons that have not spiked since the call: one that an earlier echo made spike is
nearer to its threshold, and answers beyond its window too. Over d go delays to which some neuron that
answered does on the bench, not nearer than any that the robot can meet, nor than its reading of the echo
before; where there is none, that reading stands. The first neuron answers from 0.1 to 0.45 m, and for a bat
to which that stood for its mean of 0.27 m, inside of its own zone of collision, all arcs would be barred.
Echoes that no neuron answers before the next one, within `SOON`, are read as one with it; an echo that none
answers at all has no reading.

A chip whose currents are proportional to absolute temperature is slower by as much as it is colder, so that a
reading is multiplied by T_bench / T, T from a thermometer beside the chip. The robot's clock takes times
after echoes, never after the call: that would be a range without the chip.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from chips.codes import Codes
from chips.noise import SiliconNoise
from chips.ranging.calibration.found import off_of, values_of
from chips.ranging.chip import shipped_model
from chips.ranging.kernel import (
    NEXT,
    PULSE,
    Chip,
    Plan,
    forget_seen,
    new_chip,
    next_due,
    on_call,
    on_echo,
    start,
    take,
)
from chips.ranging.law import Neurons
from chips.ranging.model import ReboundModel, check_box, neurons_on, with_biases
from chips.ranging.noise import Jitter, new_jitter, no_jitter
from chips.ranging.temperature import conditions_of
from circuits.arrays import F64, I64, Bools
from circuits.circuit import BiasKind
from circuits.compiled import compiled
from circuits.errors import ParameterError
from circuits.silicon.process import kelvin
from circuits.silicon.silicon import Silicon
from system.openspace.reader import CALL, STEP, WINDOW, delays, late_spikes
from system.openspace.reader_noise import Reader
from system.openspace.state import ECHOES

TOLERANCE = 30e-6  # s, to which answers are alike
SOON = 0.5e-3  # s, after which answers are alike
SILENT = 0.8e-3  # s, that no answer stands for
KEPT = 64  # chips
_ROOM = 4096  # spikes of a ping that are kept
_MOST = 60.0  # misfit above the least, beyond which delays weigh nothing
_TO_REST = 2.0 * CALL  # s between calls, after which all neurons rest

_compiled = compiled()


class Population(NamedTuple):
    """A chip that hears pings, and what its robot knows of it; without neurons there is none.

    on: whether a neuron is not switched off, bool[n]; soon: how soon each answers an echo alone on the bench,
    float64[n, delays], s; met: whether some neuron answers to a delay that can be met, bool[delays]; warmer:
    temperature over the bench's. The rest is overwritten by every ping, so that a population is one run's at
    a time: spoken, said: who has spiked since the call, before and after the present echo, bool[n]; answer:
    how soon each answered it, float64[n], s; misfit: float64[delays]; echo: delay and reading of each echo,
    float64[echoes, 2], s, NaN for none; row, reading: its place in the ping, int64[echoes], and readings by
    that place, float64[echoes]; spikes: time, s, and neuron, float64[spikes, 2], of the last ping; spiked:
    how many, int64[1].
    """

    neurons: Neurons
    plan: Plan
    chip: Chip
    on: Bools
    soon: F64
    met: Bools
    warmer: float
    spoken: Bools
    said: Bools
    answer: F64
    misfit: F64
    echo: F64
    row: I64
    reading: F64
    spikes: F64
    spiked: I64

    def spoke(self) -> tuple[F64, I64]:
        """Return the spikes since the ping before, up to the last echo's answers: times, s, and neurons.

        Raises `ParameterError` where there are more than are kept.
        """
        count = int(self.spiked[0])
        if count > _ROOM:
            raise ParameterError(f"ranging_chip: {count} spikes of a ping, must be <= {_ROOM}")
        times, neurons = self.spikes[:count].T
        return times.copy(), neurons.astype(np.int64)


@dataclass(frozen=True, slots=True)
class Coded:
    """A ranging chip at its codes.

    silicon : process, temperature and die.
    area : area of its drawn devices over the circuit's.
    bias_kind : kind of its biases.
    biases : values of biases by name, A or V.
    off : neurons that are switched off.
    calibrated_c : temperature of the bench, degC.
    nearest : delay of the nearest echo that its robot can meet, s.
    """

    silicon: Silicon
    area: float
    bias_kind: BiasKind
    biases: tuple[tuple[str, float | tuple[float, ...]], ...]
    off: tuple[int, ...]
    calibrated_c: float
    nearest: float = 0.0

    @property
    def model(self) -> ReboundModel:
        """The model of the chip."""
        return with_biases(shipped_model(self.silicon.process, self.bias_kind), dict(self.biases))

    def at(self, temperature_c: float) -> Coded:
        """Return the chip at another temperature, degC."""
        return replace(self, silicon=replace(self.silicon, temperature_c=temperature_c))

    def neurons(self) -> Neurons:
        """Return its neurons; raises `ParameterError` outside the record's box (`chips.validity`)."""
        model, silicon = self.model, self.silicon.of_area(self.area)
        return neurons_on(model, silicon, check_box(model, silicon, "ranging_chip"))


def coded(
    silicon: Silicon, codes: Codes, bias_kind: BiasKind = "generator", area: float = 1.0,
    nearest: float = 0.0,
) -> Coded:  # fmt: skip
    """Return the ranging chip on a silicon at codes.

    area: of its drawn devices over the circuit's; nearest: delay of the nearest echo that its robot can meet,
    s.
    """
    values = tuple(sorted(values_of(codes).items()))
    return Coded(silicon, area, bias_kind, values, off_of(codes), codes.calibrated_c, nearest)


def population_on(
    chip: Coded, noise: SiliconNoise | None = None, begun_c: float | None = None
) -> Population:  # fmt: skip
    """Return a chip before its first ping, and what its robot knows of it.

    noise: of its devices, none for None; begun_c: temperature (degC) of the run's beginning where it moves,
    by whose inhibition relaxations are told apart. Raises `ParameterError` outside the record's box.
    """
    neurons = chip.neurons()
    jitter = None
    if noise is not None:
        first = neurons if begun_c is None else chip.at(begun_c).neurons()
        shortest, silicon = float(first.t_inh.min()), chip.silicon.of_area(chip.area)
        jitter = new_jitter(chip.model, neurons, silicon, noise, shortest, area=chip.area)
    heard = conditions_of(neurons, jitter)
    soon, met = _bench(chip.at(chip.calibrated_c))
    on = np.ones(neurons.t_inh.size, dtype=np.bool_)
    on[list(chip.off)] = False
    warmer = kelvin(chip.silicon.temperature_c) / kelvin(chip.calibrated_c)
    chip_at_rest = new_chip(heard.neurons, heard.plan, 0.0, jitter)
    return _new(heard.neurons, heard.plan, chip_at_rest, on, soon.copy(), met.copy(), warmer)


@lru_cache(maxsize=1)
def no_population() -> Population:
    """Return what stands for a population where no calibrated chip hears."""
    nothing, nobody, plane = np.zeros(0), np.zeros(0, dtype=np.bool_), np.zeros((0, 0))
    shaped = {"inverse_capacitance": np.zeros((0, 4, 3, 3)), "follow": np.zeros((0, 3, 3)), "effects": plane}
    neurons = Neurons(**dict.fromkeys(Neurons._fields, nothing) | shaped)
    plan = Plan(nobody, nothing, nothing, nothing, nothing, plane, plane, np.zeros((0, 0, 0)))
    integers = np.zeros(0, np.int64)
    seen = np.zeros((0, 0, 3)), nothing, np.zeros((0, 0, 0))
    chip = Chip(plane, plane, nothing, integers, nothing, plane, integers, no_jitter(), *seen)
    return _new(neurons, plan, chip, nobody, plane, nobody, 1.0)


def _new(
    neurons: Neurons, plan: Plan, chip: Chip, on: Bools, soon: F64, met: Bools, warmer: float
) -> Population:  # fmt: skip
    n, room = on.size, ECHOES if on.size else 0
    silent = np.zeros((2, n), dtype=np.bool_)
    return Population(
        neurons, plan, chip, on, soon, met, warmer, silent[0], silent[1], np.zeros(n), np.zeros(met.size),
        np.zeros((room, 2)), np.zeros(room, np.int64), np.zeros(room), np.zeros((_ROOM if n else 0, 2)),
        np.zeros(1, np.int64),
    )  # fmt: skip


def forget(p: Population) -> None:
    """Begin another run, at rest and with draws of its own: what flicker was, and was seen, is forgotten."""
    p.chip.jitter.last[:] = -math.inf
    p.chip.last[:] = -math.inf
    forget_seen(p.chip)


def unsure_delays(chip: Coded) -> int:
    """How many of `delays` are too near to call for an echo alone; raises as `population_on`."""
    return late_spikes(chip.neurons())[1]


def check_rate(name: str, rate: float, longest: float) -> None:
    """Ask that no call comes before all echoes of the last one are answered.

    name: of the rate of pings, Hz; longest: s, from a call to the last echo of its ping.

    Raises
    ------
    ParameterError
        It may come: the chip would take the one's echoes for the other's.
    """
    most = 1.0 / (longest + WINDOW)
    if rate > most:
        raise ParameterError(
            f"{name}: {rate:g} Hz, must be <= {most:.3g} Hz, or a call comes before the ranging chip has"
            " answered the echoes of the last one; ping more slowly, or take `ranges=exact`"
        )


def jitter_of(population: Population, reader: Reader) -> Jitter:
    """Return how the inhibition of a chip's neurons jitters, calibrated or not; of none without noise."""
    return population.chip.jitter if population.on.size else reader.jitter


@lru_cache(maxsize=KEPT)
def _bench(chip: Coded) -> tuple[F64, Bools]:
    """How soon each neuron answers on the bench, and which delays are met."""
    late = late_spikes(chip.neurons())[0]
    late[list(chip.off)] = np.inf
    soon = np.where(late <= WINDOW, np.minimum(late, SOON), SILENT)
    met = np.asarray((late <= WINDOW).any(axis=0) & (delays() >= chip.nearest))
    soon.setflags(write=False)
    met.setflags(write=False)
    return soon, met


@_compiled
def hear_ping(p: Population, time: float, n: int) -> None:
    """A call at `time` s, and readings of n echoes at the delays in `echo`, in their order.

    The call is not before the last answer to the run's ping before: `WINDOW` after its last echo.
    """
    p.spiked[0] = 0
    _to_the_call(p, time)
    p.chip.last[NEXT] = -math.inf
    on_call(p.neurons, p.plan, p.chip, time)
    _forget_answers(p)
    at, first, latest = 0.0, 0, 0
    for e in range(n):
        if e > 0 and p.echo[e, 0] <= p.echo[latest, 0] + PULSE:
            continue  # one pulse on the board
        if e > 0:
            place = _place_of(p, time, latest, p.echo[e, 0], at)
            if not math.isnan(place) or p.echo[e, 0] - p.echo[latest, 0] > SOON:
                at = _note(p, first, e, place, at)
                first = e
        else:
            _go_on(p, time + p.echo[0, 0], math.nan)
        _say(p)
        latest = e
        p.chip.last[NEXT] = _next_pulse(p, time, e, n)
        on_echo(p.neurons, p.plan, p.chip, time + p.echo[e, 0], math.nan)
    if n > 0:
        _note(p, first, n, _place_of(p, time, latest, p.echo[latest, 0] + WINDOW, at), at)


@_compiled
def _next_pulse(p: Population, time: float, e: int, n: int) -> float:
    """When the next echo comes that does not merge with echo e, s; past where none does."""
    for i in range(e + 1, n):
        delay: float = p.echo[i, 0]
        if delay > p.echo[e, 0] + PULSE:
            return time + delay
    return -math.inf


@_compiled
def _to_the_call(p: Population, time: float) -> None:
    """Bring the chip to a call at `time` s: by its spikes, or at rest where the last call is long ago."""
    last = p.chip.last[0]
    if last <= time <= last + _TO_REST:
        _go_on(p, time, math.nan)
        return
    if last + CALL <= time:
        _go_on(p, last + CALL, math.nan)
    p.chip.last[:] = -math.inf
    p.chip.echoes[:] = -math.inf
    start(p.neurons, p.plan, p.chip, time - CALL)
    _go_on(p, time, math.nan)


@_compiled
def _forget_answers(p: Population) -> None:
    for k in range(p.on.size):
        p.spoken[k], p.said[k], p.answer[k] = False, False, SILENT


@_compiled
def _say(p: Population) -> None:
    """Who has spiked up to now is nearer to its threshold for the echoes to come."""
    for k in range(p.on.size):
        p.spoken[k] |= p.said[k]
        p.answer[k] = SILENT


@_compiled
def _place_of(p: Population, time: float, e: int, until: float, at: float) -> float:
    """Where echo e is, in steps, by the spikes up to `until` s after the call; NaN where no neuron answers.

    at: where the echo before is.
    """
    _go_on(p, time + until, time + p.echo[e, 0])
    return _place(p, until - p.echo[e, 0], at)


@_compiled
def _note(p: Population, first: int, end: int, place: float, at: float) -> float:
    """Note the reading of the echoes from `first` to before `end`; returns where the last one read is."""
    for e in range(first, end):
        p.echo[e, 1] = STEP * place / p.warmer
    return at if math.isnan(place) else place


@_compiled
def _go_on(p: Population, until: float, echo: float) -> None:
    """Take the spikes up to `until` s; the first of each neuron soon after an echo (s) is its answer."""
    while True:
        due, k = next_due(p.chip)
        if not due <= until:
            return
        if not take(p.neurons, p.plan, p.chip, k) or not p.on[k]:
            continue
        if p.spiked[0] < p.spikes.shape[0]:
            p.spikes[p.spiked[0], 0], p.spikes[p.spiked[0], 1] = due, k
        p.spiked[0] += 1
        p.said[k] = True
        if due - echo <= WINDOW:
            p.answer[k] = min(p.answer[k], due - echo, SOON)


@_compiled
def _place(p: Population, gap: float, at: float) -> float:
    """Delay of the present echo in steps, not before `at`, NaN where no neuron answers; gap: s, heard for."""
    soonest = SILENT
    for k in range(p.on.size):
        soonest = min(soonest, p.answer[k])
    if soonest == SILENT:
        return math.nan
    least, begin = math.inf, int(at)
    for d in range(begin, p.met.size):
        p.misfit[d] = _misfit(p, d, gap) if p.met[d] else math.inf
        least = min(least, p.misfit[d])
    if least == math.inf:
        return at  # beyond the windows of all that answer
    weights = 0.0
    for d in range(begin, p.met.size):
        p.misfit[d] = math.exp(-0.5 * min(p.misfit[d] - least, _MOST))
        weights += p.misfit[d]
    share, d = 0.0, begin
    while True:
        share += p.misfit[d] / weights
        if share >= 0.5:
            return float(d)
        d += 1


@_compiled
def _misfit(p: Population, d: int, gap: float) -> float:
    """How far the answers are from those to delay d on the bench, inf where none who answers does there."""
    total, answered = 0.0, False
    for k in range(p.on.size):
        soon = p.soon[k, d] if p.soon[k, d] <= gap else SILENT
        answered |= p.answer[k] < SILENT and p.soon[k, d] < SILENT
        if not p.spoken[k]:
            apart = (p.answer[k] - soon) / TOLERANCE
            total += apart * apart
    return total if answered else math.inf
