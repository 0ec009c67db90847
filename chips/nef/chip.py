"""The NEF chip: thousands of neurons with encoder stages, filters and an address-event router, on a die.

A signal in a slot of a population, a number x, is at the full scale of its line where x is `full`:

    z = x / full, in steps of the converters,   s = low-pass of 1 + z,   Y = gain s^power
    pos = above max(Y - zero, 0), neg = below max(zero - Y, 0)
    J_i = sum over slots (a_i pos + b_i neg) + bias_i

with a and b the currents of the stage's two banks at the neuron's code, of unlike signs, one of them through
the mirror. Filters beyond a slot's first add what they are above their middle.

At one temperature biases are calibrated before anything is run (`chips.nef.calibration`); converters are set
so that every filter's middle is the reference. What a neuron's own devices deviate stays, as its tuning
curve. Codes of stages are chosen for the median neuron; curves are then measured by counting spikes for
`WINDOW`, through the filters that drive them, and decoders solved from what was counted.

Limits and numbers of bits are ours.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import lru_cache

import numpy as np

from chips.codes import Codes
from chips.nef.calibration import NAME, REFERENCE_C, USUAL, biases_of, calibrated, trimmed
from chips.nef.circuit import COLUMNS, FILTERS, NEURONS, chip_biases
from chips.nef.devices import POWER, Biases
from chips.nef.model import (
    BIAS_COLUMN,
    Column,
    Filters,
    Lines,
    NeuronLaw,
    column_on,
    filters_on,
    lines_on,
    neurons_on,
)
from chips.nef.validity import check_box
from chips.noise import SiliconNoise
from circuits.arrays import F64, I64
from circuits.blocks.nef.encoder import BITS
from circuits.circuit import BiasKind
from circuits.errors import ParameterError, unknown_name
from circuits.silicon.die import NOMINAL, Die
from circuits.silicon.process import ROLLS_180, Process
from circuits.silicon.silicon import Silicon

INPUT_BITS, WEIGHT_BITS = 10, 10  # of the converters and of decoding weights, sign included
HEADROOM = 2.0  # full scale of a slot, in radii
CODE = 2**BITS - 1  # highest code of a stage
MOST_COLUMNS = 4  # that one slot of currents takes together
EVENTS = 1000  # that the router passes a ms
FIFO = 256  # events that wait for it
FASTEST, SLOWEST = 0.5e-3, 0.5  # s, time constants of filters; a shorter one is set to the fastest
_SAMPLED = 1024  # neurons whose median is taken
_BIT = 6  # of a stage, whose current tells a unit


@dataclass(frozen=True, slots=True)
class NefChip:
    """A NEF chip.

    Attributes
    ----------
    die, bias_kind : Die, str
        Its die, and the kind of its biases.
    biases : mapping of str to float
        Values of biases by name to which it is calibrated, A or V; the usual ones where not given.
    calibration_c : float
        Temperature at which it is calibrated, degC.
    neurons : int
        How many neurons it has.
    area : float
        Area of all devices over the circuit's, a ratio. Mismatch and flicker go as its root, and nothing else
        does.
    noise : SiliconNoise or None
        Noise of its devices where a network is run; None for none.
    process : Process
        Process in which it is made.
    codes : Codes or None
        What a calibration found for it; its own calibration at `calibration_c` unless given.
    coded_on : Die or None
        The die on which the codes were found, where that is not this one: before some of it was healed.

    Raises
    ------
    UnknownNameError
        There is no such bias.
    ParameterError
        A number breaks its rule, or the codes are of another silicon.
    """

    die: Die = NOMINAL
    bias_kind: BiasKind = "generator"
    biases: Mapping[str, float] = field(default_factory=dict, hash=False)
    calibration_c: float = REFERENCE_C
    neurons: int = NEURONS
    area: float = 1.0
    noise: SiliconNoise | None = None
    process: Process = ROLLS_180
    codes: Codes | None = field(default=None, hash=False)
    coded_on: Die | None = None

    def __post_init__(self) -> None:
        known = [b.name for b in chip_biases()]
        for name, value in self.biases.items():
            if name not in known:
                raise unknown_name("bias of the NEF chip", name, known)
            if not 0.0 < value < math.inf:
                raise ParameterError(f"nef-chip.{name}: {value:g}, must be above 0 and finite")
        if not 1 <= self.neurons <= NEURONS:
            raise ParameterError(f"nef-chip.neurons: {self.neurons}, must be from 1 to {NEURONS}")
        if not 0.01 <= self.area <= 1e4:
            raise ParameterError(f"nef-chip.area: {self.area:g}, must be from 0.01 to 1e4")
        silicon = self.silicon(self.calibration_c)
        if self.codes is not None:
            found_on = silicon if self.coded_on is None else replace(silicon, die=self.coded_on)
            self.codes.check(NAME, found_on, self.bias_kind)

    def silicon(self, temperature_c: float) -> Silicon:
        """Return the silicon that it is made of at `temperature_c`, degC."""
        return Silicon(self.process, temperature_c, self.die).of_area(self.area)

    def at(self, temperature_c: float) -> Conditions:
        """Return the calibrated chip at `temperature_c`, degC.

        Raises `ParameterError` outside the box of its model (`chips.nef.validity`).
        """
        check_box(self.calibration_c, temperature_c, self.area)
        return Conditions(self, temperature_c, self._biases)

    @property
    def _biases(self) -> Biases:
        """Its biases as calibrated."""
        if self.codes is not None:
            return biases_of(self.codes, self.biases)
        values, silicon = tuple(sorted(self.biases.items())), self.silicon(self.calibration_c)
        if self.bias_kind == "gate":
            return trimmed(silicon, "gate", values, self.neurons)
        codes = calibrated(silicon, self.bias_kind, values, self.neurons)
        codes.require_usable()
        return biases_of(codes, self.biases)


@dataclass(frozen=True, slots=True)
class Conditions:
    """A chip at a temperature, with its biases as calibrated; these are the `Curves` of its neurons.

    Currents are in thresholds of an ideal neuron.

    Attributes
    ----------
    chip : NefChip
        The chip.
    temperature_c : float
        Temperature, degC.
    biases : Biases
        Its biases.
    """

    chip: NefChip
    temperature_c: float
    biases: Biases

    @property
    def silicon(self) -> Silicon:
        """The silicon that the chip is made of, at this temperature."""
        return self.chip.silicon(self.temperature_c)

    @property
    def law(self) -> NeuronLaw:
        """All neurons of the chip."""
        return _law(self.silicon, self.chip.neurons, self.biases)

    @property
    def unit(self) -> float:
        """Current of a stage with code 1 that has its reference's gate, the median of the die, thresholds."""
        return _unit(self.silicon, self.chip.neurons, self.biases)

    def column(self, column: int) -> Column:
        """Return the stages of the column of number `column`."""
        return _stages(self.silicon, column, self.chip.neurons, self.biases)

    def filters(self, taus: F64) -> Filters:
        """Return filters that are set to the time constants `taus`, float64[n], s."""
        return filters_on(self.silicon, np.clip(taus, FASTEST, SLOWEST), self.biases)

    @property
    def full(self) -> bool:
        """Whether its transistors have second-order effects."""
        return self.chip.process.effects == "full"

    def typical(self, tau: float = USUAL) -> Filters:
        """Return a filter without deviations of its own that is set to the time constant `tau`, s."""
        return _typical(self.silicon, self.biases, min(max(tau, FASTEST), SLOWEST))

    @property
    def power(self) -> float:
        """What a stage with code 1 gives of z near 0, units of its current at y = 1."""
        if not self.full:
            return POWER
        return _power(self.silicon, self.biases)

    def rates(self, first: int, current: F64, sunk: F64 | float = 0.0) -> F64:
        """Return rates from neuron `first` on at a `current`, Hz, as `Curves.rates` does.

        sunk: what of the current mirrors draw, a magnitude, in the same unit and shape.
        """
        return self.law.rates(first, current, sunk)

    def currents(self, first: int, rate: F64) -> F64:
        """Return the currents at which the median neuron of the die fires at given rates.

        They are in thresholds of an ideal neuron (dimensionless), in the shape of `rate`, and NaN where the
        neuron cannot fire so fast.

        Parameters
        ----------
        first
            Number of a neuron; the median is that of the die whatever it is.
        rate
            Rates, Hz, float64 of any shape.
        """
        typical = self.law.each(lambda a: np.asarray(np.median(a[:_SAMPLED])))
        charging = 1.0 / np.maximum(rate, 1e-9) - typical.refractory
        reached = charging > 0.0
        found = typical.leak + typical.charge / np.where(reached, charging, 1.0)
        return np.where(rate > 0.0, np.where(reached, found, np.nan), typical.leak)

    @property
    def lines(self) -> Lines:
        """All lines of the chip."""
        return _lines(self.silicon, self.biases)

    def split(self, line: int, z: F64, tau: float = USUAL) -> tuple[F64, F64]:
        """Return what a line gives above and below its middle, in thresholds (dimensionless).

        Both have the shape of `z`.

        Parameters
        ----------
        line
            Number of the line.
        z
            Its steady value, a share of its full scale, of any shape; converters clip it at 1.
        tau
            Time constant of the filter that brings it, s.
        """
        s, lines = 1.0 + np.clip(z, -1.0, 1.0), self.lines
        if not self.full:
            total = lines.zero[line] * (s**POWER - 1.0)
            return lines.above[line] * np.maximum(total, 0.0), lines.below[line] * np.maximum(-total, 0.0)
        typical = self.typical(tau)
        middle = float(typical.scale_for(lines.zero[line : line + 1])[0])
        return lines.given(line, typical.outputs(middle * s))

    def highest_gain(self, headroom: float) -> float:
        """Return the highest gain of a stage, a number of thresholds for each radius.

        Parameters
        ----------
        headroom
            Full scale of the stage, a number of radii.
        """
        return float(CODE * self.power * self.unit / headroom)

    def codes(self, row: F64, full: float, columns: int) -> I64:
        """Return the codes of stages for currents, int64[columns, n].

        Parameters
        ----------
        row
            Currents, thresholds for each unit of x, float64[n].
        full
            Full scale of the slot, in units of x.
        columns
            Number of columns of stages that the slot takes.
        """
        wanted = np.rint(row * full / (self.power * self.unit))
        most = CODE * columns
        total = np.clip(wanted, -most, most)
        share = [np.trunc(total * (k + 1) / columns) - np.trunc(total * k / columns) for k in range(columns)]
        return np.stack(share).astype(np.int64)

    def stage(self, first: int, column: int, codes: I64) -> tuple[F64, F64]:
        """Return what stages give above and below of a line's full scale, float64[n] each.

        They are in units of the threshold.

        Parameters
        ----------
        first
            Number of the first neuron.
        column
            Number of the first column.
        codes
            Codes of the stages, int64[columns, n].
        """
        above, below = np.zeros(codes.shape[1]), np.zeros(codes.shape[1])
        for k, own in enumerate(codes):
            a, b, mirror = self.column(column + k).banks(slice(first, first + len(own)), own)
            positive = own >= 0
            above += np.where(positive, a, -mirror * a)
            below += np.where(positive, -mirror * b, b)
        return above, below

    def bias_codes(self, bias: F64) -> I64:
        """Return the codes of column 0 for the bias currents `bias`, int64[n].

        Parameters
        ----------
        bias
            Currents in units of the threshold, float64[n].
        """
        return np.asarray(np.clip(np.rint(bias / self.unit), -CODE, CODE).astype(np.int64))

    def bias(self, first: int, codes: I64) -> F64:
        """Return the bias currents of codes, in units of the threshold, float64[n].

        `codes` are those of column 0 from the neuron number `first` on, int64[n].
        """
        return self.column(BIAS_COLUMN).bias(slice(first, first + len(codes)), codes)[0]

    def standing(self, first: int, bias: I64, stages: Iterable[I64]) -> tuple[F64, F64]:
        """Return what neurons get whatever their signals, and what of it mirrors draw, float64[n] each.

        They are in units of the threshold.

        Parameters
        ----------
        first
            Number of the first neuron.
        bias
            Codes of column 0, int64[n].
        stages
            Codes of the columns that follow, int64[n] each.
        """
        own, rest = slice(first, first + len(bias)), self.lines.rest
        current, sunk = self.column(BIAS_COLUMN).bias(own, bias)
        for column, codes in enumerate(stages, start=1):
            more, turned = self.column(column).still(own, codes, (rest, rest))
            current, sunk = current + more, sunk + turned
        return current, sunk


