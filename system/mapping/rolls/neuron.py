"""ROLLS' neuron as an integrator with a constant leak and an upstroke, and codes near to what is asked.

With the threshold bias far above the leak (`ABOVE`) all input enters the membrane, and inhibition is taken
off it one to one. The nominal neuron then follows

    T dv/dt = n + e^((v - 1) / d),   n = I / I_rheo - 1,   v >= 0

(the exponential is the positive feedback of the spike), whose rate has a closed form,

    1 / rate = t_ref + T / n (1 + d ln(n + e^(-1 / d)))

T in proportion to 1 / I_leak. T, d, t_ref and I_rheo are measured of the circuit's model at the codes. A
neuron that is asked for, with a leak that grows with the membrane's voltage, has another curve: T and the
current `scale` (in its units) at which the chip's neuron begins to fire are chosen so that the logarithms of
both rates are nearest between currents `SPAN`.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from chips.rolls.calibration import code_for
from chips.rolls.circuit import Params
from chips.rolls.neuron.kernel import Neurons
from chips.rolls.neuron.model import neurons_of
from chips.rolls.portrait import LONGEST, neuron_devices, rates, rheobase
from chips.rolls.program.bias_file import BiasTable
from chips.rolls.tables import prepare
from circuits.arrays import F64
from circuits.blocks.rolls.bias import current_of
from circuits.catalogue import later
from circuits.circuit import BiasKind
from circuits.silicon.process import ROLLS_180
from circuits.silicon.silicon import Silicon
from system.mapping.network import Population

optimise = later("scipy.optimize")

ABOVE = 3000.0  # of the threshold bias over the leak; ours
SPAN = (1.1, 4.0)  # currents that just fire a neuron, between which curves are compared; ours
LEAKS = ("IF_TAU2_N", "IF_TAU1_N")  # of a neuron whose latch is off, and on
THRESHOLD, REFRACTORY = "IF_THR_N", "IF_RFR2_N"
MULTIPLES = np.array([1.1, 1.2, 1.5, 2.0, 3.0, 4.0, 6.0, 10.0, 15.0, 25.0])  # of the rheobase
KIND: BiasKind = "generator"
_OVER = np.geomspace(1e-4, 1e3, 4000)  # rheobases beyond one, at which a curve is read backwards
_PROBE = 40e-12  # A, of the leak at which T I_leak is first measured


@dataclass(frozen=True, slots=True)
class Curve:
    """A neuron's rate over its input.

    rheobase : A; tau : T, s; slope : d; refractory : t_ref, s; error : largest relative error of the law.
    """

    rheobase: float
    tau: float
    slope: float
    refractory: float
    error: float = 0.0

    def rate(self, current: F64) -> F64:
        """Rate at a current, A, in Hz."""
        over = current / self.rheobase - 1.0
        return np.asarray(np.where(over > 0.0, 1.0 / self._period(np.maximum(over, _OVER[0])), 0.0))

    def current(self, rate: F64) -> F64:
        """Current of a rate above 0, A."""
        rates = 1.0 / self._period(_OVER)
        return np.asarray(self.rheobase * (1.0 + np.interp(rate, rates, _OVER)))

    def _period(self, over: F64) -> F64:
        return period(over, self.tau, self.slope, self.refractory)


def period(over: F64, tau: float | F64, slope: float | F64, refractory: float | F64) -> F64:
    """Time between two spikes (s) at currents beyond the rheobase, in rheobases; T and t_ref in s."""
    way = 1.0 + slope * np.log(over + np.exp(-1.0 / slope))
    return np.asarray(refractory + tau / over * way)


@dataclass(frozen=True, slots=True)
class Wanted:
    """A neuron that is asked for: time constants in s, and whether its leak is constant."""

    tau: float
    refractory: float
    constant: bool

    def rate(self, current: F64) -> F64:
        """Rate at a current above 1, Hz."""
        way = 1.0 / (current - 1.0) if self.constant else np.log(current / (current - 1.0))
        return np.asarray(1.0 / (self.refractory + self.tau * way))


@dataclass(frozen=True, slots=True)
class Match:
    """What stands for a neuron: T in s; scale, the asked-for current at which it begins to fire."""

    tau: float
    scale: float


def matched(wanted: Wanted, slope: float, curve: Curve | None = None) -> Match:
    """Return the integrator with a slope d whose curve is nearest; of a `curve` that is there, the scale."""
    currents = np.geomspace(*SPAN, 24)
    aim = np.log(wanted.rate(currents))

    def off(x: F64) -> F64:
        tau = float(np.exp(x[-1])) if curve is None else curve.tau
        one = Curve(float(np.exp(x[0])), tau, slope, (curve or wanted).refractory)
        return np.asarray(np.log(np.maximum(one.rate(currents), 0.1)) - aim)

    start = np.log([0.7, wanted.tau])[: 2 if curve is None else 1]
    limits = ([np.log(0.1), -20.0][: start.size], [np.log(1.05), 5.0][: start.size])
    found = optimise.least_squares(off, start, bounds=limits)
    return Match(float(np.exp(found.x[-1])) if curve is None else curve.tau, float(np.exp(found.x[0])))


def wanted_of(population: Population) -> Wanted:
    """Return the neuron that a population asks for."""
    return Wanted(population.tau, population.refractory, population.leak == "constant")


@lru_cache(maxsize=64)
def one_neuron(biases: BiasTable, slow: int) -> Neurons:
    """Return the nominal neuron at 27 degC, with its leak of LEAKS[slow]."""
    params, silicon = Params(), Silicon(ROLLS_180)
    devices = neuron_devices(params, biases, KIND, silicon).taken(np.array([0]))
    return neurons_of(devices, prepare(params, silicon.process).neuron, np.array([bool(slow)]))


@lru_cache(maxsize=32)
def curve_of(biases: BiasTable, slow: int) -> Curve:
    """Return the curve of the nominal neuron at the codes of a table, with its leak of LEAKS[slow]."""
    neuron = one_neuron(biases, slow)
    rheo = float(rheobase(neuron)[0])
    found = rates(neuron, (rheo * MULTIPLES)[:, None], np.full(MULTIPLES.size, LONGEST))[:, 0]
    fires = found > 0.0

    def off(x: F64) -> F64:
        curve = Curve(rheo, *(float(each) for each in np.exp(x)))
        return np.asarray(np.log(curve.rate(rheo * MULTIPLES[fires]) / found[fires]))

    first = float(np.median((MULTIPLES[fires] - 1.0) / found[fires]))
    best = optimise.least_squares(
        off, np.log([first, 0.15, 1e-3]), bounds=([-20.0, -4.0, -12.0], [5.0, 0.0, 0.0])
    )
    tau, slope, refractory = (float(x) for x in np.exp(best.x))
    return Curve(rheo, tau, slope, refractory, float(np.abs(best.fun).max()))


def with_leak(biases: BiasTable, slow: int, tau: float) -> BiasTable:
    """Return a table whose leak of LEAKS[slow] brings T (s), and whose threshold is far above it."""
    leak = _PROBE
    for _ in range(3):
        code = code_for(leak)
        threshold = max(ABOVE * current_of(code), _threshold(biases, slow))
        biases = biases.with_code(LEAKS[slow], *code).with_code(THRESHOLD, *code_for(threshold))
        leak = current_of(code) * curve_of(biases, slow).tau / tau
    return biases


def with_refractory(biases: BiasTable, wanted: float) -> BiasTable:
    """Return a table whose refractory period is the nearest to `wanted` (s) that the chip has."""
    held = float(one_neuron(biases, 0).refractory[0])
    if wanted <= held:
        return biases
    low, high = 15e-12, biases.current(REFRACTORY)
    for _ in range(9):
        middle = float(np.sqrt(low * high))
        trial = biases.with_code(REFRACTORY, *code_for(middle))
        longer = float(one_neuron(trial, 0).refractory[0]) > wanted
        low, high = (middle, high) if longer else (low, middle)
    return biases.with_code(REFRACTORY, *code_for(high))


def _threshold(biases: BiasTable, slow: int) -> float:
    """What the threshold bias must be at least for the neurons with the other leak, A."""
    return ABOVE * biases.current(LEAKS[1 - slow])
