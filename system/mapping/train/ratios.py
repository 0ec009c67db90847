"""What a die makes of a mapped network's parts: ratios to the nominal die, measured of the chip's own tables.

    neuron:   rheobase, T (from the rate at `AIM` rheobases) and refractory period
    filter:   time constant, and of each weight the jump of S that an event brings:
              Q / (C U_T / kappa_n), times (I_S E)^(1 / p), by which the output makes a current of it

Q is that of each synapse with its own pulse, at each of its levels, or that of so many events of a neuron's
four virtual synapses. As on a bench, the weights of a kind are then scaled until the mean rate under them is
the nominal die's (`system.mapping.rolls.calibrate`, whose rheobases these are).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from chips.rolls.chip import STEP
from chips.rolls.circuit import FILTERS, Params
from chips.rolls.lumped.filter import Filter, line_voltage
from chips.rolls.parts import part_gates
from chips.rolls.portrait import rates, rheobase
from chips.rolls.program.address import NEURONS, VIRTUAL_LINES
from chips.rolls.program.program import level_current
from chips.rolls.synapse.charge import charge_of, draw_of
from chips.rolls.tables import Built, build_tables, prepare, synapse_devices
from circuits.arrays import F64
from circuits.catalogue import later
from circuits.silicon.process import ROLLS_180
from circuits.silicon.silicon import Silicon
from system.mapping.rolls.calibrate import AIM, EXCITED
from system.mapping.rolls.filters import BESIDE, SIGN
from system.mapping.rolls.levels import MOST
from system.mapping.rolls.mapped import Mapped
from system.mapping.rolls.neuron import KIND, period

optimise = later("scipy.optimize")

LONG, LEAST = 0.3, 0.1  # s, of the run that measures a rate; Hz, of a neuron that is silent in it; ours
_FARTHEST = 10.0  # times that a calibrated weight may be off; ours


@dataclass(frozen=True, slots=True, eq=False)
class Ratios:
    """A die over the nominal one, ratios of all neurons of the chip.

    rheobase, tau, refractory : of its neurons, float64[256].
    filters : time constants of the filters in use by name, float64[256] each.
    weights : jumps of S by the same names: of so many virtual events, float64[events, 256], or of levels
    0 to 4, float64[5, 256, n] of targets and sources.
    """

    rheobase: F64
    tau: F64
    refractory: F64
    filters: Mapping[str, F64]
    weights: Mapping[str, F64]


def ratios_of(mapped: Mapped) -> Callable[[Silicon], Ratios]:
    """Return what measures a die (its silicon) for a mapped network, with the codes of the nominal die."""
    nominal = _measured(mapped, Silicon(ROLLS_180))

    def of(silicon: Silicon) -> Ratios:
        die = _measured(mapped, silicon)
        return Ratios(
            die.rheobase / nominal.rheobase,
            die.tau / nominal.tau,
            die.refractory / nominal.refractory,
            {name: die.filters[name] / nominal.filters[name] for name in die.filters},
            {name: die.weights[name] / nominal.weights[name] for name in die.weights},
        )

    return of


def calibrated_form(mapped: Mapped, die: Ratios) -> Ratios:
    """Return a die whose weights of each filter bring the nominal mean rate, as after a calibration."""
    place = min(mapped.placed, key=lambda p: p.slow)
    powers = {f.name: f.power for f in mapped.filters}
    means = {name: _mean(w) * die.filters[name] for name, w in die.weights.items()}
    scales: dict[str, float] = {}

    def off(log: float, name: str) -> float:
        """Mean rate over the nominal one, less 1, with the weights of a filter scaled."""
        own = {**scales, name: np.exp(log)}
        bring = AIM * (own[name] * means[name]) ** powers[name]
        aim = AIM
        if SIGN[name] < 0:
            beside = EXCITED * (own.get(BESIDE, 1.0) * means[BESIDE]) ** powers[BESIDE]
            bring, aim = beside - bring, EXCITED - AIM
        over = np.maximum(bring / die.rheobase - 1.0, 1e-3)
        each = 1.0 / period(over, place.tau * die.tau, place.slope, place.refractory * die.refractory)
        wanted = 1.0 / period(np.array(aim - 1.0), place.tau, place.slope, place.refractory)
        return float(each.mean() / wanted - 1.0)

    ends = -np.log(_FARTHEST), np.log(_FARTHEST)
    for name in sorted(means, key=lambda each: (SIGN[each] < 0, each != BESIDE)):
        scales[name] = float(np.exp(optimise.brentq(off, *ends, args=(name,))))
    return replace(die, weights={name: scales[name] * w for name, w in die.weights.items()})


def _mean(weights: F64) -> F64:
    """Mean jump of a neuron's weights, over those that are there, float64[256]."""
    return np.asarray(weights[1:].mean(axis=(0, 2)) if weights.ndim == 3 else weights[VIRTUAL_LINES])


