"""Ports of a block, several of one kind at a time.

A netlist lists the ports of a circuit in the order in which they are given here.
"""

from __future__ import annotations

from collections.abc import Iterable

from circuits.circuit import Bias, Circuit, Instance, InstanceArray, Node, Port
from circuits.devices.device import Device

SUPPLY = Port("vdd", "supply")
"""The port `vdd`, at which a block gets its supply."""


def event_in(*names: str) -> tuple[Port, ...]:
    """Make ports with these `names` at which events come in, as pulses of the full supply."""
    return tuple(Port(name, "event") for name in names)


def event_out(*names: str) -> tuple[Port, ...]:
    """Make ports with these `names` at which the circuit gives events, as pulses of the full supply."""
    return tuple(Port(name, "event", "out") for name in names)


def analog_in(*names: str) -> tuple[Port, ...]:
    """Make ports with these `names` at which voltages or currents come in."""
    return tuple(Port(name, "analog") for name in names)


def analog_out(*names: str) -> tuple[Port, ...]:
    """Ports at which the circuit gives voltages or currents."""
    return tuple(Port(name, "analog", "out") for name in names)


def bias_in(*names: str) -> tuple[Port, ...]:
    """Make ports with these `names` that biases set."""
    return tuple(Port(name, "bias") for name in names)


def bias_ports(biases: Iterable[Bias]) -> tuple[Port, ...]:
    """The port of each of `biases`, each a single node."""
    return bias_in(*(bias.port for bias in biases))


def biased(
    name: str,
    ports: tuple[Port, ...],
    biases: tuple[Bias, ...],
    devices: tuple[Device, ...] = (),
    instances: tuple[Instance | InstanceArray, ...] = (),
    nodes: tuple[Node, ...] = (),
) -> Circuit:
    """A circuit with biases, whose ports stand behind its other ports; all else is as of a `Circuit`."""
    return Circuit(name, (*ports, *bias_ports(biases)), devices, instances, nodes, biases)
