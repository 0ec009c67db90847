"""Calibration of a NEF chip: what a bench counts and reads, and the biases that bring it to the design.

What a laboratory does with a chip before anything is run on it, at one temperature. Spikes of the first
neurons are counted for `WINDOW` at three codes of their own bias stages, which tell of the mean neuron

    1 / rate = t_ref + (Q / unit) / (code - I_leak / unit)

and a scanner's pad shows currents in units of what a stage of code 64 gives there: the reference of lines,
and the output of filters at their middle; its steps have the filters' time constants. Then

    I_pos    makes Q / unit, and I_leak makes I_leak / Q, what they are in the design
    I_rfr    makes t_ref, I_ref the reference
    I_tau    makes a filter's time constant, for each of `TAUS`, and I_mid its output

What a neuron's own devices deviate stays, as its tuning curve. Currents of a generator have codes, of which a
line has the nearest; those that the rounds came nearest with are kept. The design is the nominal chip with
fixed gates. Fixed gates have no codes: they are trimmed in steps of `TRIM_STEP` of the currents that they
stand for, until the median neuron is the design's. I_mid is only raised, where it comes near the filter's
leak as on a slow die in the cold, since a filter whose middle is below its leak passes nothing.

Numbers of what is sampled and of rounds are ours.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache, partial

import numpy as np

from chips.codes import Calibration, Codes, Measured, attempted, codes_begun, codes_near, left_off
from chips.nef.circuit import NEURONS, chip_biases
from chips.nef.devices import TAUS, Biases
from chips.nef.model import (
    BIAS_COLUMN,
    column_on,
    filters_on,
    lines_on,
    middle_over_leak,
    neurons_on,
    unit_of,
)
from chips.nef.validity import check_temperature
from circuits.arrays import F64
from circuits.blocks.nef.neuron import LEAK, REFRACTORY_CURRENT
from circuits.circuit import Bias, BiasKind
from circuits.errors import ParameterError
from circuits.generator.code import COARSE, CODES, codes_of, currents_of
from circuits.silicon.die import NOMINAL
from circuits.silicon.process import ROLLS_180, ROLLS_180_IDEAL, Process
from circuits.silicon.silicon import Silicon

NAME = "nef-chip"  # of the calibration
REFERENCE_C = 27.0  # degC, where a chip is calibrated unless said
WINDOW = 1.0  # s, in which spikes are counted where curves are measured
USUAL = 5e-3  # s, time constant of a filter where none is named
TRIM_STEP = 0.01  # of a bias with a fixed gate, in its logarithm
LOWEST_TRIM = 0.05  # of the design's value, below which no fixed gate is trimmed
LEAST_MIDDLE = 10.0  # currents of a filter's leak that its middle is at least trimmed to; the design has 50
OFF = 0.05  # share of a number beyond which it is told to stay off
ROUNDS = 8
COUNTED = (5, 16, 64)  # codes of a neuron's bias stage
SAMPLED, FILTERS, LINES = 1024, 16, 64  # neurons that are counted, filters and lines that are scanned
_SETTLED = 5.0  # time constants that a filter's step is looked at
# neurons are counted once a round, filters and lines are scanned twice
_SECONDS = ROUNDS * (len(COUNTED) * WINDOW + 2.0 * _SETTLED * sum(TAUS))
_LEAST = (len(COARSE) - 1, 1)  # code
_MOST = COARSE[0] * (CODES - 1) / CODES  # A

Values = Mapping[str, float]
_Current = F64 | float | tuple[float, ...]
Lines = dict[str, F64]
"""Currents of biases by name, A: one, or one for each of `TAUS`."""


@dataclass(frozen=True, slots=True)
class Neurons:
    """What counted spikes tell of the mean neuron.

    charge : Q / unit, s; leak : I_leak / Q, 1/s; refractory : s.
    """

    charge: float
    leak: float
    refractory: float


@dataclass(frozen=True, slots=True)
class Signals:
    """What the pad shows.

    reference : of lines, over what a stage of code 64 gives; tau, output : of filters at their middle for
    each of `TAUS`, s, and in that unit, float64[n].
    """

    reference: float
    tau: F64
    output: F64


def calibrate(silicon: Silicon, kind: BiasKind, setup: Hashable = None) -> Codes:
    """Calibrate a chip on a silicon, at its temperature, with the design's targets.

    Arguments are those of `chips.codes.attempted`; setup: nothing, it is the same for any network.

    Raises
    ------
    OutsideBoxError
        The temperature is where its model was not measured.
    """
    return calibrated(silicon, kind, (), NEURONS)


@dataclass(frozen=True, slots=True)
class Bench:
    """A chip on a bench, and what it should show there.

    silicon, kind : as of `calibrate`.
    values : of biases that the design has otherwise, by name, A or V.
    count : how many neurons are counted.
    wanted : what the design has.
    """

    silicon: Silicon
    kind: BiasKind
    values: Values
    count: int
    wanted: tuple[Neurons, Signals]

    def neurons(self, lines: Lines) -> Neurons:
        """Return what spikes tell at currents of biases, A."""
        return neurons_of(self.silicon, self.count, with_currents(lines, self.kind, self.values))

    def signals(self, lines: Lines) -> Signals:
        """Return what the pad shows at currents of biases, A."""
        return signals_of(self.silicon, with_currents(lines, self.kind, self.values))


@lru_cache(maxsize=16)
def calibrated(silicon: Silicon, kind: BiasKind, given: tuple[tuple[str, float], ...], neurons: int) -> Codes:
    """Calibrate a chip to other values of the design.

    silicon, kind: as of `calibrate`; given: name and value of biases that the design has otherwise, A or V;
    neurons: how many the chip has.
    """
    bench = Bench(silicon, kind, dict(given), min(SAMPLED, neurons), designed(silicon.process, given))
    return attempted(NAME, silicon, kind, None, partial(_found, bench))


def _found(bench: Bench, begun: Codes) -> Codes:
    """Codes of the chip on a bench."""
    check_temperature("calibration", bench.silicon.temperature_c)
    lines = usual_currents(bench.values)
    before = bench.neurons(lines), bench.signals(lines)
    for off in (_neurons_off, _signals_off, _outputs_off):
        lines = settled(lines, partial(off, bench))
    after = bench.neurons(lines), bench.signals(lines)
    codes, measured = codes_near(lines), tuple(_measured(bench.wanted, before, after))
    lowest = tuple(f"{name}: at its least code" for name, each in codes.items() if _LEAST in each)
    return replace(
        begun, biases=codes, measured=measured, bench_s=_SECONDS,
        unmended=(*left_off(measured, OFF), *lowest),
    )  # fmt: skip


def _neurons_off(bench: Bench, lines: Lines) -> Lines:
    """By what factors currents should move that neurons tell of."""
    found, wanted = bench.neurons(lines), bench.wanted[0]
    factors = {
        "i_pos": found.charge / wanted.charge,
        "i_leak": wanted.leak / found.leak,
        "i_rfr": found.refractory / wanted.refractory,
    }
    return {name: np.array([factor]) for name, factor in factors.items()}


def _signals_off(bench: Bench, lines: Lines) -> Lines:
    """The same of the reference and of time constants, and of the output at the usual one."""
    found, wanted = bench.signals(lines), bench.wanted[1]
    middle = TAUS.index(USUAL)
    return {
        "i_tau": found.tau / wanted.tau,
        "i_thr": (wanted.output / found.output)[middle : middle + 1],
        "i_ref": np.array([wanted.reference / found.reference]),
    }


def _outputs_off(bench: Bench, lines: Lines) -> Lines:
    """The same of the outputs of filters."""
    return {"i_mid": bench.wanted[1].output / bench.signals(lines).output}


def settled(lines: Lines, off: Callable[[Lines], Lines]) -> Lines:
    """Return currents with those replaced whose factors `off` tells, as near to 1 as the rounds came.

    A generator's lines do not rise with every step of their codes, so that the last round is not the best.
    """
    best: dict[str, tuple[F64, F64]] = {}
    for _ in range(ROUNDS):
        factors = off(lines)
        for name, factor in factors.items():
            error, now = np.abs(np.log(factor)), (np.full(factor.shape, np.inf), lines[name])
            least, kept = best.get(name, now)
            best[name] = (np.minimum(error, least), np.where(error < least, lines[name], kept))
        moved = {name: coded(lines[name] * factor) for name, factor in factors.items()}
        if all((moved[name] == lines[name]).all() for name in moved):
            break
        lines = lines | moved
    return lines | {name: kept for name, (_, kept) in best.items()}


def coded(currents: F64) -> F64:
    """Return the currents of the codes nearest to some, A."""
    return currents_of(codes_of(np.minimum(currents, _MOST)))


def usual_codes(silicon: Silicon, kind: BiasKind) -> Codes:
    """Return the codes of the design on a silicon, which nobody has calibrated.

    Parameters
    ----------
    silicon
        Process, temperature and die.
    kind
        Kind of the biases.
    """
    return replace(codes_begun(NAME, silicon, kind), biases=codes_near(usual_currents({})))


def usual_currents(values: Values) -> Lines:
    """Return the design's currents as its codes have them, with those that are given otherwise, A."""
    found: Lines = {}
    for bias in chip_biases():
        if bias.kind != "voltage":
            value = values.get(bias.name, usual(bias.name))
            each = value * USUAL / np.array(TAUS) if bias.name in ("i_tau", "i_mid") else np.array([value])
            found[bias.name] = coded(each)
    return found


