"""The nominal die has its design's times; dies spread by area and drift with temperature and kind of bias."""

import numpy as np
import pytest

from chips.latency.errors import usual_design
from chips.latency.model import lumped, usual_biases
from circuits.errors import ParameterError
from circuits.silicon.die import Die
from circuits.silicon.silicon import Silicon

DESIGN = usual_design()
GATE, IDEAL = (usual_biases(DESIGN, kind) for kind in ("gate", "ideal"))


def test_the_nominal_die_has_the_designs_times() -> None:
    c = lumped(DESIGN, GATE, Silicon())
    assert c.tap[1:] == pytest.approx(np.full(15, DESIGN.hop))
    assert c.hold == pytest.approx(np.full((33, 15), DESIGN.hold))
    assert c.race / c.passive == pytest.approx(np.full(33, DESIGN.race))
    assert c.second_charge / c.second == pytest.approx(np.array(DESIGN.second)[list(DESIGN.group)])
    # the charge of the goal at its own cell, in thresholds; its pulse is longer by an event of 10 us
    charge = np.diag(c.goal) * c.goal_pulse / c.race
    assert charge == pytest.approx(np.full(33, DESIGN.goal), rel=0.006)


def test_spread_follows_area() -> None:
    silicon = Silicon(die=Die(number=5, process=False))
    spread = [lumped(DESIGN, IDEAL, silicon, area).hold.std() for area in (1.0, 16.0)]
    assert spread[0] / spread[1] == pytest.approx(4.0, rel=0.1)  # 495 units: 3 % of statistics
    # A_VT of 28 mV um over sqrt(2 6 24) um is 1.65 mV, times 0.75 / 25.9 mV; 1 % and less from other devices
    assert spread[0] / DESIGN.hold == pytest.approx(0.0478, rel=0.1)


def test_fixed_gates_drift_and_generators_hardly_do() -> None:
    warm = Silicon(temperature_c=40.0)
    assert lumped(DESIGN, IDEAL, warm).hold.mean() == pytest.approx(DESIGN.hold * 300.15 / 313.15, rel=0.01)
    assert lumped(DESIGN, GATE, warm).hold.mean() < 0.7 * DESIGN.hold


def test_a_die_is_the_same_again() -> None:
    a, b = (lumped(DESIGN, GATE, Silicon(die=Die(number=9))) for _ in range(2))
    for x, y in zip(a, b, strict=True):
        assert np.array_equal(x, y)


def test_what_is_outside_is_refused() -> None:
    with pytest.raises(ParameterError, match=r"latency_chip\.temperature: 80 degC, must be -10 to 65"):
        lumped(DESIGN, GATE, Silicon(temperature_c=80.0))
    with pytest.raises(ParameterError, match=r"latency_chip\.area: 0 times"):
        lumped(DESIGN, GATE, Silicon(), 0.0)
