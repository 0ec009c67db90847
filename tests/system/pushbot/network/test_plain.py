"""The Pushbot's network: sizes of the paper, the neuron map of the notebooks, and every arrow of Figure 4."""

import numpy as np
import pytest

from chips.rolls.program.address import LAB_VIRTUAL, PAPER_VIRTUAL
from chips.rolls.program.network import network_program
from chips.rolls.program.population import Population
from circuits.errors import ParameterError
from system.pushbot.network.plain import NOTEBOOK, PAPER, PushbotLayout, PushbotLevels, pushbot_network

NETWORK = pushbot_network()
LEVELS = NETWORK.levels()


def sign(source: str | Population, target: str | Population) -> set[int]:
    """Signs of the synapses of all pairs; {0} where there are none."""
    ends = [NETWORK[end] if isinstance(end, str) else end for end in (source, target)]
    return set(np.unique(np.sign(LEVELS[np.ix_(ends[1].neurons, ends[0].neurons)])).tolist())


def test_sizes_of_the_paper() -> None:
    small = [p for p in NETWORK.populations if p.name != "target"]
    assert sum(len(p) for p in small) == 96
    assert len(small) == 6
    assert len(NETWORK["target"]) == 128


def test_neuron_map_of_the_notebooks() -> None:
    # facts, section 9: from the authors' notebooks
    found = {p.name: (p.neurons[0], p.neurons[-1]) for p in pushbot_network(NOTEBOOK).populations}
    assert found == {
        "OR": (0, 15), "OL": (16, 31), "DR": (32, 47), "DL": (48, 63),
        "sp": (64, 79), "exc": (80, 87), "target": (88, 215),
    }  # fmt: skip
    levels = pushbot_network(NOTEBOOK).levels()
    drives = {name: np.flatnonzero(levels[n, 88:] > 0) + 88 for name, n in (("DR", 32), ("DL", 48))}
    assert drives["DL"].tolist() == list(range(88, 142))
    assert drives["DR"].tolist() == list(range(162, 216))


def test_every_arrow_and_no_other() -> None:
    excite, inhibit, none = {1}, {-1}, {0}
    arrows = {
        ("OR", "DL"): excite, ("OL", "DR"): excite,
        ("DL", "DR"): inhibit, ("DR", "DL"): inhibit,
        ("DL", "OL"): inhibit, ("DL", "OR"): inhibit, ("DR", "OL"): inhibit, ("DR", "OR"): inhibit,
        ("OL", "sp"): inhibit, ("OR", "sp"): inhibit,
        ("exc", "exc"): excite, ("exc", "sp"): excite,
        ("target", "DL"): {0, 1}, ("target", "DR"): {0, 1}, ("target", "target"): {-1, 1},
    }  # fmt: skip
    names = [p.name for p in NETWORK.populations]
    assert {(a, b): sign(a, b) for a in names for b in names} == {
        (a, b): arrows.get((a, b), none) for a in names for b in names
    }


def test_the_centre_of_the_field_drives_nothing_and_its_sides_their_own() -> None:
    target = NETWORK["target"]
    assert sign(target.part(56, 72), "DL") == sign(target.part(56, 72), "DR") == {0}  # 16 neurons
    assert sign(target.part(0, 56), "DL") == sign(target.part(72, 128), "DR") == {1}
    assert sign(target.part(0, 56), "DR") == sign(target.part(72, 128), "DL") == {0}


def test_each_target_neuron_excites_itself_and_four_neighbours() -> None:
    target = NETWORK["target"].neurons
    field = LEVELS[np.ix_(target, target)]
    assert ((field > 0).sum(axis=0)[2:-2] == 5).all()
    assert (field != 0).all()


def test_obstacles_drive_more_than_targets() -> None:
    levels = PushbotLevels()
    assert levels.obstacle_to_drive > levels.target_to_drive > 0


def test_the_program_fits_both_sets_of_virtual_synapses_and_a_blacklist() -> None:
    for virtual in (LAB_VIRTUAL, PAPER_VIRTUAL):
        assert (network_program(NETWORK, virtual=virtual).levels == LEVELS).all()
    bad = (0, 40, 130, 131)
    program = network_program(pushbot_network(NOTEBOOK, blacklist=bad))
    assert not program.levels[list(bad)].any()
    assert not program.levels[:, list(bad)].any()
    assert {each.name for each in program.inputs} == {"dvs_left", "dvs_right", "dvs_columns", "start"}


def test_layouts_that_do_not_fit_are_refused() -> None:
    with pytest.raises(ParameterError, match=r"population.target: 128 neurons, must be <= 60"):
        pushbot_network(PushbotLayout(population=36))
    with pytest.raises(ParameterError, match=r"pushbot.centre: 15, must be even"):
        PushbotLayout(centre=15)
    assert PAPER.centre == 16
