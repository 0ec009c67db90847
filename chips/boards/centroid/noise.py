"""Noise of the centroid board's output voltage: k T / C of its hold capacitor and of its low-pass.

A gate leaves `sqrt(k T / C_hold)` on the hold node, and the leak keeps it; the filter's resistor makes
`sqrt(k T / C_filter)`. The followers are noiseless (`circuits.devices.noise`). It is some microvolts, which
matter to the next call interval alone: `chips.boards.vocalization.noise`.
"""

from __future__ import annotations

import math

from circuits.blocks.sonar.centroid_board import Params
from circuits.silicon.process import BOLTZMANN, kelvin
from circuits.silicon.silicon import Silicon


def proximity_noise(silicon: Silicon) -> float:
    """Return the standard deviation of the output voltage, V."""
    p, thermal = Params(), BOLTZMANN * kelvin(silicon.temperature_c)
    return math.sqrt(thermal / p.hold_capacitance + thermal / p.filter_capacitance)