def check_room(name: str, neurons: int, chip: NefChip) -> None:
    """Raise `ParameterError` for neurons beyond the chip's; `name` is of the ensemble that has the last."""
    if neurons > chip.neurons:
        raise ParameterError(
            f"{name}: neurons up to number {neurons}, the chip has {chip.neurons}; take fewer neurons"
        )


def check_columns(name: str, dimensions: int, currents: int) -> None:
    """Raise `ParameterError` for more columns of stages than an ensemble's neurons have.

    name: of the ensemble; dimensions: of its vector, which take a column each; currents: that connections
    into its neurons bring, which take `MOST_COLUMNS` each. A column is the bias's.
    """
    columns = 1 + dimensions + MOST_COLUMNS * currents
    if columns > COLUMNS:
        raise ParameterError(
            f"{name}: {dimensions} dimensions and {currents} currents into its neurons take {columns} encoder"
            f" columns, the chip has {COLUMNS}; split it into ensembles of fewer dimensions, or decode what"
            " comes to fewer numbers before its neurons"
        )


def check_filters(count: int) -> None:
    """Raise `ParameterError` for more filters than the chip has."""
    if count > FILTERS:
        raise ParameterError(
            f"nef-chip: {count} filters, the chip has {FILTERS}; take fewer slots or time constants"
        )


