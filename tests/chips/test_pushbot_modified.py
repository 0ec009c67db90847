"""The modified architecture: a full chip, weights graded by current, gyro populations that only suppress."""

import numpy as np
import pytest

from chips.pushbot_biases import LEVELS, pushbot_biases
from chips.pushbot_modified import field_network, modified_network
from chips.pushbot_network import PAPER, PushbotLayout
from chips.rolls_network import network_program
from chips.rolls_program import level_current
from circuits.errors import ParameterError

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
