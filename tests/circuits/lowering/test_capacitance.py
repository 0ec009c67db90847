"""The capacitance matrix of nodes is that of the solver's charges."""

import numpy as np
import pytest

from circuits.arrays import F64
from circuits.blocks.selection import winner_take_all
from circuits.blocks.sonar import rebound_neuron
from circuits.devices import Source
from circuits.devices.source import Constant
from circuits.errors import UnknownNameError
from circuits.lowering.capacitance import added_capacitances, capacitance_matrix, node_capacitances
from circuits.lowering.capacitors_on_die import capacitor_changes, capacitor_of
from circuits.lowering.kernel import to_kernel
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.testbench import Testbench

NODES = ("v_mem", "membrane.v_r", "excitation.v_ex")


def of_the_kernel(silicon: Silicon) -> F64:
    """The part of the solver's matrix that belongs to `NODES`, F."""
    sources = tuple(Source(n, n, Constant(0.0)) for n in ("vdd", "call", "echo"))
    machine = to_kernel(Testbench("t", rebound_neuron.build(), sources, 1.0), silicon)
    charge, columns = machine.kernel.charge, [machine.column_of(node) for node in NODES]
    expected = np.zeros((3, 3))
    for a, row in enumerate(columns):
        for entry in range(charge.start[row], charge.start[row + 1]):
            if int(charge.column[entry]) in columns:
                expected[a, columns.index(int(charge.column[entry]))] = charge.value[entry]
    return expected


def test_it_is_that_of_the_kernel() -> None:
    found = capacitance_matrix(rebound_neuron.build(), AMI_1500_IDEAL, NODES)
    assert found == pytest.approx(of_the_kernel(Silicon(AMI_1500_IDEAL)), rel=1e-12, abs=1e-30)
    assert np.array_equal(found, found.T)


def test_what_capacitors_add_on_a_die_is_that_of_the_kernel() -> None:
    neuron, silicon = rebound_neuron.build(), Silicon(AMI_1500_IDEAL, die=Die(number=1003, variation="full"))
    changes = capacitor_changes(neuron, silicon, ("membrane.c_m", "membrane.c_r", "excitation.c_ex"))
    added = added_capacitances(neuron, {name: np.ravel(x) for name, x in changes.items()}, NODES)
    # a thousandth of the capacitance: its rounding counts that much more
    expected = of_the_kernel(silicon) - of_the_kernel(Silicon(AMI_1500_IDEAL))
    np.testing.assert_allclose(added, expected[None], rtol=1e-9, atol=1e-27)
    assert (np.diagonal(added[0]) != 0.0).all()


def test_a_capacitor_between_two_nodes_counts_at_both_and_between_them() -> None:
    neuron = rebound_neuron.build()
    added = added_capacitances(neuron, {"axon.c_fb": np.array([0.1, -0.2])}, ("spike", "v_ax"))
    own = np.array([[1.0, -1.0], [-1.0, 1.0]]) * capacitor_of(neuron, "axon.c_fb").capacitance
    np.testing.assert_allclose(added, np.array([0.1, -0.2])[:, None, None] * own, rtol=1e-14)


def test_every_copy_in_an_array_counts() -> None:
    circuit = winner_take_all.build(winner_take_all.Params(cells=3))
    own = node_capacitances(circuit, AMI_1500_IDEAL)
    nodes = [f"{name}[{k}]" for name in ("v_in", "share") for k in range(3)]
    found = capacitance_matrix(circuit, AMI_1500_IDEAL, nodes)
    assert np.diag(found) == pytest.approx([own[n] for n in nodes], rel=1e-12)
    # the overlap of m2 is between a cell's own two nodes
    assert found[:3, 3:] == pytest.approx(-0.2e-9 * 12e-6 * np.eye(3), rel=1e-12, abs=1e-30)


def test_a_node_that_is_not_there_is_refused() -> None:
    with pytest.raises(UnknownNameError, match="nowhere"):
        capacitance_matrix(rebound_neuron.build(), AMI_1500_IDEAL, ("nowhere",))


def test_node_capacitances_are_the_diagonal_of_the_solver_s_matrix() -> None:
    circuit = rebound_neuron.build()
    stimuli = rebound_neuron.BLOCK.defaults
    machine = to_kernel(rebound_neuron.testbench(circuit, stimuli, 5.0))
    found = node_capacitances(circuit, AMI_1500_IDEAL)
    charge = machine.kernel.charge
    rows = np.repeat(np.arange(machine.kernel.unknowns), np.diff(charge.start))
    for name in ("v_mem", "membrane.v_r", "inhibition.v_inh", "comparator.tail", "axon.rm"):
        column = machine.column_of(name)
        diagonal = charge.value[(rows == column) & (charge.column == column)]
        assert found[name] == pytest.approx(float(diagonal[0]), rel=1e-12)
