"""Jitter of the vocalization controller's call interval T, from the noise of its devices.

An interval's phase deviates, relative, by the root of the sum of

    S_Q T / (2 Q^2)      Q = C (V_hi - V_lo), S_Q of the ramp's current: both transistors of the mirror
                         (2 q phi I each), the resistor that sets it (4 k T / R), those of the mix
                         (4 k T R_mix / R^2)
    (sigma(t) / T)^2     of the comparator at the call, below
    (1 + s_d / s)^2 (sigma_d(t) / T)^2
                         of the comparator at the call's end, where the ramp, falling at s_d, meets the other
                         threshold: what it falls for longer, it has to rise again
    (delta I / I)^2      flicker of the mirror, anew each interval
    (b v_p / f)^2        the centroid board's noise v_p at the proximity (`chips.boards.centroid.noise`), b in
    Hz/V

Comparator: the ramp, of slope s, meets a threshold whose node theta has the noise of its three resistors R_k,
and which the output o pulls down with it:

    C_s dtheta/dt = (V_dd - theta) / R_top - theta / R_bottom - (theta - o) / R_fb + i_n
    C_o do/dt = (h + h tanh(A (theta - ramp) / h) - o) / R_o - (o - theta) / R_fb,     h = V_dd / 2

A current i_n at a time before the call moves it by lambda_theta / C_s a coulomb, where lambda' = -J^T lambda
backwards along this way, from lambda = (0, -1 / (do/dt)) where o passes V_dd / 2. So

    sigma(t)^2 = (1/2) 4 k T sum_k (1 / R_k) int (lambda_theta / C_s)^2 dt.

The other threshold is met the same way, all signs turned. Left out: strays, the amplitude stage (microvolts
of volts).
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from chips.boards.centroid.noise import proximity_noise
from chips.boards.vocalization.kernel import Vocalization
from chips.measured.interpolation import table_at
from chips.noise import SiliconNoise
from chips.noise_draw import Draws, draw, new_draws
from chips.shot_noise import current_wander, shot_share, steepness
from circuits.arrays import F64
from circuits.blocks.sonar import board as parts
from circuits.blocks.sonar import vocalization_controller as board
from circuits.catalogue import later
from circuits.compiled import compiled
from circuits.errors import ParameterError
from circuits.lowering.on_die import transistor_of
from circuits.silicon.process import BOLTZMANN, ELEMENTARY_CHARGE, kelvin
from circuits.silicon.silicon import Silicon
from circuits.solver.noise.transient import noise_place

integrate = later("scipy.integrate")

KNOTS = 5  # rates at which the spread is worked out; ours
AHEAD = 1.6e-3  # V below the threshold at which the comparator's way begins, beyond its 1.3 mV; ours
SETTLE = 2e-6  # s, and by how much sooner: time constants of its nodes are below 0.1 us; ours


class OscillatorNoise(NamedTuple):
    """Noise of call intervals, none if its arrays are empty.

    knots: ln(rate / 1 Hz), float64[k]; spread: relative standard deviation of an interval's phase there,
    float64[k]; draws: of each interval.
    """

    knots: F64
    spread: F64
    draws: Draws


def no_oscillator_noise() -> OscillatorNoise:
    """Return the noise of a controller that has none."""
    return OscillatorNoise(np.zeros(0), np.zeros(0), new_draws(0, 0, "", 0))


def oscillator_noise(numbers: Vocalization, silicon: Silicon, noise: SiliconNoise | None) -> OscillatorNoise:
    """Return the noise of a controller of these numbers on a silicon, or none where `noise` is None."""
    if noise is None:
        return no_oscillator_noise()
    rate = np.geomspace(numbers.base, numbers.base + numbers.slope * numbers.v_dd, KNOTS)
    path = f"{noise_place(silicon, 'vocalization_controller')}, interval"
    spread = interval_spread(numbers, silicon, noise, rate)
    return OscillatorNoise(np.log(rate), spread, new_draws(noise.seed, noise.trial, path, 1))


def interval_spread(numbers: Vocalization, silicon: Silicon, noise: SiliconNoise, rate: F64) -> F64:
    """Return the relative standard deviation of call intervals at rates (1/s), white noise and flicker."""
    p, v_dd, thermal = board.Params(), silicon.process.v_dd, BOLTZMANN * kelvin(silicon.temperature_c)
    low, high = board.thresholds(p, v_dd)
    time, charge = 1.0 / rate, p.ramp_capacitance * (high - low)
    current = charge / time
    mirror = transistor_of(board.build(), "m_in")
    specific = silicon.law("p").square_current * mirror.square
    mix = 1.0 / sum(
        1.0 / r for r in (p.mix_input_resistance, p.mix_offset_resistance, p.mix_ground_resistance)
    )
    density = 2.0 * 2.0 * ELEMENTARY_CHARGE * current * shot_share(current, specific)
    density += 4.0 * thermal / p.current_resistance * (1.0 + mix / p.current_resistance)
    slow = 2.0 * current_wander(silicon, noise, "p", mirror.gate_area, time, steepness(current, specific))
    rise = current / p.ramp_capacitance
    fall = low / (p.discharge_resistance * p.ramp_capacitance) - rise
    own = silicon.seen_by(board.build().name)
    met = np.array([comparator_jitter(float(s), own) for s in rise]) / time
    # as good as one for all: the fall hardly depends on the rate
    left = comparator_jitter(float(fall.mean()), own) * (fall / rise + 1.0) / time
    voltage = numbers.slope * proximity_noise(silicon) / rate
    return np.asarray(np.sqrt(0.5 * density * time / charge**2 + met**2 + left**2 + slow + voltage**2))


@lru_cache(maxsize=64)
def comparator_jitter(slope: float, silicon: Silicon) -> float:
    """Return the standard deviation (s) of when the comparator reacts to a ramp of `slope` V/s.

    It is the noise of the comparator's resistors. Raises `ParameterError` for a ramp at which it does not
    call.
    """
    p, v_dd = board.Params(), silicon.process.v_dd
    top, feedback = 1.0 / p.threshold_top_resistance, 1.0 / p.threshold_feedback_resistance
    total = top + feedback + 1.0 / p.threshold_bottom_resistance
    half, output = 0.5 * v_dd, 1.0 / board.COMPARATOR_RESISTANCE
    start, ahead = board.thresholds(p, v_dd)[1], AHEAD + slope * SETTLE

    def at(t: float, y: F64) -> tuple[F64, float]:
        u = parts.GAIN * (y[0] - start + ahead - slope * t) / half
        drive = (half + half * math.tanh(u) - y[1]) * output
        rise = np.array([
            (v_dd * top + y[1] * feedback - y[0] * total) / parts.STRAY,
            (drive - (y[1] - y[0]) * feedback) / board.COMPARATOR_CAPACITANCE,
        ])  # fmt: skip
        return rise, parts.GAIN * (1.0 - math.tanh(u) ** 2)

    def jacobian(t: float, y: F64) -> F64:
        gain = at(t, y)[1] * output + feedback
        return np.array([
            [-total / parts.STRAY, feedback / parts.STRAY],
            [gain / board.COMPARATOR_CAPACITANCE, -(output + feedback) / board.COMPARATOR_CAPACITANCE],
        ])  # fmt: skip

    def called(_: float, y: F64) -> float:
        return float(y[1]) - half

    way = integrate.solve_ivp(
        lambda t, y: at(t, y)[0], (0.0, 2.0 * ahead / slope), [start, v_dd], method="LSODA",
        events=called, dense_output=True, rtol=1e-8, atol=1e-9,
    )  # fmt: skip
    if not way.t_events[0].size:
        raise ParameterError(f"vocalization_controller.slope: {slope:g} V/s, the comparator does not call")
    end, falls = float(way.t_events[0][0]), at(float(way.t_events[0][0]), way.y_events[0][0])[0][1]
    scale = 1.0 / abs(falls)

    def backwards(tau: float, y: F64) -> F64:
        # the integral of lambda_theta^2 beside lambda, in units of its end
        own = jacobian(end - tau, way.sol(end - tau)).T @ y[:2]
        return np.array([own[0], own[1], y[0] * y[0] / parts.STRAY])

    back = integrate.solve_ivp(
        backwards, (0.0, end), [0.0, -math.copysign(1.0, falls), 0.0], method="LSODA", rtol=1e-6, atol=1e-12
    )
    density = 4.0 * BOLTZMANN * kelvin(silicon.temperature_c) * total
    return float(scale * math.sqrt(0.5 * density * back.y[2, -1] / parts.STRAY))


@compiled()
def phase_after_call(n: OscillatorNoise, number: int, rate: float) -> float:
    """Return the phase with which the interval after call `number` begins at a rate (1/s).

    It is 0 without noise.
    """
    if n.knots.size == 0:
        return 0.0
    draw(n.draws, number, 0)
    return float(n.draws.normal[0]) * table_at(n.knots, n.spread, math.log(rate))
