"""Codes of the Pushbot's nominal die under the full law: its rates, and the search that found them."""

import pytest

from chips.rolls.calibration import population_rates
from chips.rolls.program.bias_file import COARSE_NAMES, BiasTable
from circuits.silicon.process import ROLLS_180, ROLLS_180_IDEAL
from circuits.silicon.silicon import Silicon
from system.pushbot.network import modified_calibration
from system.pushbot.network.biases import (
    FULL_LAW,
    FULL_LAW_MODIFIED,
    LEVELS,
    STEP,
    modified_biases,
    modified_table,
    pushbot_biases,
)
from system.pushbot.network.calibration import RATES, calibration_task
from system.pushbot.network.law_calibration import DIRECT_RATE, calibrate_law, neuron_task
from system.pushbot.network.modified import field_network, modified_network
from system.pushbot.network.modified_calibration import calibrate_modified, modified_task
from system.pushbot.network.plain import PAPER

FULL = Silicon(ROLLS_180)
NETWORK = field_network(PAPER, LEVELS)
GRADED = modified_network(LEVELS, modified_biases(pushbot_biases()))


def named(table: BiasTable, other: BiasTable) -> dict[str, tuple[str, int]]:
    """What a table has other codes for than another."""
    codes, others = table.codes(), other.codes()
    return {n: (COARSE_NAMES[c], f) for n, (c, f) in codes.items() if (c, f) != others[n]}


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


def test_its_codes_are_found_again() -> None:
    table = pushbot_biases()
    found = calibrate_law(NETWORK, table, FULL)
    assert named(found, table) == FULL_LAW
    again = calibrate_modified(GRADED, pushbot_biases(law="full"), FULL, "generator")
    assert named(again.biases, modified_biases(pushbot_biases(law="full"))) == FULL_LAW_MODIFIED
