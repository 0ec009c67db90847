"""Closed forms: device equations as text, node capacitances against the solver's matrix."""

from __future__ import annotations

import numpy as np
import pytest

from circuits.blocks.sonar import rebound_neuron
from circuits.devices import DEVICE_TYPES, Transistor
from circuits.lowering.analysis import node_capacitances, to_equation
from circuits.lowering.kernel import to_kernel
from circuits.silicon.silicon import Silicon


@pytest.mark.parametrize("device", DEVICE_TYPES, ids=lambda d: d.__name__)
def test_every_device_type_has_an_equation(device: type) -> None:
    assert device in to_equation.registry


def test_a_transistor_s_equation_has_its_numbers() -> None:
    device = Transistor("m", "n", "d", "g", "s", "0", 3e-6, 1.5e-6)
    # 2 mu Cox U_T^2 / kappa * W/L with U_T = 25.865 mV
    assert "2.752e-07" in to_equation(device, Silicon())
    assert "0.7 ((v_g - v_b) - 0.6)" in to_equation(device, Silicon())


def test_node_capacitances_are_the_diagonal_of_the_solver_s_matrix() -> None:
    circuit = rebound_neuron.build()
    stimuli = rebound_neuron.BLOCK.defaults
    machine = to_kernel(rebound_neuron.testbench(circuit, stimuli, 5.0))
    found = node_capacitances(circuit, Silicon())
    charge = machine.kernel.charge
    rows = np.repeat(np.arange(machine.kernel.unknowns), np.diff(charge.start))
    for name in ("v_mem", "membrane.v_r", "inhibition.v_inh", "comparator.tail", "axon.rm"):
        column = machine.column_of(name)
        diagonal = charge.value[(rows == column) & (charge.column == column)]
        assert found[name] == pytest.approx(float(diagonal[0]), rel=1e-12)
