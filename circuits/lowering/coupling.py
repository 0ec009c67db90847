"""Coupling between the nodes of a layout, by a rule a style: small capacitors that no schematic has.

`bus` draws a cell as a row of its transistors, along which the wires of its ports run side by side in the
order of the ports, over the whole cell; the gate line of each transistor crosses all of them. So

    C(a, b) = beside * length * transistors     of ports that are neighbours
    C(g, b) = crossing                          of every gate g and every port b, once a transistor

Ports that are arrays, and circuits without transistors of their own, have no wires here. A coupled circuit is
a circuit like any other: solver and netlists have its capacitors as they have those that are drawn, and where
a die's capacitors deviate these do too.
"""

from __future__ import annotations

import itertools
from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Literal

from circuits.checks import require_choice
from circuits.circuit import GROUND, Circuit
from circuits.devices import Capacitor, Transistor

Coupling = Literal["none", "bus"]
COUPLINGS: tuple[Coupling, ...] = ("none", "bus")


@dataclass(frozen=True, slots=True)
class Style:
    """Figures of a layout style.

    length: length of a cell for each of its transistors, m. beside: capacitance between two wires that run
    side by side for each length, F/m. crossing: capacitance where a gate line crosses a wire, F.
    """

    length: float
    beside: float
    crossing: float


# For the 1.5 um line. Length and the capacitance between wires of metal a least spacing apart: ours.
# Crossing: 46 aF/um^2 of metal over polysilicon (MOSIS run T69L), lines of 1.6 and 2.4 um (ours).
STYLES: Mapping[Coupling, Style] = MappingProxyType({"bus": Style(40e-6, 40e-12, 0.18e-15)})
"""Figures of each style but `none`."""


def coupled(circuit: Circuit, coupling: Coupling) -> Circuit:
    """The circuit with the capacitors of a layout style, in itself and in the circuits of its instances.

    Parameters
    ----------
    circuit
        The circuit as it is drawn.
    coupling
        The style; `none` gives the circuit itself.

    Raises
    ------
    ParameterError
        There is no such style.
    """
    require_choice("coupling", coupling, COUPLINGS)
    return circuit if coupling == "none" else _coupled(circuit, STYLES[coupling], {})


def _coupled(circuit: Circuit, style: Style, known: dict[int, Circuit]) -> Circuit:
    if id(circuit) not in known:
        instances = tuple(replace(i, circuit=_coupled(i.circuit, style, known)) for i in circuit.instances)
        devices = (*circuit.devices, *_capacitors(circuit, style))
        known[id(circuit)] = replace(circuit, devices=devices, instances=instances)
    return known[id(circuit)]


def _capacitors(circuit: Circuit, style: Style) -> tuple[Capacitor, ...]:
    transistors = [d for d in circuit.devices if isinstance(d, Transistor)]
    wires = [p.name for p in circuit.ports if not p.shape]
    found: dict[tuple[str, str], float] = defaultdict(float)
    for pair in itertools.pairwise(wires):
        found[pair] += style.beside * style.length * len(transistors)
    for device in transistors:
        for wire in wires:
            if device.gate not in (wire, GROUND):
                pair = (wire, device.gate) if (wire, device.gate) in found else (device.gate, wire)
                found[pair] += style.crossing
    prefix = "coupling"
    while any(part.name.startswith(prefix) for part in (*circuit.devices, *circuit.instances)):
        prefix += "_"
    values = ((pair, c) for pair, c in found.items() if c > 0.0)
    return tuple(Capacitor(f"{prefix}{k}", a, b, c) for k, ((a, b), c) in enumerate(values))
