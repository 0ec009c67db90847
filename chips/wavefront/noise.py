"""Jitter of the wavefront chip's axons: why one die may plan two ways that are almost equally long.

An axon's delay D is a charge over the current I of its sink: shot noise moves it by `sqrt(phi q D / I)`, the
sink's flicker by `D psi kappa dV_T0 / U_T`, the mean of its threshold's wander over D; phi and psi
(`chips.shot_noise`) are nearly 1. All edges that leave a cell have its axon's jitter. From plan to plan the
wander is drawn anew: plans are taken to be far apart in time. Left out: the comparator's noise, nanoseconds
of jitter. A lone axon's circuit has the same white deviation within 0.5 % and 2 to 3 % more of flicker's by
linear theory (`circuits.solver.noise.event_jitter`), codes 1 to 9.
"""

from __future__ import annotations

import numpy as np

from chips.noise import SiliconNoise
from chips.shot_noise import current_wander, shot_share, steepness
from chips.wavefront.axon_conditions import SINK, AxonModel, axon_tables, conditions, process_shifts
from chips.wavefront.model import axon_draws
from circuits.arrays import F64
from circuits.devices.ekv import interpolation
from circuits.errors import ParameterError
from circuits.lowering.on_die import transistor_of
from circuits.silicon.die import philox
from circuits.silicon.process import ELEMENTARY_CHARGE
from circuits.silicon.silicon import Silicon
from circuits.solver.noise.transient import noise_keys, noise_place


def axon_jitter(model: AxonModel, silicon: Silicon, delays: F64, noise: SiliconNoise, number: int) -> F64:
    """Return what is added to the axons' delays in plan `number`, s, float64[n], 0 for a blocked one.

    delays: s, inf where blocked, float64[n]. Raises `ParameterError` for a number below 0.
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
    """Return the standard deviation of each axon's delay, s, float64[n], 0 for a blocked one."""
    open_ = np.isfinite(delays)
    if not open_.any():
        return np.zeros(delays.size)
    own = np.where(open_, delays, delays[open_].min())
    area = model.area * transistor_of(model.axon, SINK).gate_area
    current, specific = sink_currents(model, silicon)
    steep = steepness(current, specific)
    wander = current_wander(silicon, noise, "n", area, own, steep)
    white = shot_share(current, specific) * ELEMENTARY_CHARGE * own / current
    return np.where(open_, np.sqrt(white + wander * own**2), 0.0)


def sink_currents(model: AxonModel, silicon: Silicon) -> tuple[F64, F64]:
    """Return current and specific current of each axon's sink on this die, A, float64[n]."""
    c = conditions(axon_tables(model, silicon), silicon, process_shifts(silicon))
    draws = axon_draws(model, silicon)
    specific = c.specific_current * (1.0 + draws.beta)
    carried = interpolation(2.0 * (c.pinch - c.slope * draws.sink))
    return np.asarray(specific * carried), np.asarray(specific)
