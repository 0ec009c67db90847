"""Power of the plastic array: an event is its charge, rest the comparator's current, and sums add up."""

from __future__ import annotations

import pytest

from chips.rolls.plastic.power import PlasticEnergies, plastic_energies
from chips.rolls.setups.learning import learning_biases
from circuits.errors import ParameterError
from circuits.silicon.process import ROLLS_180_IDEAL
from circuits.silicon.silicon import Silicon

PULSE = 22.9e-6  # s, of the nominal extender
TOTAL = 65536


@pytest.fixture(scope="module")
def found() -> PlasticEnergies:
    return plastic_energies(learning_biases(), Silicon(ROLLS_180_IDEAL))


def test_an_event_of_a_high_weight_is_its_charge_through_the_supply(found: PlasticEnergies) -> None:
    least = learning_biases().current("PA_WHIDN_N") * PULSE * ROLLS_180_IDEAL.v_dd
    # gates and inverters of a pulse, which a low weight has too: 0.05 pJ
    assert least < found.high < 1.4 * least
    assert 0.0 < found.low < 0.3 * least


def test_a_weight_at_rest_takes_its_comparators_current(found: PlasticEnergies) -> None:
    held = learning_biases().current("PA_WDRIFT_P") * ROLLS_180_IDEAL.v_dd
    # one branch of the comparator, and leaks of a few picoamperes
    for rest in (found.low_rest, found.high_rest):
        assert held < rest < 1.5 * held


def test_power_is_the_sum_of_its_parts(found: PlasticEnergies) -> None:
    still = found.rest + TOTAL * found.low_rest
    assert found.power(0.0) == pytest.approx(still, rel=1e-12)
    more = found.power(50.0, TOTAL) - found.power(50.0)
    expected = TOTAL * (found.high_rest - found.low_rest + 50.0 * (found.high - found.low))
    assert more == pytest.approx(expected, rel=1e-9)
    assert found.spike.min() > found.extender > 0.0
    with pytest.raises(ParameterError, match=r"power.high: 65537, must be 0 to 65536"):
        found.power(1.0, TOTAL + 1)
