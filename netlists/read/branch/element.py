"""Inductors and sources of voltage between any two nodes, whose current is an unknown of its own.

    Lname a b value                  v_ab = L di/dt
    Vname n+ n- value                v_ab = v, where it ties no node to ground or its current is used
    Ename n+ n- c+ c- gain           v_ab = gain v_c
    Hname n+ n- Vother resistance    v_ab = resistance i(Vother)
    Fname n+ n- Vother gain          a current gain i(Vother) from n+ through the source to n-

A circuit has node voltages as its unknowns, so that the current of such an element is one: at a node of its
own, `NAME#branch`, 1 A is 1 V, and 10 mA of an inductor is. That is a gyrator, which is two controlled
sources:

    i = g v_x from a to b,      C dv_x/dt = g (v_ab - v) - g^2 r v_x,      C = g^2 L

with g of `TRANSCONDUCTANCE`, of `INDUCTOR` for L, whose current a run follows to its tolerance of g volts.
It is the element itself and no model of it, but for a resistance r of `RESISTANCE` in series with a source
of voltage, by which the equations can be solved in any order. A source's own value stands at a port of its
own, `Vname#value`. All of this has a form in every netlist that a circuit is written as.

Whoever shows a run tells such a node as the current i(NAME), in amperes (`circuits.measure.branch`).
"""

from __future__ import annotations

from typing import NamedTuple

from circuits.circuit import GROUND
from circuits.devices import Capacitor, ControlledSource, Device
from netlists.read.text.name import circuit_name

TRANSCONDUCTANCE = 1.0  # S: 1 A of an element's current is 1 V at its node; ours
INDUCTOR = 10e-3  # S: 10 mA of an inductor's current is 1 V at its node; ours
RESISTANCE = 1e-6  # Ohm, in series with every source of voltage between two nodes; ours


class Branch(NamedTuple):
    """An element whose current has a node, `branch_node(name)`.

    name: as it is written; positive, negative: nodes of the circuit that its current leaves and enters.
    """

    name: str
    positive: str
    negative: str

    def inductor(self, inductance: float) -> tuple[Device, ...]:
        """Devices of an inductance, H."""
        own = circuit_name(f"{self.name}#charge")
        charge = Capacitor(own, branch_node(self.name), GROUND, INDUCTOR**2 * inductance)
        return (*self._gyrator(INDUCTOR), charge)

    def follower(self, high: str, low: str, gain: float) -> tuple[Device, ...]:
        """Devices that hold the voltage at `gain` times that between the nodes `high` and `low`.

        A node of another element's current has 1 V for 1 A.
        """
        own, loss = (circuit_name(f"{self.name}#{part}") for part in ("set", "loss"))
        at = branch_node(self.name), GROUND
        return (
            *self._gyrator(TRANSCONDUCTANCE),
            ControlledSource(own, *at, high, low, TRANSCONDUCTANCE * gain),
            ControlledSource(loss, *at, *at, TRANSCONDUCTANCE**2 * RESISTANCE),
        )

    def _gyrator(self, transconductance: float) -> tuple[Device, ...]:
        """The element's current first, by its own name."""
        node, ends = branch_node(self.name), (self.positive, self.negative)
        back = circuit_name(f"{self.name}#back")
        return (
            ControlledSource(circuit_name(self.name), *ends, node, GROUND, transconductance),
            ControlledSource(back, GROUND, node, *ends, transconductance),
        )


def branch_node(name: str) -> str:
    """The node whose voltage is the current of the element `name`, 1 V for 1 A."""
    return circuit_name(f"{name}#branch")


def value_node(name: str) -> str:
    """The port at which the value of the source `name` stands, V."""
    return circuit_name(f"{name}#value")
