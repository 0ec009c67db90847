"""Nodes that stand for currents, and what is told of a node: a voltage, or the current that it stands for.

A netlist's inductor, or its source between two nodes, has a current that is an unknown of its own. The
circuit that is read of it has a node for that, `NAME_x23_branch`, which is SPICE's `NAME#branch`, and the
controlled source `NAME` makes the current of that node's voltage: i = g v (`netlists.read.branch.element`).
Whoever shows a run to a user shows i(NAME) in amperes.
"""

from __future__ import annotations

from typing import NamedTuple

from circuits.arrays import F64
from circuits.circuit import GROUND
from circuits.devices import Capacitor, ControlledSource
from circuits.devices.device import Device
from circuits.lowering.kernel import Machine
from circuits.solver.transient import Result

BRANCH = "_x23_branch"
"""What a node that stands for a current has behind the name of its element."""
VALUE = "_x23_value"
"""What a node has behind the name of a source whose value stands there."""
_KINDS: tuple[type[Device], ...] = (ControlledSource, Capacitor)


class Waveform(NamedTuple):
    """What is told of a node of a run: its name, or i(ELEMENT); values, float64[T]; their unit, V or A."""

    name: str
    values: F64
    unit: str

    @property
    def key(self) -> str:
        """The name as a part of the names of measures: `i_l1` of `i(l1)`."""
        return f"i_{self.name[2:-1]}" if self.unit == "A" else self.name


def element_of(node: str) -> str | None:
    """Return the path of the element whose current a node's name says that it stands for, None of others."""
    return node.removesuffix(BRANCH) if node.endswith(BRANCH) else None


def is_followed(node: str) -> bool:
    """Whether a node is the port of a source's value, which a voltage between two other nodes follows."""
    return node.endswith(VALUE)


def branches(machine: Machine) -> dict[str, tuple[str, float]]:
    """Return the nodes that stand for a current: path of the element, and amperes a volt, by node."""
    found = {}
    for group in machine.flat.groups:
        if isinstance(group.device, ControlledSource):
            for k in range(group.nodes.shape[1]):
                label, node = group.label(k), machine.names[int(group.nodes[2, k])]
                if element_of(node) == label:
                    found[node] = label, float(group.parameters["transconductance"][k])
    return found


def inner_devices(machine: Machine) -> frozenset[str]:
    """Return paths of the devices that such elements have beside the one of their current: no user's own."""
    heads = tuple(f"{element}_x23_" for element, _ in branches(machine).values())
    return frozenset(name for kind in _KINDS for name in machine.flat.labels(kind) if name.startswith(heads))


def voltage_nodes(machine: Machine) -> tuple[str, ...]:
    """Return the nodes that stand for no current, ground not among them."""
    currents = branches(machine)
    return tuple(name for name in machine.names if name != GROUND and name not in currents)


def waveform(result: Result, node: str) -> Waveform:
    """Return what is told of a node of a run; raises as `Result` does for a node that was not recorded."""
    if element_of(node) is not None and node in (currents := branches(result.machine)):
        element, conductance = currents[node]
        return Waveform(f"i({element})", conductance * result[node], "A")
    return Waveform(node, result[node], "V")
