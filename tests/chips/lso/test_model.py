"""The head's numbers on a die: what they are nominally, what moves them, what is refused."""

import math

import numpy as np
import pytest

from chips.lso.measure import LEVELS
from chips.lso.model import SIDES, head_on, level_times, side_spikes
from circuits.errors import ParameterError
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500_IDEAL, kelvin
from circuits.silicon.silicon import Silicon

NOMINAL = head_on(Silicon(AMI_1500_IDEAL), "gate")


def echo(left: int, right: int, at: float = 1e-3) -> np.ndarray:
    level = np.full((SIDES, LEVELS), math.inf)
    level[0, :left], level[1, :right] = at, at
    return level


def test_the_nominal_head_has_the_biases_currents() -> None:
    assert pytest.approx(np.full((SIDES, LEVELS), 6e-9)) == NOMINAL.excite
    assert pytest.approx(NOMINAL.excite) == NOMINAL.inhibit
    assert NOMINAL.excite_step == pytest.approx(np.full((SIDES, LEVELS), 4e-3), rel=0.02)  # parasitics
    assert NOMINAL.charge == pytest.approx([10e-12, 10e-12], rel=0.05)
    assert float(NOMINAL.rest.max()) < 80e-3  # the head's lowest threshold: all hear


def test_the_louder_side_spikes_by_the_difference() -> None:
    counts = [side_spikes(NOMINAL, 0, echo(5 + d, 5)).size for d in range(4)]
    # 2.4 an input, less 4 % of parasitics and 24 us of dead time each
    assert counts == [0, 2, 4, 6]
    assert side_spikes(NOMINAL, 1, echo(5, 7)).size == counts[2]
    assert side_spikes(NOMINAL, 0, echo(5, 7)).size == 0
    assert side_spikes(NOMINAL, 0, echo(5, 5), inhibited=False).size > 10


def test_a_generator_makes_steps_that_follow_the_temperature_and_gates_more() -> None:
    cold = Silicon(AMI_1500_IDEAL, temperature_c=0.0)
    generator, gate = head_on(cold, "ideal"), head_on(cold, "gate")
    warm = kelvin(27.0) / kelvin(0.0)
    # the charge moves by 0.1 %
    assert generator.excite_step[0, 0] == pytest.approx(NOMINAL.excite_step[0, 0] * warm, rel=5e-3)
    assert gate.excite_step[0, 0] > 2.0 * NOMINAL.excite_step[0, 0]
    # counts are ratios of currents
    for head in (generator, gate):
        assert side_spikes(head, 0, echo(6, 4)).size == pytest.approx(4, abs=1)


def test_a_die_is_the_same_again_and_area_takes_its_mismatch_away() -> None:
    silicon = Silicon(AMI_1500_IDEAL, die=Die(number=3, process=False))
    one, again = head_on(silicon, "gate"), head_on(silicon, "gate")
    assert np.array_equal(one.excite, again.excite)
    small, large = (float(head_on(silicon, "gate", a).offset.std()) for a in (0.25, 4.0))
    assert small == pytest.approx(4.0 * large, rel=0.05)  # ln(1 + beta) bends it
    assert not np.array_equal(one.excite, one.inhibit)


def test_level_units_spike_after_their_thresholds_are_passed() -> None:
    crossed = echo(2, 0)
    found = level_times(NOMINAL, crossed, np.full(crossed.shape, 1e3))
    assert np.array_equal(np.isfinite(found), np.isfinite(crossed))
    assert 20e-6 < float(found[0, 0] - 1e-3) < 60e-6


@pytest.mark.parametrize("area", [0.0, -1.0, 0.05, math.nan, math.inf])
def test_an_area_outside_the_record_is_refused(area: float) -> None:
    with pytest.raises(
        ParameterError, match=r"sonar_head\.area: .* must be (> 0 and finite|at least 0.0625 times)"
    ):
        head_on(Silicon(AMI_1500_IDEAL), area=area)


def test_silicon_outside_the_record_is_refused() -> None:
    with pytest.raises(ParameterError, match=r"sonar_head\.temperature: 80 degC, must be -10 to 65"):
        head_on(Silicon(AMI_1500_IDEAL, temperature_c=80.0))
