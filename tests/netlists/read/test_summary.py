"""What a circuit consists of."""

from circuits.circuit import Circuit, Instance, InstanceArray
from circuits.devices import Resistor
from circuits.lowering.flatten import flatten
from circuits.registry import BLOCKS, load_block
from netlists.read.summary import summarise


def test_counts_are_those_of_the_flat_circuit() -> None:
    for name in BLOCKS:
        block = load_block(name)
        circuit = block.build()
        flat = flatten(circuit)
        summary = summarise(circuit)
        assert sum(summary.devices.values()) == sum(g.nodes.shape[1] for g in flat.groups), name
        assert summary.nodes == flat.count - 1, name


def test_arrays_are_counted_not_listed() -> None:
    circuit = Circuit("leaf", devices=(Resistor("r1", "a", "b", 1.0), Resistor("r2", "b", "0", 1.0)))
    for _ in range(5):
        circuit = Circuit(
            "node", instances=(InstanceArray("x", circuit, (1000,), {}), Instance("y", circuit, {}))
        )
    summary = summarise(circuit)
    assert summary.devices == {"resistor": 2 * 1001**5}
    assert summary.nodes == 2 * 1001**5
    assert summary.circuits == ("node", "leaf")
