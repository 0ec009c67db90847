"""Noise of the latency chip from that of its devices: the same die does not recall alike twice.

A time is a charge over a current, T = Q / I, so that shot noise of the current moves it by

    sigma(T) = sqrt(phi q T / I) = T sqrt(phi q / Q),

a membrane that takes up a charge Q takes it up as if it were Q (1 + xi sqrt(phi q / Q)), and inhibition of a
cell, which as much excitation has to make up for, is off by sqrt(2 phi q / (I T)). Flicker of the current's
device, drawn anew for every ping as for the wavefront chip's axons, moves each by psi kappa / U_T of the mean
of its gate's wander over T. phi and psi, 1 in weak inversion (`chips.shot_noise`), are 0.81 and 0.77 for the
3 nA of a tap; under the full law psi has body effect and mobility reduction in it. The lines of a generator
wander (`chips.lines.wander`), and with each all the currents that it sets. Left out: the comparators'
noise, currents that a detector compares, those that switches leak, how the flicker of one ping goes on in
the next, and that what a ripple does to a ping's later parts has another phase.

Draws are keyed by (seed, trial, quantity, ping): a ping is known by the microsecond in which it begins.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from chips.latency.design import NAME, REACH, Biases, bias_circuit
from chips.latency.model import Lumped, charges_on
from chips.lines.wander import Reach, WanderDraws, wander_draws, wander_of
from chips.noise import SiliconNoise, die_name
from chips.noise_draw import Draws, new_draws, normals
from chips.shot_noise import current_wander, shot_share, steepness_under
from circuits.arrays import F64, I64
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
# line of the currents behind each of these fields
LINES = {
    "tap": "tap", "step": "step", "window": "window", "hold": "hold", "tonic": "tonic", "block": "block",
    "goal_pulse": "pulse", "direction_pulse": "pulse", "inhibition": "inhibition", "recurrent": "recurrent",
    "emergency": "emergency", "integrating": "integrating", "race": "passive", "second_charge": "second",
    "inhibit": "inhibit",
}  # fmt: skip
SOURCE = transistor_of(lone_cell(), "mp")  # as all devices whose current is a bias
_MICROSECOND = 1e-6  # s


@dataclass(frozen=True, slots=True, eq=False)
class LatencyNoise:
    """Noise of a chip: relative standard deviations of fields of `Lumped`, and what draws each.

    lines: the lines of its generator; reach: what they do to each field.
    """

    spread: dict[str, F64]
    draws: dict[str, Draws]
    lines: WanderDraws
    reach: dict[str, Reach]


def noise_of(
    numbers: Lumped, biases: Biases, silicon: Silicon, noise: SiliconNoise, area: float = 1.0
) -> LatencyNoise:
    """Return the noise of a chip with these numbers and biases.

    area: of its devices over the circuits'. Raises `ParameterError` for a ripple on biases that are none of a
    generator's.
    """
    current, length = currents_of(numbers, silicon)
    spread = {n: charge_spread(silicon, noise, current[n], length[n], area) for n in (*TIMES, *CHARGES)}
    spread["inhibit"] = charge_spread(
        silicon, noise, numbers.inhibit, numbers.inhibition, area, "n", devices=2.0
    )
    root = die_name(NAME, silicon.die)
    draws = {n: new_draws(noise.seed, noise.trial, f"{root}, {n}", s.size) for n, s in spread.items()}
    wander = wander_of(bias_circuit(biases), [f"i_{name}" for name in biases.lines], silicon, noise)
    shortest = min(float(t.min()) for t in length.values())
    lines = wander_draws(wander, silicon, noise, root, shortest)
    reach = {
        n: lines.reach(_line_of(n, biases, numbers), length[n], _slope(n, biases, silicon, current[n]))
        for n in spread
    }
    return LatencyNoise(spread, draws, lines, reach)


def numbers_of_ping(numbers: Lumped, noise: LatencyNoise, start: float) -> Lumped:
    """Return the numbers of a chip in the ping that begins at `start`, s."""
    ping = round(start / _MICROSECOND)
    found, lines = {}, noise.lines.drawn(ping)
    for name, spread in noise.spread.items():
        moved = spread * normals(noise.draws[name], ping, spread)
        moved += noise.lines.changes(noise.reach[name], lines, start)
        found[name] = getattr(numbers, name) * (1.0 + moved)
    found["emergency"] = float(found["emergency"])
    return numbers._replace(**found)


def currents_of(numbers: Lumped, silicon: Silicon) -> tuple[dict[str, F64], dict[str, F64]]:
    """Return the currents behind fields of a chip's numbers, A, and for how long each flows, s."""
    charge = charges_on(silicon)
    length = {name: np.asarray(getattr(numbers, name), dtype=np.float64) for name in TIMES}
    length |= {
        "integrating": numbers.integrating / numbers.synapse.mean(axis=1),
        "race": numbers.race / numbers.passive,
        "second_charge": numbers.second_charge / numbers.second,
        "inhibit": numbers.inhibition,
    }
    current = {name: charge[kind] / length[name] for name, kind in TIMES.items()}
    current |= {name: getattr(numbers, name) / length[name] for name in CHARGES}
    return current | {"inhibit": numbers.inhibit}, length


def _line_of(field: str, biases: Biases, numbers: Lumped) -> I64:
    """Number of the line behind each element of a field, all lines being in the order of the biases."""
    sizes = {name: line.current.size for name, line in biases.lines.items()}
    names = list(sizes)
    begin = sum(sizes[name] for name in names[: names.index(LINES[field])])
    if field == "inhibit":
        return begin + np.abs(np.arange(numbers.inhibit.shape[-1]) - REACH)  # by how far the cells are apart
    if field == "second_charge":
        return begin + numbers.group
    return begin + np.arange(sizes[LINES[field]]).reshape(biases.lines[LINES[field]].current.shape)


def _slope(field: str, biases: Biases, silicon: Silicon, current: F64) -> F64:
    """By how much a field changes with the gate-source voltage of its line, relative, 1/V."""
    polarity = biases.lines[LINES[field]].polarity
    law = silicon.law(polarity)
    steep = steepness_under(law, current, law.square_current * SOURCE.square) * law.kappa
    return (1.0 if field == "inhibit" else -1.0) * steep / silicon.thermal_voltage


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
