"""The modified architecture: a full chip, weights graded by current, turns that outlast what began them."""

from dataclasses import replace

import numpy as np
import pytest

from chips.rolls.chip import Inputs, RollsChip
from chips.rolls.program.address import VIRTUAL_EXCITATORY
from chips.rolls.program.network import network_program
from chips.rolls.program.program import level_current
from circuits.errors import ParameterError
from circuits.silicon.process import ROLLS_180_IDEAL
from circuits.silicon.silicon import Silicon
from system.pushbot.network.biases import LEVELS, MODIFIED, STEP, pushbot_biases
from system.pushbot.network.modified import field_network, modified_network
from system.pushbot.network.plain import PAPER, PushbotLayout
from system.pushbot.wiring import kick, merged

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


def test_gyro_populations_inhibit_both_obstacle_populations_and_the_speed_and_nothing_else() -> None:
    network = modified_network(LEVELS, BIASES)
    levels = network.levels()
    held = {n for name in ("OL", "OR", "sp") for n in network[name].neurons}
    for name in ("GL", "GR"):
        out = levels[:, list(network[name].neurons)]
        reached = set(np.flatnonzero((out != 0).any(axis=1)).tolist())
        assert reached == held
        assert (out[sorted(held)] < 0).all()


def test_the_slower_leak_is_for_what_owns_columns() -> None:
    assert {p.name for p in field_network(PAPER, LEVELS).slow} == {"target"}
    assert {p.name for p in modified_network(LEVELS, BIASES).slow} == {"OL", "OR", "target"}
    with pytest.raises(ParameterError, match="must be <="):
        field_network(PushbotLayout(exc=60), LEVELS)


def test_drives_hold_back_the_speed_and_leave_obstacle_populations_to_the_gyro() -> None:
    plain, modified = field_network(PAPER, LEVELS), modified_network(LEVELS, pushbot_biases(MODIFIED))
    for drive in ("DL", "DR"):
        for held, in_plain, in_modified in (("OL", True, False), ("OR", True, False), ("sp", False, True)):
            at = np.ix_(modified[held].neurons, modified[drive].neurons)
            assert (plain.levels()[at] < 0).all() == in_plain
            assert (modified.levels()[at] < 0).all() == in_modified


def events(neurons: tuple[int, ...], rate: float, begin: float, end: float) -> Inputs:
    """Even ones from `begin` to `end` s to all of the neurons, by 4 synapses each."""
    shots = round(rate * (end - begin))
    times = begin + (np.arange(shots) + 0.5) / rate
    wide = 4 * len(neurons)
    return Inputs(
        np.repeat(times, wide), np.tile(np.repeat(np.array(neurons), 4), shots),
        np.tile(VIRTUAL_EXCITATORY + np.arange(4), shots * len(neurons)),
    )  # fmt: skip


def test_a_turn_outlasts_what_began_it_and_the_robot_stands_meanwhile() -> None:
    biases = pushbot_biases(MODIFIED)
    network = modified_network(LEVELS, biases)
    chip = RollsChip(network_program(network, biases), Silicon(ROLLS_180_IDEAL), "ideal", step=STEP)
    seen = network["OL"].neurons[-4:]  # a block left of the centre, from 0.3 s on
    inputs = merged([
        kick(network, 4), events(seen, 400.0, 0.3, 0.8),
        events(network["OR"].neurons[-4:], 400.0, 0.45, 0.8),  # its own turn makes as many on the other side
        events(network["GR"].neurons, 250.0, 0.4, 0.8),  # a turn at 0.5 rad/s from 0.4 to 0.8 s
    ])  # fmt: skip
    spikes, _ = chip.run(chip.at_rest(), 1.2, inputs)

    def rate(name: str, begin: float, end: float) -> float:
        chosen = np.isin(spikes.neurons, network[name].neurons)
        inside = (spikes.times >= begin) & (spikes.times < end)
        return float((chosen & inside).sum() / len(network[name]) / (end - begin))

    # free way, seen, turning and blind, over
    assert rate("sp", 0.2, 0.3) > 250.0
    assert rate("OL", 0.3, 0.4) > 30.0
    assert rate("DR", 0.32, 0.4) > 100.0
    assert rate("DL", 0.3, 1.2) == 0.0
    assert rate("OL", 0.55, 0.6) < 10.0
    assert rate("DR", 0.55, 0.6) > 100.0
    assert rate("OL", 0.6, 1.2) == 0.0
    assert rate("DR", 0.7, 0.8) == 0.0
    assert rate("sp", 0.45, 0.75) == 0.0
    assert rate("sp", 1.1, 1.2) > 250.0


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
    chip = RollsChip(alone, Silicon(ROLLS_180_IDEAL), "ideal", step=STEP)
    heard, _ = chip.run(chip.at_rest(), duration, inputs)
    return float(heard.neurons.size / members.size / shots)


def test_an_obstacle_neuron_sums_events() -> None:
    # none of events 100 ms apart, nearly a spike each of those 12.5 ms apart; two each with the field's leak
    assert spikes_per_event(10.0, MODIFIED["IF_TAU1_N"]) == 0.0
    assert 0.0 < spikes_per_event(40.0, MODIFIED["IF_TAU1_N"]) < 0.5
    assert 0.5 < spikes_per_event(80.0, MODIFIED["IF_TAU1_N"]) < 1.5
    assert spikes_per_event(10.0, ("105p", 73)) >= 2.0
