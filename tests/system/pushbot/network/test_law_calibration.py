"""Rates of the Pushbot's die under the full law; `benchmarks/pushbot_codes.py` finds its codes again."""

import pytest

from chips.rolls.calibration import population_rates
from circuits.silicon.process import ROLLS_180, ROLLS_180_IDEAL
from circuits.silicon.silicon import Silicon
from system.pushbot.network import modified_calibration
from system.pushbot.network.biases import (
    LEVELS,
    STEP,
    modified_biases,
    modified_table,
    pushbot_biases,
)
from system.pushbot.network.calibration import RATES, calibration_task
from system.pushbot.network.law_calibration import DIRECT_RATE, neuron_task
from system.pushbot.network.modified import field_network, modified_network
from system.pushbot.network.modified_calibration import modified_task
from system.pushbot.network.plain import PAPER

FULL = Silicon(ROLLS_180)
NETWORK = field_network(PAPER, LEVELS)
GRADED = modified_network(LEVELS, modified_biases(pushbot_biases()))


def test_the_nominal_die_does_under_the_full_law_what_it_does_under_the_ideal_one() -> None:
    table = pushbot_biases(law="full")
    rates = population_rates(calibration_task(NETWORK, table), FULL, "generator", STEP)
    for name, rate in rates.items():
        assert rate == pytest.approx(RATES[name.partition("[")[0]], rel=0.1)  # what a calibration claims
    own = modified_table("full")
    rates = population_rates(modified_task(GRADED, own), FULL, "generator", STEP)
    for name, rate in rates.items():
        assert rate == pytest.approx(modified_calibration.RATES[name], rel=0.1)


def test_the_table_of_the_ideal_law_is_of_no_use_there() -> None:
    rates = population_rates(calibration_task(NETWORK, pushbot_biases()), FULL, "generator", STEP)
    assert rates["OL"] < 0.2 * RATES["OL"]
    assert rates["sp"] == 0.0


def test_the_rate_under_a_direct_current_is_the_ideal_law_s() -> None:
    task = neuron_task(NETWORK, pushbot_biases())
    rates = population_rates(task, Silicon(ROLLS_180_IDEAL), "ideal", STEP)
    assert rates["fast"] == pytest.approx(DIRECT_RATE, rel=0.01)
