"""Jitter of the wavefront chip's axons: why one die may plan two ways that are almost equally long.

An axon's delay D is a charge over the current I of its sink: shot noise moves it by `sqrt(phi q D / I)`, the
sink's flicker by `D psi kappa dV_T0 / U_T`, the mean of its threshold's wander over D; phi and psi
(`chips.shot_noise`) are nearly 1. Under the full law psi is the sink's `d ln I / dV_T0` over kappa / U_T, and
the Early effect, some 3 % of the current, is left out of both. All edges that leave a cell have its axon's
jitter. From plan to plan the wander is drawn anew: plans are taken to be far apart in time. All sinks have
one line of the generator: where that wanders (`chips.lines.wander`) all axons go faster or slower alike, so
that cells fire in the same order at other times, t + int_0^t d ln I(t') dt'. Left out: the comparator's
noise, nanoseconds of jitter. A lone axon's circuit has the same white deviation within 0.5 % and
2 to 3 % more of flicker's by linear theory (`circuits.solver.noise.event_jitter`), codes 1 to 9.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from chips.lines.wander import swung, wander_draws, wander_of
from chips.noise import SiliconNoise, die_name
from chips.shot_noise import current_wander, shot_share, steepness
from chips.wavefront.axon_conditions import (
    SINK,
    AxonModel,
    axon_tables,
    carried,
    conditions,
    process_shifts,
)
from chips.wavefront.model import axon_draws
from circuits.arrays import F64
from circuits.devices.ekv import interpolation
from circuits.errors import ParameterError
from circuits.lowering.on_die import transistor_of
from circuits.silicon.die import philox
from circuits.silicon.process import ELEMENTARY_CHARGE
from circuits.silicon.silicon import Silicon
from circuits.solver.noise.transient import noise_keys, noise_place

_LINE = "i_delay"
_ROUNDS = 4  # each of which leaves a hundredth of what a ripple of a tenth moves; ours
_SHIFT = 1e-3  # V, of a derivative by the threshold; ours


class Sinks(NamedTuple):
    """Sinks of n axons on a die, float64[n].

    current: A. specific: what it is the inversion's multiple of, A: I_S, times the mobility's fall under the
    full law. steep: `d ln I / dV_T0` over kappa / U_T, a ratio.
    """

    current: F64
    specific: F64
    steep: F64


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
    sink = sinks_on(model, silicon)
    wander = current_wander(silicon, noise, "n", area, own, sink.steep)
    white = shot_share(sink.current, sink.specific) * ELEMENTARY_CHARGE * own / sink.current
    return np.where(open_, np.sqrt(white + wander * own**2), 0.0)


def in_line_time(
    model: AxonModel, silicon: Silicon, arrivals: F64, noise: SiliconNoise, plan: tuple[int, float]
) -> F64:
    """Return when the cells of a wave fire with a line that wanders, s, of the arrivals' shape.

    arrivals: without, s, inf where a cell does not fire; plan: its number, and when it begins, s. Raises
    `ParameterError` for a ripple where the line is none of a generator.
    """
    wander, end = wander_of(model.circuit, [_LINE], silicon, noise), np.isfinite(arrivals)
    last = float(arrivals[end].max(initial=0.0))
    if last == 0.0:
        return arrivals
    lines = wander_draws(wander, silicon, noise, die_name(model.circuit.name, silicon.die), last)
    law = silicon.law("n")
    slope = float(sinks_on(model, silicon).steep.mean()) * law.kappa / silicon.thermal_voltage
    reach = lines.reach(np.zeros(1, np.int64), np.full(1, last), np.full(1, slope))
    faster = 1.0 + float(lines.noise(reach, lines.drawn(plan[0]))[0])
    found, at = arrivals.copy(), arrivals[end]
    now, supply = at / faster, np.broadcast_to(wander.supply, at.shape)
    for _ in range(_ROUNDS):
        now = (at - slope * now * swung(lines.swing, supply, plan[1], now)) / faster
    found[end] = now
    return found


def sinks_on(model: AxonModel, silicon: Silicon) -> Sinks:
    """Return the sink of each axon on the silicon's die, with its drain far."""
    c = conditions(axon_tables(model, silicon), silicon, process_shifts(silicon))
    draws = axon_draws(model, silicon)
    specific = np.asarray(c.specific_current * (1.0 + draws.beta))
    if c.whole is None:
        current = specific * interpolation(2.0 * (c.pinch - c.slope * draws.sink))
        return Sinks(current, specific, steepness(current, specific))
    share, up, down, plain = (np.empty(draws.sink.size) for _ in range(4))
    carried(c, draws.sink, share)
    carried(c, draws.sink - _SHIFT, up)
    carried(c, draws.sink + _SHIFT, down)
    carried(c._replace(whole=c.whole._replace(reduction=0.0)), draws.sink, plain)
    weak = silicon.law("n").kappa / silicon.thermal_voltage
    return Sinks(specific * share, specific * share / plain, np.log(up / down) / (2.0 * _SHIFT * weak))
