"""Where the sonar head's parts stand on its chip, and the voltages of its bias lines.

Level units are at `sonar_head/ear[side]/level[k]`, LSO neurons at `sonar_head/lso[side]`, and one copy a line
of ideal biases at `sonar_head/bias`. A part at its place has the chip's own devices.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache

from chips.lso.measure import circuits
from circuits.bias import bias_voltages, rebias
from circuits.circuit import BiasKind, Circuit
from circuits.place import bias_path
from circuits.silicon.die import Place
from circuits.silicon.silicon import Silicon

NAME = "sonar_head"
Currents = tuple[tuple[str, float], ...]
"""Biases by name, and their currents, A."""
BIAS_PLACE: Place = ((NAME, ()), ("bias", ()))


@lru_cache(maxsize=4)
def line_volts(silicon: Silicon, kind: BiasKind, currents: Currents = ()) -> Mapping[str, float]:
    """Return the voltages of the chip's bias lines by the blocks' ports, V, without the thresholds.

    currents: of biases by name, A, in the place of the circuits' own.
    """
    return {
        bias.port: float(bias_voltages(circuit, bias, silicon)[()])
        for circuit in biased(kind, currents)
        for bias in circuit.biases
        if bias.name != "v_threshold"
    }


def biased(kind: BiasKind, currents: Currents = ()) -> tuple[Circuit, ...]:
    """Return the chip's circuits, whose biases are those of its lines; arguments as of `line_volts`."""
    found = []
    for circuit in circuits():
        own = {b.name for b in circuit.biases}
        made = rebias(circuit, {n: i for n, i in currents if n in own}, kind)
        lines = {b.port: ((NAME, ()), *bias_path(b.port, ())) for b in made.biases}
        placed = (replace(b, place=lines[b.port] if kind == "generator" else BIAS_PLACE) for b in made.biases)
        found.append(replace(made, biases=tuple(placed)))
    return tuple(found)
