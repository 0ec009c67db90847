"""Power of activity: additive, and what a spike or an event costs by hand."""

import numpy as np
import pytest

from chips.rolls.chip import RollsChip
from chips.rolls.program.network import network_program
from circuits.silicon.process import ROLLS_180
from circuits.silicon.silicon import Silicon
from system.pushbot.network.biases import LEVELS, pushbot_biases
from system.pushbot.network.plain import pushbot_network
from system.pushbot.network.power import activity_power

NETWORK = pushbot_network(levels=LEVELS)
CHIP = RollsChip(network_program(NETWORK, pushbot_biases()), Silicon(ROLLS_180), "generator")
NONE = np.empty(0, dtype=np.int64)


def test_nothing_costs_nothing_and_parts_add_up() -> None:
    speed = np.array(NETWORK["sp"].neurons)
    assert activity_power(CHIP, NONE, 0, 1.0) == 0.0
    parts = activity_power(CHIP, speed, 0, 2.0) + activity_power(CHIP, NONE, 1000, 2.0)
    assert activity_power(CHIP, speed, 1000, 2.0) == pytest.approx(parts, rel=1e-12)


def test_a_spike_without_synapses_charges_the_neuron_s_capacitors() -> None:
    # sp sends to nobody: 2.6 pF on 1.8 V
    one = activity_power(CHIP, np.array(NETWORK["sp"].neurons[:1]), 0, 1.0)
    assert one == pytest.approx(1.8**2 * 2.6e-12, rel=1e-12)


def test_an_event_costs_its_pulse() -> None:
    length = float(CHIP.built().lengths.mean())
    expected = 1.8 * pushbot_biases().current("VA_EXC_N") * length
    assert activity_power(CHIP, NONE, 1, 1.0) == pytest.approx(expected, rel=1e-12)
