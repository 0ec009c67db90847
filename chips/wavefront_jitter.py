"""Jitter of the wavefront chip's axons: why the same die does not plan alike twice where two ways are close.

An axon's delay D is a charge over the current I of its sink: shot noise moves it by `sqrt(q D / I)`, the
sink's flicker by `D kappa dV_T0 / U_T`, the mean of its threshold's wander over D. All edges that leave a
cell have its axon's jitter. From plan to plan the wander is drawn anew: plans are taken to be far apart in
time. Left out: the comparator's noise, nanoseconds of jitter. The solver's trials of a lone axon, white noise
alone: 71 ns where this gives 73 (code 1), 208 ns for 219 (code 9), 60 trials each.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from chips.axon_conditions import AxonModel, axon_tables, conditions, process_shifts
from chips.rebound_jitter import SiliconNoise, mean_variance
from chips.wavefront_model import axon_draws
from circuits.die import philox
from circuits.errors import ParameterError
from circuits.noise import gate_flicker, noise_model
from circuits.process import ELEMENTARY_CHARGE
from circuits.silicon import Silicon
from circuits.solver.noise_transient import noise_keys, noise_place, relaxations

F64 = NDArray[np.float64]

_FASTEST = 0.1  # of the shortest delay, s: a grid up to whose band flicker is summed


def axon_jitter(model: AxonModel, silicon: Silicon, delays: F64, noise: SiliconNoise, number: int) -> F64:
    """What is added to the axons' delays in plan `number`, float64[n], s; 0 for a blocked one.

    delays: float64[n], s, inf where blocked.
    """
    if number < 0:
        raise ParameterError(f"plan.number: {number}, must be at least 0; count the plans")
    spread = axon_spread(model, silicon, delays, noise)
    root = noise_place(silicon, model.circuit.name)
    key = noise_keys(noise.seed, noise.trial, [f"{root}.axon.ms"])
    counters = np.zeros((4, delays.size), np.uint32)
    counters[0], counters[1] = number & 0xFFFFFFFF, np.arange(delays.size)
    words = np.zeros((2, delays.size), np.uint32)
    philox(np.repeat(key, delays.size, axis=1), counters, words)
    first, second = (words + 0.5) * 2.0**-32
    return np.asarray(spread * np.sqrt(-2.0 * np.log(first)) * np.cos(2.0 * np.pi * second))


def axon_spread(model: AxonModel, silicon: Silicon, delays: F64, noise: SiliconNoise) -> F64:
    """Standard deviation of each axon's delay, white and flicker, float64[n], s; 0 for a blocked one."""
    open_ = np.isfinite(delays)
    if not open_.any():
        return np.zeros(delays.size)
    own = np.where(open_, delays, delays[open_].min())
    flicker = noise_model(silicon.process) if noise.flicker is None else noise.flicker
    rate, variance = relaxations(flicker, _FASTEST * float(own.min()))
    width, length = model.sizes[0]
    area = np.array([model.area * width * length])
    at_gate = float(gate_flicker(flicker, silicon.process, np.ones(1, np.bool_), area)[0])
    wander = at_gate * (mean_variance(rate * own[:, None]) @ variance)
    slope = own * silicon.law("n").kappa / silicon.thermal_voltage
    white = ELEMENTARY_CHARGE * own / sink_currents(model, silicon)
    return np.where(open_, np.sqrt(white + wander * slope**2), 0.0)


def sink_currents(model: AxonModel, silicon: Silicon) -> F64:
    """Current of each axon's sink on this die, float64[n], A."""
    c = conditions(axon_tables(model, silicon), silicon, process_shifts(silicon))
    draws = axon_draws(model, silicon)
    root = np.logaddexp(0.0, c.pinch - c.slope * draws.sink)
    return np.asarray(c.specific_current * (1.0 + draws.beta) * root**2)
