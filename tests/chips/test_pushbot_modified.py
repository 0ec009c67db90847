"""The modified architecture: a full chip, weights graded by current, gyro populations that only suppress."""

from dataclasses import replace

import numpy as np
import pytest

from chips.pushbot_biases import LEVELS, MODIFIED, STEP, pushbot_biases
from chips.pushbot_modified import field_network, modified_network
from chips.pushbot_network import PAPER, PushbotLayout
from chips.rolls_address import VIRTUAL_EXCITATORY
from chips.rolls_chip import Inputs, RollsChip
from chips.rolls_network import network_program
from chips.rolls_program import level_current
from circuits.errors import ParameterError
from circuits.process import ROLLS_180
from circuits.silicon import Silicon

BIASES = pushbot_biases()


def test_it_fills_the_chip() -> None:
    network = modified_network(LEVELS, BIASES)
    used = [n for p in network.populations for n in p.neurons]
    assert sorted(used) == list(range(256))
    network_program(network, BIASES)


def test_one_neuron_more_has_no_room() -> None:
    with pytest.raises(ParameterError, match="must be <="):
        modified_network(LEVELS, BIASES, gyro=17)


def test_weights_rise_by_current_from_the_edge_to_the_centre() -> None:
    network = modified_network(LEVELS, BIASES)
    levels = network.levels()
    for source, target in (("OL", "DR"), ("OR", "DL")):
        block = levels[np.ix_(network[target].neurons, network[source].neurons)]
        assert (block == block[0]).all()
        currents = [level_current(BIASES, int(k)) for k in block[0]]
        assert currents == sorted(currents)
        assert len(set(currents)) == 4


def test_gyro_populations_inhibit_both_obstacle_populations_and_nothing_else() -> None:
    network = modified_network(LEVELS, BIASES)
    levels = network.levels()
    obstacles = {*network["OL"].neurons, *network["OR"].neurons}
    for name in ("GL", "GR"):
        out = levels[:, list(network[name].neurons)]
        reached = set(np.flatnonzero((out != 0).any(axis=1)).tolist())
        assert reached == obstacles
        assert (out[sorted(obstacles)] < 0).all()


def test_the_slower_leak_is_for_what_owns_columns() -> None:
    assert {p.name for p in field_network(PAPER, LEVELS).slow} == {"target"}
    assert {p.name for p in modified_network(LEVELS, BIASES).slow} == {"OL", "OR", "target"}
    with pytest.raises(ParameterError, match="must be <="):
        field_network(PushbotLayout(exc=60), LEVELS)


def test_drives_suppress_obstacle_populations_less_than_in_the_plain_network() -> None:
    biases = pushbot_biases(MODIFIED)
    plain, modified = field_network(PAPER, LEVELS).levels(), modified_network(LEVELS, biases)
    at = np.ix_(modified["OL"].neurons, modified["DL"].neurons)
    weak, strong = (level_current(biases, -int(m[at][0, 0])) for m in (modified.levels(), plain))
    assert weak < strong


def spikes_per_event(rate: float, code: tuple[str, int], duration: float = 2.0) -> float:
    """Of a population OL without connections, whose neurons hear 4 synapses at `rate` a second, evenly."""
    biases = pushbot_biases({**MODIFIED, "IF_TAU1_N": code})
    network = modified_network(LEVELS, biases)
    members = np.array(network["OL"].neurons)
    times = np.repeat((np.arange(round(rate * duration)) + 0.5) / rate, 4 * members.size)
    shots = round(rate * duration)
    inputs = Inputs(
        times,
        np.tile(np.repeat(members, 4), shots),
        np.tile(VIRTUAL_EXCITATORY + np.arange(4), times.size // 4),
    )
    alone = network_program(replace(network, projections=()), biases)
    chip = RollsChip(alone, Silicon(ROLLS_180), "generator", step=STEP)
    heard, _ = chip.run(chip.at_rest(), duration, inputs)
    return float(heard.neurons.size / members.size / shots)


def test_an_obstacle_neuron_sums_events() -> None:
    # none of events 100 ms apart, nearly a spike each of those 12.5 ms apart; two each with the field's leak
    assert spikes_per_event(10.0, MODIFIED["IF_TAU1_N"]) == 0.0
    assert 0.0 < spikes_per_event(40.0, MODIFIED["IF_TAU1_N"]) < 0.5
    assert 0.5 < spikes_per_event(80.0, MODIFIED["IF_TAU1_N"]) < 1.5
    assert spikes_per_event(10.0, ("105p", 73)) >= 2.0


def test_a_drive_stops_the_robot() -> None:
    biases = pushbot_biases(MODIFIED)
    plain, network = field_network(PAPER, LEVELS), modified_network(LEVELS, biases)
    for name in ("DL", "DR"):
        at = np.ix_(network["sp"].neurons, network[name].neurons)
        assert not plain.levels()[at].any()
        # more than what an obstacle population does, whose spikes come as seldom
        drive = {level_current(biases, int(k)) for k in network.levels()[at].ravel()}
        slowing = network.levels()[np.ix_(network["sp"].neurons, network["OL"].neurons)]
        assert min(drive) > 2.0 * level_current(biases, int(slowing[0, 0]))
