"""Answers of the solvers' version: where one moves, `circuits.solver.version` rises and records are stale."""

import pytest

from circuits.devices.source import Pulse
from circuits.lowering.kernel import to_kernel
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.operating_point import operating_point
from circuits.solver.transient import simulate
from circuits.solver.version import VERSION
from tests.circuits.solver.examples import TAU, low_pass, neuron

# by version: the neuron's spike, s; its comparator's tail at rest, V; and when a low pass crosses half, tau
ANSWERS = {1: (8.10838313e-3, 3.35648933, 1.69360594)}
STEPS = 1e-5  # relative: another machine's arithmetic may choose other steps


def test_the_answers_are_those_of_the_version() -> None:
    machine = to_kernel(neuron(), Silicon(AMI_1500_IDEAL))
    spike = simulate(machine).spikes["spike"]
    rest = operating_point(machine).voltages()
    edge = low_pass(Pulse(0.0, 5.0, (1e-6,), 10e-6, 1e-9, 1e-9), 20e-6, watch=True)
    (crossing,) = simulate(to_kernel(edge)).spikes["y"]
    assert (spike[0], rest["comparator.tail"], crossing / TAU) == pytest.approx(ANSWERS[VERSION], rel=STEPS)
