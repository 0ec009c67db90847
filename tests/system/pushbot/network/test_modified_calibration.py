"""Calibration of the modified network: what is driven, the nominal die, and another."""

import numpy as np
import pytest

from chips.rolls.calibration import neuron_rates
from chips.rolls.chip import RollsChip
from circuits.silicon.die import Die
from circuits.silicon.process import ROLLS_180_IDEAL
from circuits.silicon.silicon import Silicon
from system.pushbot.network.biases import (
    INHIBITION,
    LEVELS,
    STEP,
    modified_biases,
    modified_table,
    pushbot_biases,
)
from system.pushbot.network.calibration import MOST
from system.pushbot.network.modified import modified_network
from system.pushbot.network.modified_calibration import RATES, calibrate_modified, events_of, modified_task

BIASES = modified_biases(pushbot_biases())
NETWORK = modified_network(LEVELS, BIASES)


def test_every_obstacle_neuron_has_events_of_its_own() -> None:
    found = events_of(NETWORK, 1.0)
    first, second = (found.times[found.neurons == k] for k in NETWORK["OL"].neurons[:2])
    assert first.size > 0
    assert not set(first) & set(second)
    assert (np.diff(found.times) >= 0.0).all()


def test_the_rates_asked_for_are_the_nominal_die_s() -> None:
    task = modified_task(NETWORK, BIASES)
    chip = RollsChip(task.program, Silicon(ROLLS_180_IDEAL), "ideal", step=STEP)
    rates = neuron_rates(chip, task.drive)
    for target in task.targets:
        # both sides have one target, their events differ; what a calibration claims is 10 %
        assert rates[list(target.population.neurons)].mean() == pytest.approx(target.rate, rel=0.1)


def test_a_die_comes_to_its_rates() -> None:
    silicon = Silicon(ROLLS_180_IDEAL, 27.0, Die(number=5))
    # from the table itself, farther off than what the plain network's calibration leaves
    found = calibrate_modified(NETWORK, pushbot_biases(), silicon)
    # drives begin at 272 Hz: near what their refractory period lets through EXC0 moves them little
    for name, off in {"OL": 0.3, "OR": 0.3, "DL": 0.15, "DR": 0.15}.items():
        assert abs(found.before[name] / RATES[name] - 1.0) > off
        assert found.rates[name] == pytest.approx(RATES[name], rel=0.1)
    assert max(len(gone) for gone in found.blacklist.values()) <= MOST
    for name in ("NPA_WEIGHT_EXC_P", "IF_RFR2_N", "IF_TAU1_N", "NPA_WEIGHT_INH_N", "NPA_WEIGHT_INH1_N"):
        assert found.biases.code(name) == BIASES.code(name)


def test_inhibition_of_a_die_is_the_nominal_one_under_the_full_law() -> None:
    plain = pushbot_biases(dict.fromkeys(INHIBITION, ("6.5n", 89)), "full")
    nominal, found = modified_table("full"), modified_biases(plain, "full")
    for name in INHIBITION:
        assert found.code(name) == nominal.code(name)
        assert modified_biases(plain).code(name) != nominal.code(name)
