"""Noise of the latency chip from that of its devices: why the same die does not recall alike twice.

A time is a charge over a current, T = Q / I, so that shot noise of the current moves it by

    sigma(T) = sqrt(q T / I) = T sqrt(q / Q),

a membrane that takes up a charge Q takes it up as if it were Q (1 + xi sqrt(q / Q)), and inhibition of a
cell, which as much excitation has to make up for, is off by sqrt(2 q / (I T)). Flicker of the current's
device, drawn anew for every ping as for the wavefront chip's axons, moves each by kappa / U_T of the mean of
its gate's wander over T. Left out: the comparators' noise, currents that a detector compares, and how the
flicker of one ping goes on in the next.

Draws are keyed by (seed, trial, quantity, ping): a ping is known by the microsecond in which it begins.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from chips.latency_design import NAME
from chips.latency_model import SIZE, Lumped, charges_on
from chips.noise_draw import Draws, draw, new_draws
from chips.rebound_jitter import SiliconNoise, mean_variance
from circuits.noise import gate_flicker, noise_model
from circuits.process import ELEMENTARY_CHARGE
from circuits.silicon import Silicon
from circuits.solver.noise_transient import relaxations

F64 = NDArray[np.float64]

# field of `Lumped`: its charge in the record. Times first, then what membranes take up
TIMES = {
    "tap": "tap", "step": "timer", "window": "timer", "hold": "timer", "tonic": "tonic", "block": "timer",
    "goal_pulse": "timer", "direction_pulse": "timer", "inhibition": "timer", "recurrent": "recurrent",
    "emergency": "race",
}  # fmt: skip
CHARGES = ("integrating", "race", "second_charge")
_FASTEST = 0.1  # of a field's shortest time: a grid up to whose band flicker is summed
_AREA = SIZE[0] * SIZE[1] * 1e-12  # m^2
_MICROSECOND = 1e-6  # s


@dataclass(frozen=True, slots=True, eq=False)
class LatencyNoise:
    """Relative deviations of the fields of a chip's numbers, arrays as they have, and what draws them."""

    spread: dict[str, F64]
    draws: dict[str, Draws]


def noise_of(numbers: Lumped, silicon: Silicon, noise: SiliconNoise, area: float = 1.0) -> LatencyNoise:
    """Noise of a chip with these numbers; area: of its devices, over the circuits'."""
    spread = {}
    charge = charges_on(silicon)
    for name, kind in TIMES.items():
        length = np.asarray(getattr(numbers, name), dtype=np.float64)
        spread[name] = np.sqrt(ELEMENTARY_CHARGE / charge[kind] + _wander(silicon, noise, length, area, "p"))
    lengths = {
        "integrating": numbers.integrating / numbers.synapse.mean(axis=1),
        "race": numbers.race / numbers.passive,
        "second_charge": numbers.second_charge / numbers.second,
    }
    for name in CHARGES:
        taken = getattr(numbers, name)
        spread[name] = np.sqrt(ELEMENTARY_CHARGE / taken + _wander(silicon, noise, lengths[name], area, "p"))
    passed = numbers.inhibit * numbers.inhibition
    spread["inhibit"] = np.sqrt(
        2.0 * ELEMENTARY_CHARGE / passed + _wander(silicon, noise, numbers.inhibition, area, "n")
    )
    die = silicon.die
    root = f"{NAME} of {die.lot}/{die.number}"
    draws = {n: new_draws(noise.seed, noise.trial, f"{root}, {n}", s.size) for n, s in spread.items()}
    return LatencyNoise(spread, draws)


def numbers_of_ping(numbers: Lumped, noise: LatencyNoise, start: float) -> Lumped:
    """Numbers of a chip in the ping that begins at `start`, s."""
    found = {}
    for name, spread in noise.spread.items():
        fixed = noise.draws[name]
        # working space of its own, so that a chip may answer several threads
        own = Draws(fixed.keys, fixed.counters.copy(), fixed.words.copy(), fixed.normal.copy())
        draw(own, round(start / _MICROSECOND), 0)
        drawn = own.normal[: spread.size].reshape(spread.shape)
        found[name] = getattr(numbers, name) * (1.0 + spread * drawn)
    found["emergency"] = float(found["emergency"])
    return numbers._replace(**found)


def _wander(silicon: Silicon, noise: SiliconNoise, length: F64, area: float, polarity: str) -> F64:
    """Relative variance of currents over `length` (s) that flicker makes."""
    flicker = noise_model(silicon.process) if noise.flicker is None else noise.flicker
    rate, variance = relaxations(flicker, _FASTEST * float(length.min()))
    is_n = np.array([polarity == "n"])
    at_gate = float(gate_flicker(flicker, silicon.process, is_n, np.array([_AREA * area]))[0])
    slope = silicon.law("n" if polarity == "n" else "p").kappa / silicon.thermal_voltage
    if not math.isfinite(slope) or rate.size == 0:
        return np.zeros(length.shape)
    return np.asarray(slope**2 * at_gate * (mean_variance(rate * length[..., None]) @ variance))
