"""The nominal die has its design's times; dies spread by area and drift with temperature and kind of bias."""

from dataclasses import replace

import numpy as np
import pytest

from chips.latency.design import Line
from chips.latency.errors import usual_design
from chips.latency.model import lumped, usual_biases
from circuits.errors import ParameterError
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500, AMI_1500_IDEAL, Process
from circuits.silicon.silicon import Silicon

DESIGN = usual_design()
GATE, IDEAL = (usual_biases(DESIGN, kind) for kind in ("gate", "ideal"))


@pytest.mark.parametrize("process", [AMI_1500_IDEAL, AMI_1500])
def test_the_nominal_die_has_the_designs_times(process: Process) -> None:
    c = lumped(DESIGN, usual_biases(DESIGN, "gate", process), Silicon(process))
    # under the full law switches leak, 0.13 pA each: 0.32 % of what charges a cell
    off = 1e-6 if process is AMI_1500_IDEAL else 0.004
    assert c.tap[1:] == pytest.approx(np.full(15, DESIGN.hop), rel=off)
    assert c.hold == pytest.approx(np.full((33, 15), DESIGN.hold), rel=off)
    assert c.race / c.passive == pytest.approx(np.full(33, DESIGN.race), rel=off)
    second = np.array(DESIGN.second)[list(DESIGN.group)]
    assert c.second_charge / c.second == pytest.approx(second, rel=off)
    # the charge of the goal at its own cell, in thresholds; its pulse is longer by an event of 10 us
    charge = np.diag(c.goal) * c.goal_pulse / c.race
    assert charge == pytest.approx(np.full(33, DESIGN.goal), rel=0.006)


def test_spread_follows_area() -> None:
    silicon = Silicon(AMI_1500_IDEAL, die=Die(number=5, process=False))
    spread = [lumped(DESIGN, IDEAL, silicon, area).hold.std() for area in (1.0, 16.0)]
    assert spread[0] / spread[1] == pytest.approx(4.0, rel=0.1)  # 495 units: 3 % of statistics
    # A_VT of 28 mV um over sqrt(2 6 24) um is 1.65 mV, times 0.75 / 25.9 mV; 1 % and less from other devices
    assert spread[0] / DESIGN.hold == pytest.approx(0.0478, rel=0.1)


def test_fixed_gates_drift_and_generators_hardly_do() -> None:
    warm = Silicon(AMI_1500_IDEAL, temperature_c=40.0)
    assert lumped(DESIGN, IDEAL, warm).hold.mean() == pytest.approx(DESIGN.hold * 300.15 / 313.15, rel=0.01)
    assert lumped(DESIGN, GATE, warm).hold.mean() < 0.7 * DESIGN.hold


def test_warm_switches_leak_under_the_full_law_alone() -> None:
    warm = {process: Silicon(process, 60.0) for process in (AMI_1500_IDEAL, AMI_1500)}
    ideal, full = (lumped(DESIGN, usual_biases(DESIGN, "ideal", p), s) for p, s in warm.items())
    assert not ideal.leak.any()
    # the off current of an nFET of 6 x 1.5 um: under a picoampere on the nominal die
    assert full.leak == pytest.approx(np.full(33, full.leak[0]))
    assert 0.1e-12 < full.leak[0] < 3e-12
    hold = DESIGN.hold * 300.15 / 333.15
    # what a PTAT current of 57 pA loses of its kind, which makes the silence longer
    assert ideal.hold.mean() == pytest.approx(hold, rel=0.01)
    assert full.hold.mean() / hold == pytest.approx(1.0 + full.leak[0] / 63e-12, abs=0.005)


def test_times_follow_the_capacitors_of_the_die() -> None:
    dies = (Die(number=1003, process=False, variation=extent) for extent in ("transistors", "full"))
    plain, full = (lumped(DESIGN, IDEAL, Silicon(AMI_1500_IDEAL, die=die)) for die in dies)
    silicon = Silicon(AMI_1500_IDEAL, die=Die(number=1003, process=False, variation="full"))
    own = silicon.change("latency_chip", ((("second", (33,)), ("cm", ())),), "capacitor", np.full(33, 10e-12))
    # 10 pF of a charge of 2 V on 10.1 pF
    expected = (
        1.0 + np.asarray(own.value) * 20e-12 / lumped(DESIGN, IDEAL, Silicon(AMI_1500_IDEAL)).second_charge
    )
    assert full.second_charge / plain.second_charge == pytest.approx(expected, rel=1e-5)
    assert np.ptp(expected) > 1e-4
    assert np.array_equal(full.second, plain.second)
    assert (full.hold != plain.hold).all()


def test_a_timer_whose_switch_leaks_all_of_its_current_is_beyond_any_run() -> None:
    low = Silicon(AMI_1500, 65.0)
    biases = usual_biases(DESIGN, "ideal", AMI_1500)
    weak = replace(biases, lines={**biases.lines, "hold": Line("p", np.array(1e-13))})
    found = lumped(DESIGN, weak, low).hold
    assert np.isfinite(found).all()
    assert found.min() > 1e3


def test_a_die_is_the_same_again() -> None:
    a, b = (lumped(DESIGN, GATE, Silicon(AMI_1500_IDEAL, die=Die(number=9))) for _ in range(2))
    for x, y in zip(a, b, strict=True):
        assert np.array_equal(x, y)


def test_what_is_outside_is_refused() -> None:
    with pytest.raises(ParameterError, match=r"latency_chip\.temperature: 80 degC, must be -10 to 65"):
        lumped(DESIGN, GATE, Silicon(AMI_1500_IDEAL, temperature_c=80.0))
    with pytest.raises(ParameterError, match=r"latency_chip\.area: 0 times"):
        lumped(DESIGN, GATE, Silicon(AMI_1500_IDEAL), 0.0)
