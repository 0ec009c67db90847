"""The compiled model: rest, trajectory and firing of the reduced neuron."""

from __future__ import annotations

import math

import numpy as np
import pytest

from chips.ranging import neuron_kernel as core
from chips.ranging.law import Neurons
from chips.ranging.model import model_of, neurons_on, stimulated
from chips.ranging.neuron_kernel import COLUMNS, NOW, PEAK, V_EX, V_MEM, V_R
from circuits.blocks.sonar import rebound_neuron
from circuits.devices import Source
from circuits.devices.source import Pulse
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.operating_point import operating_point
from circuits.solver.transient import Runner


@pytest.fixture(scope="module")
def neuron() -> Neurons:
    return neurons_on(model_of(rebound_neuron.build(), AMI_1500_IDEAL), Silicon(AMI_1500_IDEAL))


def test_the_rest_state_is_the_operating_point(neuron: Neurons) -> None:
    state = np.zeros(COLUMNS)
    core.begin(neuron, 0, state, 0.0)
    point = operating_point(stimulated(rebound_neuron.build(), Silicon(AMI_1500_IDEAL)))
    nodes = ("v_mem", "membrane.v_r", "excitation.v_ex")
    for column, node in zip((V_MEM, V_R, V_EX), nodes, strict=True):
        assert state[column] == pytest.approx(point[node], abs=1e-6)


def test_a_spike_leaves_v_r_and_v_ex_as_they_are_then(neuron: Neurons) -> None:
    state = np.zeros(COLUMNS)
    core.begin(neuron, 0, state, 0.0)
    core.call(neuron, 0, state)
    core.advance(neuron, 0, state, float(neuron.t_inh[0]))
    core.echo(neuron, 0, state, float(neuron.v_ex_max[0]))
    before = state.copy()
    spike = core.advance(neuron, 0, state, state[NOW] + 5e-3)
    assert spike < math.inf
    assert core.advance(neuron, 0, before, spike - 1e-9) == math.inf
    fall = float(neuron.v_held[0]) - before[V_MEM]
    for column in (V_R, V_EX):  # which follow v_mem when it is pulled low
        then = before[column] + neuron.follow[0, column, V_MEM] * fall
        assert state[column] == pytest.approx(then, abs=core.TOLERANCE)


@pytest.mark.parametrize("x", [1e-8, 0.37, 1.0, 2.5, 8.0, 1e4, 1e8])
def test_cube_roots(x: float) -> None:
    assert core._cube_root(x) == pytest.approx(x ** (1.0 / 3.0), rel=1e-6)


def test_the_rebound_is_the_circuit_s(neuron: Neurons) -> None:
    call = Source("call", "call", Pulse(0.0, 5.0, (0.0,), 10e-6, 0.1e-6, 0.1e-6))
    machine = stimulated(rebound_neuron.build(), Silicon(AMI_1500_IDEAL), (call,))
    runner = Runner(machine, ("v_mem", "membrane.v_r"), 1e-5)
    state = np.zeros(COLUMNS)
    core.begin(neuron, 0, state, 0.0)
    core.call(neuron, 0, state)
    solver = runner.begin(operating_point(machine))
    release = float(neuron.t_inh[0])
    for time in release + np.array([0.1e-3, 0.5e-3, 1.0e-3, 1.5e-3]):
        assert core.advance(neuron, 0, state, float(time)) == math.inf
        solver, segment = runner.advance(solver, float(time))
        # an error of 0.1 us of the release is 0.1 mV; the model's own error is below 1 mV
        assert state[[V_MEM, V_R]] == pytest.approx(segment.voltage[-1], abs=1e-3)
    assert state[NOW] == pytest.approx(release + 1.5e-3)


def test_it_fires_when_the_charge_is_enough(neuron: Neurons) -> None:
    def peak_and_spike(threshold: float) -> tuple[float, float]:
        state = np.zeros(COLUMNS)
        changed = neuron._replace(v_threshold=np.array([threshold]))
        core.begin(changed, 0, state, 0.0)
        core.call(changed, 0, state)
        return core.advance(changed, 0, state, 20e-3), float(state[PEAK])

    never, peak = peak_and_spike(9.0)
    assert never == math.inf
    assert peak_and_spike(peak + 1e-3)[0] == math.inf
    assert peak_and_spike(peak - 10e-3)[0] < 20e-3
    assert peak_and_spike(peak - 20e-3)[0] < peak_and_spike(peak - 10e-3)[0]


def test_a_threshold_at_the_peak_is_undecided(neuron: Neurons) -> None:
    wide = neuron._replace(margin=np.array([0.2]))
    state = np.zeros(COLUMNS)
    core.begin(wide, 0, state, 0.0)
    core.call(wide, 0, state)
    core.advance(wide, 0, state, 20e-3)
    assert state[core.UNDECIDED] + state[core.NEAR] == 1.0


def test_how_far_it_is_advanced_at_a_time_hardly_matters(neuron: Neurons) -> None:
    strong = neuron._replace(v_threshold=np.array([2.2]))

    def spike(step: float) -> float:
        state = np.zeros(COLUMNS)
        core.begin(strong, 0, state, 0.0)
        core.call(strong, 0, state)
        while True:
            found = core.advance(strong, 0, state, state[NOW] + step)
            if found < math.inf:
                return found

    # the tolerance of a step, 0.1 mV at 760 V/s, some tens of times
    assert spike(0.1e-3) == pytest.approx(spike(20e-3), abs=3e-6)