def with_currents(
    lines: Mapping[str, F64 | float | tuple[float, ...]], kind: BiasKind, values: Values
) -> Biases:
    """Return the chip's biases with currents, A, of a kind; values: of its voltages that are set, V."""
    return tuple(
        replace(b, value=values.get(b.name, b.value)) if b.kind == "voltage" else
        replace(b, value=_values(lines[b.name]), kind=kind)
        for b in chip_biases()
    )  # fmt: skip


def _values(current: _Current) -> float | tuple[float, ...]:
    """One current, or as many as `TAUS`."""
    found = tuple(float(i) for i in np.ravel(current))
    return found[0] if len(found) == 1 else found


def neurons_of(silicon: Silicon, count: int, biases: Biases) -> Neurons:
    """Count spikes of the chip's first neurons at the codes `COUNTED`.

    Raises `ParameterError` where they do not fire at all of them.
    """
    law, column = neurons_on(silicon, count, biases), column_on(silicon, BIAS_COLUMN, count, biases)
    phase = np.random.default_rng(0).random((len(COUNTED), count))
    given = [column.bias(slice(0, count), np.full(count, code)) for code in COUNTED]
    current, sunk = np.stack(given, axis=1)
    rate = np.floor(law.rates(0, current, sunk) * WINDOW + phase).mean(axis=1) / WINDOW
    if not (rate > 0.0).all() or not (np.diff(rate) > 0.0).all():
        raise ParameterError(
            f"{NAME}.rates: {rate.round(1).tolist()} Hz at codes {COUNTED}, must rise with them"
        )
    period, (a, b, c) = 1.0 / rate, COUNTED
    ratio = (period[0] - period[1]) / (period[0] - period[2]) * (c - a) / (b - a)
    zero = (c - ratio * b) / (1.0 - ratio)
    charge = (period[0] - period[2]) * (a - zero) * (c - zero) / (c - a)
    return Neurons(float(charge), float(zero / charge), float(period[2] - charge / (c - zero)))