def check_lines(count: int) -> None:
    """Raise `ParameterError` for more slots than the chip has lines, a filter's each."""
    if count > FILTERS:
        raise ParameterError(
            f"nef-chip: {count} dimensions and currents into neurons, the chip has {FILTERS} lines; take"
            " fewer ensembles, or some of fewer dimensions"
        )


@lru_cache(maxsize=8)
def _law(silicon: Silicon, neurons: int, biases: Biases) -> NeuronLaw:
    return neurons_on(silicon, neurons, biases)


@lru_cache(maxsize=8)
def _lines(silicon: Silicon, biases: Biases) -> Lines:
    return lines_on(silicon, FILTERS, biases)


@lru_cache(maxsize=8)
def _unit(silicon: Silicon, neurons: int, biases: Biases) -> float:
    stages = _stages(silicon, BIAS_COLUMN, neurons, biases)
    return float(np.median(stages.signal[:_SAMPLED, _BIT]) / 2**_BIT)


@lru_cache(maxsize=8)
def _power(silicon: Silicon, biases: Biases) -> float:
    """As of `Conditions.power` under the law with second-order effects."""
    lines = _lines(silicon, biases)
    slopes = 0.5 * (lines.above + lines.below)
    return float(_typical(silicon, biases, USUAL).power * np.median(slopes))


@lru_cache(maxsize=64)
def _typical(silicon: Silicon, biases: Biases, tau: float) -> Filters:
    """A filter without deviations of its own."""
    return filters_on(replace(silicon, die=silicon.die.without_mismatch()), np.array([tau]), biases)


@lru_cache(maxsize=2 * COLUMNS)
def _stages(silicon: Silicon, column: int, neurons: int, biases: Biases) -> Column:
    return column_on(silicon, column, neurons, biases)
