"""Where the sonar head's parts stand on its chip, and the voltages of its bias lines.

Level units are at `sonar_head/ear[side]/level[k]`, LSO neurons at `sonar_head/lso[side]`, and one copy a line
of the bias generator at `sonar_head/bias`. A part at its place has the chip's own devices.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache

from chips.lso.measure import circuits
from circuits.bias import bias_voltages, rebias
from circuits.circuit import BiasKind, Circuit
from circuits.devices import Transistor
from circuits.errors import ParameterError
from circuits.silicon.die import Place
from circuits.silicon.silicon import Silicon

NAME = "sonar_head"
BIAS_PLACE: Place = ((NAME, ()), ("bias", ()))


def of_area(silicon: Silicon, area: float) -> Silicon:
    """Silicon whose local mismatch is that of devices of so much more area: sigma is as 1 / sqrt(area)."""
    process, factor = silicon.process, 1.0 / math.sqrt(area)
    wider = replace(process, pair_a_vt=process.pair_a_vt * factor, pair_a_beta=process.pair_a_beta * factor)
    return replace(silicon, process=wider)


@lru_cache(maxsize=4)
def line_volts(silicon: Silicon, kind: BiasKind) -> Mapping[str, float]:
    """Voltages of the chip's bias lines by the blocks' ports, V, but the level units' thresholds."""
    found: dict[str, float] = {}
    for circuit in circuits():
        for bias in rebias(circuit, {}, kind).biases:
            if bias.name != "v_threshold":
                placed = replace(bias, place=BIAS_PLACE)
                found[bias.port] = float(bias_voltages(circuit, placed, silicon)[()])
    return found


def transistor_of(circuit: Circuit, device: str) -> Transistor:
    """A transistor of a circuit; raises `ParameterError` for another device."""
    found = circuit.device(device)
    if not isinstance(found, Transistor):
        raise ParameterError(f"{NAME}.{device}: must be a transistor; the model needs its deviations")
    return found


def area_of(circuit: Circuit, device: str) -> float:
    """Gate area of a transistor, m^2."""
    found = transistor_of(circuit, device)
    return found.width * found.length * found.multiplicity


def square_of(circuit: Circuit, device: str) -> float:
    """Width over length of a transistor."""
    found = transistor_of(circuit, device)
    return found.width * found.multiplicity / found.length