@lru_cache(maxsize=4)
def signals_of(silicon: Silicon, biases: Biases) -> Signals:
    """Scan lines and filters, and what a stage of code 64 gives; a calibration looks where it was before."""
    stages = column_on(silicon, BIAS_COLUMN, SAMPLED, biases)
    one = stages.bias(slice(0, SAMPLED), np.full(SAMPLED, COUNTED[-1]))[0].mean() / COUNTED[-1]
    unit = unit_of(silicon, biases) / one  # of what the model counts in, in stages
    each = [filters_on(silicon, np.full(FILTERS, tau), biases) for tau in TAUS]
    return Signals(
        float(np.median(lines_on(silicon, LINES, biases).zero)) * unit,
        np.array([np.median(f.tau) for f in each]),
        np.array([np.median(f.gain) for f in each]) * unit,
    )


@lru_cache(maxsize=8)
def designed(process: Process, given: tuple[tuple[str, float], ...] = ()) -> tuple[Neurons, Signals]:
    """Return what the design has: the nominal chip with fixed gates, and time constants as asked for.

    given: name and value of biases whose currents the design has otherwise, A.
    """
    silicon = Silicon(process, REFERENCE_C, NOMINAL)
    neurons = neurons_of(silicon, SAMPLED, trimmed(silicon, "gate", given, NEURONS))
    share = _over_usual("i_tau", dict(given))
    return neurons, Signals(1.0, np.array(TAUS) / share, np.ones(len(TAUS)))


