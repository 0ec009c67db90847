"""Power of ROLLS: energies are charges times the supply, and sums add up."""

import numpy as np
import pytest

from chips.rolls.power import Energies, bias_power, energies
from chips.rolls.program.bias_file import default_biases
from chips.rolls.program.program import level_current
from circuits.errors import ParameterError
from circuits.silicon.process import ROLLS_180
from circuits.silicon.silicon import Silicon

THRESHOLD = 1.22e-10  # A, of the nominal neuron
PULSE = 22.9e-6  # s, of the nominal extender


@pytest.fixture(scope="module")
def found() -> Energies:
    return energies(default_biases(), Silicon(ROLLS_180), THRESHOLD)


@pytest.mark.parametrize(("level", "branches"), [(4, 2), (3, 2), (-1, 1), (-4, 1)])
def test_an_event_costs_its_charge_through_the_supply(found: Energies, level: int, branches: int) -> None:
    # excitation flows twice, through the pFETs and their mirror; the rest is gates and inverters that cross
    charge = level_current(default_biases(), level) * PULSE
    least = branches * charge * ROLLS_180.v_dd
    assert least < found.event[level] < 1.6 * least


def test_a_spike_costs_more_than_its_capacitors_and_less_at_higher_rates(found: Energies) -> None:
    capacitors = (2.1e-12 + 0.5e-12) * ROLLS_180.v_dd**2
    assert (found.spike > capacitors).all()
    assert (np.diff(found.rates) > 0.0).all()
    assert (np.diff(found.spike) < 0.0).all()
    assert found.spike_at(1e-3) == found.spike[0]


def test_power_is_the_sum_of_its_parts(found: Energies) -> None:
    still = found.biases + found.rest
    assert found.power(0.0, {}) == pytest.approx(still, rel=1e-12)
    one, many = (found.power(100.0, {1: n}) for n in (1, 65536))
    assert many - one == pytest.approx(65535 * 100.0 * found.event[1], rel=1e-9)
    assert found.column > 256 * 1e-15


def test_biases_are_codes_times_the_supply_and_follow_the_absolute_temperature() -> None:
    table = default_biases()
    total = sum(table.current(name) for name in table.codes() if not table.is_off(name))
    at, hot = (bias_power(table, Silicon(ROLLS_180, t)) for t in (27.0, 57.0))
    assert at == pytest.approx(1.8 * total, rel=1e-12)
    assert hot / at == pytest.approx(330.15 / 300.15, rel=1e-12)


def test_a_current_that_makes_no_spike_is_refused() -> None:
    with pytest.raises(ParameterError, match=r"power\.rheobase: 1e-13 A"):
        energies(default_biases(), Silicon(ROLLS_180), 1e-13)
