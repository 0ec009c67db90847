"""Calibration of the Pushbot's network: what is programmed and driven, the nominal die, and another."""

import numpy as np
import pytest

from chips.pushbot_biases import LEVELS, STEP, pushbot_biases
from chips.pushbot_calibration import (
    EVENTS,
    MOST,
    RATES,
    calibrate_pushbot,
    calibration_task,
    driven_part,
    dropped,
    events_of,
    without,
)
from chips.pushbot_modified import field_network, modified_network
from chips.pushbot_network import PAPER
from chips.rolls_calibration import neuron_rates
from chips.rolls_chip import RollsChip
from circuits.die import Die
from circuits.errors import ParameterError
from circuits.process import ROLLS_180
from circuits.silicon import Silicon

NETWORK = field_network(PAPER, LEVELS)


def test_nothing_competes_in_what_is_driven() -> None:
    names = {(p.source.name, p.target.name) for p in driven_part(NETWORK).projections}
    assert ("OL", "DR") in names
    assert not {("DL", "DR"), ("DR", "DL"), ("DL", "OL"), ("target", "target")} & names


def test_the_rates_asked_for_are_the_nominal_die_s() -> None:
    task = calibration_task(NETWORK, pushbot_biases())
    chip = RollsChip(task.program, Silicon(ROLLS_180), "generator", step=STEP)
    rates = neuron_rates(chip, task.drive)
    for target in task.targets:
        # alike neurons fire in step, so their rates move in jumps with how the chip's step is cut, by up to
        # 7 % between 0.1 and 0.2 ms; what a calibration claims is 10 %
        assert rates[list(target.population.neurons)].mean() == pytest.approx(target.rate, rel=0.1)


def test_events_come_alike_to_both_sides_and_begin_alike_in_a_longer_run() -> None:
    short, long = events_of(NETWORK, 1.0), events_of(NETWORK, 2.0)
    sides = [np.isin(short.neurons, NETWORK[name].neurons).sum() for name in ("OL", "OR")]
    assert sides[0] == sides[1]
    # 16 neurons, 4 synapses; the count of a Poisson process within four sigma
    assert abs(sides[0] / 64 - 0.95 * EVENTS) < 4.0 * EVENTS**0.5
    assert np.array_equal(long.times[long.times < 1.0], short.times)


def test_a_die_comes_to_its_rates() -> None:
    silicon = Silicon(ROLLS_180, 27.0, Die(number=19))
    found = calibrate_pushbot(NETWORK, pushbot_biases(), silicon)
    for name in ("OL", "OR", "DL", "DR"):
        assert abs(found.before[name] / RATES[name] - 1.0) > 0.2  # die 19 is far off with the table's codes
        assert found.rates[name] == pytest.approx(RATES[name], rel=0.1)
    assert max(len(gone) for gone in found.blacklist.values()) <= MOST
    assert not found.blacklist["exc"]
    left = without(NETWORK, dropped(found))
    assert sum(len(p) for p in left.populations) == sum(len(p) for p in NETWORK.populations) - len(
        dropped(found)
    )


def test_what_is_left_keeps_its_levels() -> None:
    network = modified_network(LEVELS, pushbot_biases())
    gone = {network["OL"].neurons[0], network["GR"].neurons[3]}
    levels, left = network.levels(), without(network, gone)
    levels[list(gone)], levels[:, list(gone)] = 0, 0
    assert np.array_equal(left.levels(), levels)
    assert len(left.slow[0]) == 15


def test_a_population_is_not_left_empty() -> None:
    with pytest.raises(ParameterError, match=r"population\.sp: none of 16 neurons is left"):
        without(NETWORK, NETWORK["sp"].neurons)
