"""Two circuits flattened side by side."""

import pytest

from circuits.circuit import Circuit, InstanceArray, Port
from circuits.devices import Resistor
from circuits.errors import ParameterError
from circuits.silicon.silicon import Deviation
from netlists.compare.pair import count_devices, pair_of

CELL = Circuit("cell", (Port("p", "analog"),), (Resistor("r1", "p", "x", 1.0), Resistor("r2", "x", "0", 2.0)))


def chip(count: int) -> Circuit:
    return Circuit("chip", (Port("p", "analog"),), (), (InstanceArray("a", CELL, (count,), {"p": "p"}),))


def test_devices_and_nodes_of_both_stand_one_after_the_other() -> None:
    pair = pair_of(chip(2), CELL, ({}, {"r2": Deviation(1e-3, 0.1)}))
    assert [d.path for d in pair.devices] == ["a[0].r1", "a[1].r1", "a[0].r2", "a[1].r2", "r1", "r2"]
    assert (pair.devices_a, pair.nodes_a) == (4, 4)
    assert pair.node_names == ["0", "p", "a[0].x", "a[1].x", "0", "p", "x"]
    assert pair.ports == ({"p": 1}, {"p": 5})
    assert [pair.node_names[n] for n in pair.devices[3].nodes] == ["a[1].x", "0"]
    assert pair.devices[5].sizes == (
        ("resistance", 2.0),
        ("deviation of V_T0", 1e-3),
        ("deviation of beta", 0.1),
    )


def test_devices_are_counted_without_listing_them() -> None:
    circuit = chip(1000)
    for _ in range(3):
        circuit = Circuit(
            "outer", (Port("p", "analog"),), (), (InstanceArray("a", circuit, (1000,), {"p": "p"}),)
        )
    assert count_devices(circuit) == 2 * 1000**4
    with pytest.raises(ParameterError, match="at most 2000000 can be compared"):
        pair_of(circuit, CELL, ({}, {}))
