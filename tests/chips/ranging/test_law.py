"""The compiled equations: derivatives of the reduced neuron's currents."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from chips.ranging import law
from chips.ranging.law import Neurons
from chips.ranging.model import model_of, neurons_on
from circuits.blocks.sonar import rebound_neuron
from circuits.silicon.process import AMI_1500
from circuits.silicon.silicon import Silicon

DELTA = 1e-6  # V


@pytest.fixture(scope="module")
def neuron() -> Neurons:
    return neurons_on(model_of(rebound_neuron.build(), AMI_1500), Silicon())


@pytest.fixture(scope="module")
def numbers(neuron: Neurons) -> law.Numbers:
    found = law.numbers_of(neuron, 0)
    law.currents(found, 1.0, 1.0, 1.0)  # compiles before hypothesis watches the time
    return found


volts = st.floats(0.5, 4.5)


@given(v=volts, r=volts, x=volts)
def test_derivatives_are_those_of_the_currents(numbers: law.Numbers, v: float, r: float, x: float) -> None:
    found = law.currents(numbers, v, r, x)
    slopes = {(0, 0): 3, (0, 1): 4, (0, 2): 5, (1, 0): 6, (1, 1): 7, (2, 2): 8}
    for (row, column), place in slopes.items():
        low, high = [v, r, x], [v, r, x]
        low[column] -= DELTA
        high[column] += DELTA
        up, down = law.currents(numbers, *high), law.currents(numbers, *low)
        expected = (up[row] - down[row]) / (2.0 * DELTA)
        # rounding of the currents over the difference, curvature below 1e-9 of it
        rounding = 1e-15 * abs(up[row]) / DELTA
        assert found[place] == pytest.approx(expected, rel=1e-5, abs=1e-18 + 10.0 * rounding)