def _measured(mapped: Mapped, silicon: Silicon) -> Ratios:
    """Measure a die, in SI units."""
    built = build_tables(_params(mapped), mapped.program, KIND, silicon, STEP)
    threshold = rheobase(built.neurons)
    fired = rates(built.neurons, AIM * threshold[None], np.array([LONG]))[0]
    refractory = built.neurons.refractory
    own = {f.name: built.filters[FILTERS.index(f.name)] for f in mapped.filters}
    weights = {name: _weights(mapped, silicon, built, name, f) for name, f in own.items()}
    return Ratios(
        threshold,
        1.0 / np.maximum(fired, LEAST) - refractory,
        refractory.copy(),
        {n: f.tau for n, f in own.items()},
        weights,
    )


def _weights(mapped: Mapped, silicon: Silicon, built: Built, name: str, one: Filter) -> F64:
    """Jumps of S that events through a filter bring, by the number of events or the level."""
    # what the output makes of a jump of z, as a factor on it
    output = (one.specific * one.scale) ** (1.0 / one.power)
    k = FILTERS.index(name)
    if k >= 2:
        each = built.tables.virtual[4 * (k - 2) : 4 * (k - 2) + VIRTUAL_LINES].astype(np.float64)
        line = np.arange(MOST) % VIRTUAL_LINES
        return np.asarray(output * np.concatenate((each[:1], np.cumsum(each[line], axis=0))))
    return np.asarray(output[:, None] * _levels(mapped, silicon, built, name) / one.unit[:, None])


def _levels(mapped: Mapped, silicon: Silicon, built: Built, name: str) -> F64:
    """Charges of levels 0 to 4 of a filter from the network's neurons, C, float64[5, 256, n]; 0 as 1."""
    params, n = _params(mapped), mapped.network.neurons
    gates = {port: np.asarray(v) for port, v in part_gates("synapse", built.gates).items()}
    index = np.arange(NEURONS)[:, None] * NEURONS + np.arange(n)
    d = synapse_devices(params, silicon)._replace(gate=gates).taken(index.ravel())
    model, lengths = prepare(params, silicon.process).synapse, np.tile(built.lengths[:n], NEURONS)
    found = np.empty((5, *index.shape))
    for k in range(1, 5):
        level = SIGN[name] * k
        current = level_current(mapped.program.biases, level)
        line = line_voltage(built.filters[FILTERS.index(name)], current, d.u_t)
        found[k] = charge_of(draw_of(model, d, level, line), lengths).reshape(index.shape)
    found[0] = found[1]
    return found


def _params(mapped: Mapped) -> Params:
    return Params(virtual=mapped.program.virtual)


def nominal_ratios(mapped: Mapped) -> Ratios:
    """Return the nominal die, whose ratios are all 1."""
    one, n = np.ones(NEURONS), mapped.network.neurons
    weights = {
        f.name: np.ones((5, NEURONS, n)) if f.name in FILTERS[:2] else np.ones((MOST + 1, NEURONS))
        for f in mapped.filters
    }
    return Ratios(one, one, one, dict.fromkeys(weights, one), weights)
