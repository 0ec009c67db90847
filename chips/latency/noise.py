"""Noise of the latency chip from that of its devices: the same die does not recall alike twice.

A time is a charge over a current, T = Q / I, so that shot noise of the current moves it by

    sigma(T) = sqrt(phi q T / I) = T sqrt(phi q / Q),

a membrane that takes up a charge Q takes it up as if it were Q (1 + xi sqrt(phi q / Q)), and inhibition of a
cell, which as much excitation has to make up for, is off by sqrt(2 phi q / (I T)). Flicker of the current's
device, drawn anew for every ping as for the wavefront chip's axons, moves each by psi kappa / U_T of the mean
of its gate's wander over T. phi and psi, 1 in weak inversion (`chips.shot_noise`), are 0.81 and 0.77 for the
3 nA of a tap; under the full law psi has body effect and mobility reduction in it. Left out: the comparators'
noise, currents that a detector compares, those that switches leak, and how the flicker of one ping goes on in
the next.

Draws are keyed by (seed, trial, quantity, ping): a ping is known by the microsecond in which it begins.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from chips.latency.design import NAME
from chips.latency.model import Lumped, charges_on
from chips.noise import SiliconNoise, die_name
from chips.noise_draw import Draws, new_draws, normals
from chips.shot_noise import current_wander, shot_share, steepness_under
from circuits.arrays import F64
from circuits.blocks.latency.parts import lone_cell
from circuits.lowering.on_die import transistor_of
from circuits.silicon.process import ELEMENTARY_CHARGE, Polarity
from circuits.silicon.silicon import Silicon

# field of `Lumped`: its charge in the record. Times first, then what membranes take up
TIMES = {
    "tap": "tap", "step": "timer", "window": "timer", "hold": "timer", "tonic": "tonic", "block": "timer",
    "goal_pulse": "timer", "direction_pulse": "timer", "inhibition": "timer", "recurrent": "recurrent",
    "emergency": "race",
}  # fmt: skip
CHARGES = ("integrating", "race", "second_charge")
SOURCE = transistor_of(lone_cell(), "mp")  # as all devices whose current is a bias
_MICROSECOND = 1e-6  # s


@dataclass(frozen=True, slots=True, eq=False)
class LatencyNoise:
    """Noise of a chip: relative standard deviations of fields of `Lumped`, and what draws each."""

    spread: dict[str, F64]
    draws: dict[str, Draws]


def noise_of(numbers: Lumped, silicon: Silicon, noise: SiliconNoise, area: float = 1.0) -> LatencyNoise:
    """Return the noise of a chip with these numbers; area: of its devices over the circuits'."""
    spread = {}
    charge = charges_on(silicon)
    for name, kind in TIMES.items():
        length = np.asarray(getattr(numbers, name), dtype=np.float64)
        current = charge[kind] / length
        spread[name] = charge_spread(silicon, noise, current, length, area)
    lengths = {
        "integrating": numbers.integrating / numbers.synapse.mean(axis=1),
        "race": numbers.race / numbers.passive,
        "second_charge": numbers.second_charge / numbers.second,
    }
    for name in CHARGES:
        length = lengths[name]
        spread[name] = charge_spread(silicon, noise, getattr(numbers, name) / length, length, area)
    spread["inhibit"] = charge_spread(silicon, noise, numbers.inhibit, numbers.inhibition, area, "n", 2.0)
    root = die_name(NAME, silicon.die)
    draws = {n: new_draws(noise.seed, noise.trial, f"{root}, {n}", s.size) for n, s in spread.items()}
    return LatencyNoise(spread, draws)


def numbers_of_ping(numbers: Lumped, noise: LatencyNoise, start: float) -> Lumped:
    """Return the numbers of a chip in the ping that begins at `start`, s."""
    found = {}
    for name, spread in noise.spread.items():
        drawn = normals(noise.draws[name], round(start / _MICROSECOND), spread)
        found[name] = getattr(numbers, name) * (1.0 + spread * drawn)
    found["emergency"] = float(found["emergency"])
    return numbers._replace(**found)


def charge_spread(
    silicon: Silicon, noise: SiliconNoise, current: F64, length: F64, area: float = 1.0,
    polarity: Polarity = "p", devices: float = 1.0,
) -> F64:  # fmt: skip
    """Return the relative standard deviation of the charge that currents bring, arrays of one shape.

    current: A; length: for which they flow, s; area: as of `noise_of`; polarity: of the device; devices: how
    many make the shot noise, as two of a mirror.
    """
    law = silicon.law(polarity)
    specific = law.square_current * SOURCE.square
    shot = devices * ELEMENTARY_CHARGE * shot_share(current, specific) / (current * length)
    steep = steepness_under(law, current, specific)
    slow = current_wander(silicon, noise, polarity, SOURCE.gate_area * area, length, steep)
    return np.asarray(np.sqrt(shot + slow))
