"""The compiled equations: derivatives of the reduced neuron's currents."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from chips.ranging import law
from chips.ranging.law import Neurons
from chips.ranging.model import model_of, neurons_on
from circuits.blocks.sonar import rebound_neuron
from circuits.lowering.on_die import standing
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500, AMI_1500_IDEAL, Process
from circuits.silicon.silicon import Silicon

DELTA = 1e-6  # V


@pytest.fixture(scope="module", params=[AMI_1500_IDEAL, AMI_1500], ids=lambda p: p.effects)
def neuron(request: pytest.FixtureRequest) -> Neurons:
    return neurons_on(model_of(rebound_neuron.build(), request.param), Silicon(request.param))


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


def _from_devices(silicon: Silicon, v: float, r: float, x: float) -> tuple[float, float, float]:
    """Currents into v_mem, v_r and v_ex from each of their transistors by itself."""
    circuit = rebound_neuron.build()
    d = standing(circuit, silicon)
    v_dd, gate = silicon.process.v_dd, d.gate
    rest = float(gate["v_rest"])

    def from_supply(device: str, port: str, node: float) -> float:
        return float(d.current(device, v_dd - gate[port], v_dd - node)[0])

    mem = from_supply("membrane.mr1", "v_rslope", v) - float(d.current("membrane.m1", r, v, rest)[0])
    mem += float(d.current("excitation.me5", v_dd - x, v_dd - v)[0])
    mem -= sum(float(d.current(reset, 0.0, v)[0]) for reset in ("inhibition.mi12", "axon.ma8"))
    # what flows from v_r through m2 to ground, in at its source
    slow = from_supply("membrane.mr2", "v_rtau", r)
    slow += float(d.current("membrane.m2", v_dd - v, v_dd - r, v_dd)[0])
    return mem, slow, from_supply("excitation.me4", "v_ex_tau", x)


@pytest.mark.parametrize("process", [AMI_1500_IDEAL, AMI_1500], ids=lambda p: p.effects)
@pytest.mark.parametrize("celsius", [-10.0, 60.0])
def test_currents_are_those_of_the_devices(process: Process, celsius: float) -> None:
    silicon = Silicon(process, celsius, Die(number=1003))
    neuron = neurons_on(model_of(rebound_neuron.build(), process), silicon)
    numbers = law.numbers_of(neuron, 0)
    for v, r, x in ((1.0, 3.0, 4.5), (1.8, 2.9, 4.98), (2.4, 3.5, 4.4), (0.3, 2.2, 4.9), (2.4, 2.9, 4.7)):
        found = law.currents(numbers, v, r, x)[:3]
        # drains are taken to be far, and what leaks is told at one voltage: below a thousandth of 500 pA
        assert found == pytest.approx(_from_devices(silicon, v, r, x), rel=2e-3, abs=0.5e-12)
