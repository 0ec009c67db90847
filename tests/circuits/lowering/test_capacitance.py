"""The capacitance matrix of nodes is that of the solver's charges."""

import numpy as np
import pytest

from circuits.blocks.sonar import rebound_neuron
from circuits.devices import Source
from circuits.devices.source import Constant
from circuits.errors import UnknownNameError
from circuits.lowering.capacitance import capacitance_matrix, node_capacitances
from circuits.lowering.kernel import to_kernel
from circuits.silicon.process import AMI_1500
from circuits.silicon.silicon import Silicon
from circuits.testbench import Testbench

NODES = ("v_mem", "membrane.v_r", "excitation.v_ex")


def test_it_is_that_of_the_kernel() -> None:
    neuron = rebound_neuron.build()
    sources = tuple(Source(n, n, Constant(0.0)) for n in ("vdd", "call", "echo"))
    machine = to_kernel(Testbench("t", neuron, sources, 1.0), Silicon())
    charge, columns = machine.kernel.charge, [machine.column_of(node) for node in NODES]
    expected = np.zeros((3, 3))
    for a, row in enumerate(columns):
        for entry in range(charge.start[row], charge.start[row + 1]):
            if int(charge.column[entry]) in columns:
                expected[a, columns.index(int(charge.column[entry]))] = charge.value[entry]
    found = capacitance_matrix(neuron, AMI_1500, NODES)
    assert found == pytest.approx(expected, rel=1e-12, abs=1e-30)
    assert np.array_equal(found, found.T)


def test_a_node_that_is_not_there_is_refused() -> None:
    with pytest.raises(UnknownNameError, match="nowhere"):
        capacitance_matrix(rebound_neuron.build(), AMI_1500, ("nowhere",))


def test_node_capacitances_are_the_diagonal_of_the_solver_s_matrix() -> None:
    circuit = rebound_neuron.build()
    stimuli = rebound_neuron.BLOCK.defaults
    machine = to_kernel(rebound_neuron.testbench(circuit, stimuli, 5.0))
    found = node_capacitances(circuit, AMI_1500)
    charge = machine.kernel.charge
    rows = np.repeat(np.arange(machine.kernel.unknowns), np.diff(charge.start))
    for name in ("v_mem", "membrane.v_r", "inhibition.v_inh", "comparator.tail", "axon.rm"):
        column = machine.column_of(name)
        diagonal = charge.value[(rows == column) & (charge.column == column)]
        assert found[name] == pytest.approx(float(diagonal[0]), rel=1e-12)
