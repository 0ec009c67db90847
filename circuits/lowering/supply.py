"""The supply that a circuit is wired to, and the threshold of its events, which is half of it.

The supply of a testbench's circuit is what drives its ports of kind `supply`: the span from the lowest to the
highest value that these take, ground included. The supply of an event port that an instance drives is that of
the instance, which is looked for from circuit to circuit. So two parts on two supplies have a threshold each.
"""

from __future__ import annotations

import numpy as np

from circuits.arrays import F64
from circuits.circuit import GROUND, Circuit, Port, split_reference
from circuits.lowering.kernel import Machine

REARM = 0.8  # share of the way up to the threshold below which a spike detector is armed again


def half_supply(machine: Machine) -> float:
    """Middle of the supply of a testbench's circuit, V; of the process's supply where nothing drives one."""
    low, high = _span(machine, _supplies(machine.testbench.circuit))
    return 0.5 * (high + low)


def spike_levels(machine: Machine) -> F64:
    """Voltages between which spikes are detected at the watched nodes, float64[2, watched], V.

    In the order of the testbench's `watch`: first the threshold that a spike rises through, then the voltage
    below which its detector is armed again.
    """
    circuit = machine.testbench.circuit
    ports = {port.name: port for port in circuit.ports}
    found: list[tuple[float, float]] = []
    for reference in machine.testbench.watch:
        port = ports.get(reference.partition("[")[0])
        if port is None:  # an inner node
            found.append(_levels(*_span(machine, _supplies(circuit))))
            continue
        elements = [reference] if "[" in reference else port.elements()
        found += [_levels(*_span(machine, _wired(circuit, e)), port.threshold) for e in elements]
    return np.array(found).reshape(-1, 2).T.copy()


def _levels(low: float, high: float, threshold: float | None = None) -> tuple[float, float]:
    """Threshold on a supply, half of it unless given, and the voltage below which a detector is armed, V."""
    level = 0.5 * (high + low) if threshold is None else threshold
    return level, low + REARM * (level - low)


def _span(machine: Machine, ports: set[str]) -> tuple[float, float]:
    """Lowest and highest voltage of the supplies at these ports, ground among them."""
    driven = zip(machine.testbench.sources, machine.polylines, strict=False)  # biases come behind the sources
    values = [v for s, (_, v) in driven if s.quantity == "voltage" and split_reference(s.node)[0] in ports]
    if not values:
        return 0.0, machine.silicon.process.v_dd
    return min(0.0, *(float(v.min()) for v in values)), max(0.0, *(float(v.max()) for v in values))


def _wired(circuit: Circuit, node: str) -> set[str]:
    """Supply ports of `circuit` behind a node of it."""
    for instance in circuit.instances:
        for port in instance.circuit.ports:
            inner = _inner(instance.connections[port.name], node, port)
            if inner and port.kind == "event" and port.direction == "out":
                outside = (instance.connections[name] for name in _wired(instance.circuit, inner))
                return {split_reference(name)[0] for name in outside if name != GROUND}
    return _supplies(circuit)


def _inner(connection: str, node: str, port: Port) -> str:
    """Element of an instance's port that meets a node of the parent; empty where none does."""
    if GROUND in {connection, node}:
        return ""
    (name, index), (own, element) = split_reference(connection), split_reference(node)
    if name != own or (index and index != element):
        return ""
    inside = element[len(element) - len(port.shape) :] if port.shape and not index else ()
    return f"{port.name}[{','.join(map(str, inside))}]" if inside else port.name


def _supplies(circuit: Circuit) -> set[str]:
    return {port.name for port in circuit.ports if port.kind == "supply"}
