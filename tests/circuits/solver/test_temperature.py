"""Transient runs at transistor level while the temperature moves."""

import numpy as np
import pytest

from circuits.bias import rebias
from circuits.blocks.rolls.neuron import BLOCK, build
from circuits.circuit import Circuit, Port
from circuits.devices import Capacitor, Source, Transistor
from circuits.devices.source import Constant
from circuits.silicon.course import Course
from circuits.silicon.process import AMI_1500_IDEAL, ROLLS_180_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.temperature import simulate_course
from circuits.solver.transient import simulate
from circuits.testbench import Testbench

SINK = Testbench(
    "sink",
    Circuit(
        "sink",
        (Port("vdd", "supply"), Port("a", "analog"), Port("y", "analog", "out")),
        (Capacitor("c", "vdd", "y", 1e-12, ic=0.0), Transistor("m", "n", "y", "a", "0", "0", 6e-6, 6e-6)),
    ),
    (Source("vdd", "vdd", Constant(AMI_1500_IDEAL.v_dd)), Source("a", "a", Constant(0.38))),
    2e-3,
    begin="uic",
)


def test_a_capacitor_keeps_its_charge_and_loses_it_at_the_new_temperature_s_rate() -> None:
    course = Course(((0.0, 27.0), (1e-3, 27.0), (1.001e-3, 47.0)))
    moving = simulate_course(SINK, Silicon(AMI_1500_IDEAL), course)
    at = {t: simulate(SINK, Silicon(AMI_1500_IDEAL, temperature_c=t)) for t in (27.0, 47.0)}
    y = np.interp([0.999e-3, 1.01e-3, 1.2e-3], moving.time, moving["y"])
    cold = np.interp([0.999e-3], at[27.0].time, at[27.0]["y"])
    assert y[0] == pytest.approx(cold[0], abs=1e-4)
    # from the same voltage on the way that it would have gone at 47 degC
    warm = at[47.0]
    begin = np.interp(-y[1], -warm["y"], warm.time)
    assert y[2] == pytest.approx(np.interp(begin + 0.19e-3, warm.time, warm["y"]), abs=1e-3)
    assert y[0] - y[2] > 1.5 * (y[0] - np.interp(1.2e-3, at[27.0].time, at[27.0]["y"]))


def test_a_course_that_stays_changes_nothing_and_biases_follow_one_that_moves() -> None:
    circuit = rebias(build(), kind="ideal")
    bench = BLOCK.testbench(
        circuit, BLOCK.defaults | {"current": 1e-9, "duration": 0.04}, ROLLS_180_IDEAL.v_dd
    )
    silicon = Silicon(ROLLS_180_IDEAL)
    still = simulate(bench, silicon, record=())
    flat = simulate_course(bench, silicon, Course(((0.0, 27.0),)), record=())
    assert np.array_equal(still.spikes["spike"], flat.spikes["spike"])
    warmed = simulate_course(bench, silicon, Course(((0.0, 27.0), (0.02, 27.0), (0.020001, 47.0))), record=())
    warm = simulate(bench, Silicon(ROLLS_180_IDEAL, 47.0), record=())
    last = np.diff(warmed.spikes["spike"])[-1]
    assert last == pytest.approx(np.diff(warm.spikes["spike"])[-1], rel=1e-3)
