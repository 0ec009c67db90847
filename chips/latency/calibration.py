"""Calibration of a latency chip: bias codes that bring its times on a die to those of its design.

What a tester can time, and what a bias line then corrects, `I -> I T / T_wanted`, as near as codes come:

    taps          each tap's delay, by its own code
    integrators   each integrating neuron's latency for one input, the mean over its synapses, by its own code
    race          each first-layer cell's latency without any input, by its own code
    shared        all other times, the mean over the die, by the code of their line

Which of them are calibrated is a choice; the chip is what it is for the rest. Times are the model's own, at
the temperature of the silicon that is given, as a tester would have them from spikes; `ROUNDS` times, so that
what one code changes for another settles. Currents of goal, direction, inhibition and second layer are
scaled together, each line's copies alike.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping

import numpy as np

from chips.latency.design import Biases, Design
from chips.latency.model import Lumped, lumped, usual_biases
from circuits.arrays import F64
from circuits.circuit import BiasKind
from circuits.errors import ParameterError
from circuits.silicon.silicon import Silicon

PARTS = ("taps", "integrators", "race", "shared")
ROUNDS = 3

# line: quantity of `Lumped` whose mean is its time
_TIMES: Mapping[str, str] = {
    "step": "step", "window": "window", "tonic": "tonic", "hold": "hold", "block": "block",
    "pulse": "goal_pulse", "inhibition": "inhibition",
}  # fmt: skip


def calibrated(
    design: Design,
    silicon: Silicon,
    kind: BiasKind = "gate",
    parts: Collection[str] = PARTS,
    *,
    area: float = 1.0,
) -> Biases:
    """Return the biases of the chip on a silicon, calibrated at its temperature.

    Parameters
    ----------
    design
        What the chip is designed for.
    silicon
        Process, temperature and die.
    kind
        Kind of the biases.
    parts
        Which of `PARTS` are calibrated.
    area
        Area of the devices over the circuits', a ratio.

    Raises
    ------
    ParameterError
        A part is another, or no code reaches a current.
    """
    for part in parts:
        if part not in PARTS:
            raise ParameterError(f"latency_chip.calibration: {part}, must be one of {', '.join(PARTS)}")
    biases = usual_biases(design, kind, silicon.process)
    wanted = lumped(design, biases, Silicon(silicon.process))
    for _ in range(ROUNDS):
        found = lumped(design, biases, silicon, area)
        current = {name: line.current for name, line in biases.lines.items()}
        factors = _factors(found, wanted, parts)
        biases = biases.with_currents({name: current[name] * factor for name, factor in factors.items()})
    return biases


def _factors(found: Lumped, wanted: Lumped, parts: Collection[str]) -> dict[str, F64]:
    """What each line's currents are multiplied by."""
    factors: dict[str, F64] = {}
    if "taps" in parts:
        factors["tap"] = found.tap / wanted.tap
    if "integrators" in parts:
        factors["integrating"] = _alone(found) / _alone(wanted)
    cell, usual = found.race / found.passive, wanted.race / wanted.passive
    if "race" in parts:
        factors["passive"] = cell / usual
    if "shared" in parts:
        factors |= _shared(found, wanted)
        if "race" not in parts:
            factors["passive"] = np.asarray((cell / usual).mean())
    return factors


def _shared(found: Lumped, wanted: Lumped) -> dict[str, F64]:
    """Factors of lines that the whole die shares, each of the mean over the die."""

    def ratio(time: F64, usual: F64) -> F64:
        return np.asarray(time.mean() / usual.mean())

    factors = {
        line: ratio(getattr(found, name), getattr(wanted, name)) for line, name in _TIMES.items()
    }  # fmt: skip
    factors["goal"] = ratio(np.diag(wanted.goal * wanted.goal_pulse), np.diag(found.goal * found.goal_pulse))
    factors["direction"] = ratio(
        wanted.direction * wanted.direction_pulse, found.direction * found.direction_pulse
    )
    factors["inhibit"] = ratio(wanted.inhibit, found.inhibit)
    factors["second"] = ratio(found.second_charge / found.second, wanted.second_charge / wanted.second)
    factors["recurrent"] = ratio(found.recurrent, wanted.recurrent)
    factors["emergency"] = np.asarray(found.emergency / wanted.emergency)
    return factors


def _alone(c: Lumped) -> F64:
    """Latency of an integrating neuron for one input, s, the mean over its synapses, float64[n]."""
    return np.asarray((c.integrating[:, None] / c.synapse).mean(axis=1))