def _measured(
    wanted: tuple[Neurons, Signals], before: tuple[Neurons, Signals], after: tuple[Neurons, Signals]
) -> Iterator[Measured]:
    """What was measured, by its names."""
    three = (wanted, before, after)
    for name, unit in (("charge", "s"), ("leak", "1/s"), ("refractory", "s")):
        yield Measured(name, unit, *(getattr(x[0], name) for x in three))
    yield Measured("reference", "", *(x[1].reference for x in three))
    for name, unit in (("tau", "s"), ("output", "")):
        for k in range(len(TAUS)):
            yield Measured(f"{name}[{k}]", unit, *(float(getattr(x[1], name)[k]) for x in three))


def biases_of(codes: Codes, values: Values) -> Biases:
    """Return the biases of a chip at codes; values: of its voltages that are set, V."""
    return with_currents(codes.currents, codes.key.bias_kind, values)


@lru_cache(maxsize=16)
def trimmed(silicon: Silicon, kind: BiasKind, given: tuple[tuple[str, float], ...], neurons: int) -> Biases:
    """Return the biases of a chip with fixed gates, in steps of `TRIM_STEP`.

    silicon, given, neurons: as of `calibrated`; kind: `gate`.
    """
    values = dict(given)
    biases = tuple(
        b if b.kind == "voltage" and b.name not in values else
        replace(b, value=values.get(b.name, b.value), kind=b.kind if b.kind == "voltage" else kind)
        for b in chip_biases()
    )  # fmt: skip
    # a gate voltage that stands for 27 degC gives a power of its current elsewhere
    for _ in range(4 if silicon.process.effects == "ideal" else 8):
        law = neurons_on(silicon, min(SAMPLED, neurons), biases)
        filter_ = filters_on(silicon, np.full(FILTERS, USUAL), biases)
        wanted = {
            "i_leak": (values.get("i_leak", LEAK) / LEAK) / float(np.median(law.leak)),
            "i_rfr": float(np.median(law.refractory)) / _refractory(values.get("i_rfr", REFRACTORY_CURRENT)),
            "i_pos": _design()[1] * _over_usual("i_pos", values) / unit_of(silicon, biases),
            "i_thr": 1.0 / float(np.median(filter_.gain)),
            "i_ref": 1.0 / float(np.median(lines_on(silicon, LINES, biases).zero)),
            "i_tau": float(np.median(filter_.tau)) / (_design()[2] / _over_usual("i_tau", values)),
            "i_mid": max(1.0, LEAST_MIDDLE / middle_over_leak(silicon, USUAL, biases)),
        }
        before, biases = (
            biases,
            tuple(_trimmed_by(b, wanted.get(b.name, 1.0)) for b in biases),
        )
        if biases == before:
            break
    return biases


def _trimmed_by(bias: Bias, by: float) -> Bias:
    """A bias times a factor that the trim's steps can give, at least its lowest."""
    value = float(np.ravel(bias.value)[0])
    new = value * math.exp(TRIM_STEP * round(math.log(by) / TRIM_STEP))
    return replace(bias, value=max(new, min(value, LOWEST_TRIM * usual(bias.name))))


@lru_cache(maxsize=1)
def _design() -> tuple[float, float, float]:
    """Refractory period (s), unit (thresholds) and time constant (s) of the nominal chip at 27 degC."""
    silicon = Silicon(ROLLS_180_IDEAL, REFERENCE_C)
    biases = chip_biases()
    law = neurons_on(silicon, 1, biases)
    tau = filters_on(silicon, np.array([USUAL]), biases).tau[0]
    return float(law.refractory[0]), unit_of(silicon, biases), float(tau)


def refractory_current(period: float) -> float:
    """Return the current I_rfr of a refractory period, s, in the nominal chip, A."""
    return REFRACTORY_CURRENT * _design()[0] / period


def _refractory(current: float) -> float:
    return _design()[0] * REFRACTORY_CURRENT / current


def _over_usual(name: str, given: Values) -> float:
    """The current that is given for a bias, over the design's."""
    return given.get(name, usual(name)) / usual(name)


def usual(name: str) -> float:
    """The design's value of a bias, A or V."""
    return float(np.ravel(next(b for b in chip_biases() if b.name == name).value)[0])


CALIBRATION = Calibration(
    name=NAME,
    summary="rates of neurons, time constants and outputs of filters, the reference",
    process=ROLLS_180,
    calibrate=calibrate,
    require_temperature=lambda silicon: check_temperature("temperature", silicon.temperature_c),
)
