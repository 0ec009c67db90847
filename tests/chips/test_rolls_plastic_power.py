"""Power of the plastic array: an event is its charge, a high weight's comparator, and sums add up."""

from __future__ import annotations

import pytest

from chips.rolls_learning import learning_biases
from chips.rolls_plastic_power import PlasticEnergies, plastic_energies
from circuits.errors import ParameterError
from circuits.process import ROLLS_180
from circuits.silicon import Silicon

PULSE = 22.9e-6  # s, of the nominal extender
TOTAL = 65536


@pytest.fixture(scope="module")
def found() -> PlasticEnergies:
    return plastic_energies(learning_biases(), Silicon(ROLLS_180))


def test_an_event_of_a_high_weight_is_its_charge_through_the_supply(found: PlasticEnergies) -> None:
    least = learning_biases().current("PA_WHIDN_N") * PULSE * ROLLS_180.v_dd
    # gates and inverters of a pulse, which a low weight has too: 0.05 pJ
    assert least < found.high < 1.4 * least
    assert 0.0 < found.low < 0.3 * least


def test_a_high_weight_s_comparator_does_not_reach_ground(found: PlasticEnergies) -> None:
    # 4.1 uA of the inverter behind it; a low weight has leaks alone
    assert found.high_rest == pytest.approx(7.4e-6, rel=0.05)
    assert found.low_rest < 1e-9


def test_power_is_the_sum_of_its_parts(found: PlasticEnergies) -> None:
    still = found.rest + TOTAL * found.low_rest
    assert found.power(0.0) == pytest.approx(still, rel=1e-12)
    more = found.power(50.0, TOTAL) - found.power(50.0)
    expected = TOTAL * (found.high_rest - found.low_rest + 50.0 * (found.high - found.low))
    assert more == pytest.approx(expected, rel=1e-9)
    assert found.spike > found.extender > 0.0
    with pytest.raises(ParameterError, match=r"power.high: 65537, must be 0 to 65536"):
        found.power(1.0, TOTAL + 1)
