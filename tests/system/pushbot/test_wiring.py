"""Which neurons an event reaches: halves, columns, and the order of time."""

import numpy as np
import pytest

from system.pushbot.network.plain import pushbot_network
from system.pushbot.wiring import Wiring, kick, obstacle_inputs, target_inputs
from system.worlds.camera.event import Events

NETWORK = pushbot_network()


def event(x: int, y: int) -> Events:
    return Events(np.array([0.5]), np.array([x]), np.array([y]), np.array([True]))


@pytest.mark.parametrize(("x", "name"), [(23, "OL"), (63, "OL"), (64, "OR"), (104, "OR")])
def test_plain_an_event_reaches_all_neurons_of_its_half(x: int, name: str) -> None:
    found = obstacle_inputs(NETWORK, event(x, 10), "plain", 4)
    assert sorted(set(found.neurons.tolist())) == sorted(NETWORK[name].neurons)
    assert found.times.size == 16 * 4
    assert set(found.columns.tolist()) == {512, 513, 514, 515}


@pytest.mark.parametrize("wiring", ["plain", "graded"])
def test_the_upper_half_reaches_no_obstacle_population(wiring: Wiring) -> None:
    assert obstacle_inputs(NETWORK, event(30, 64), wiring, 4).times.size == 0
    assert obstacle_inputs(NETWORK, event(30, 63), wiring, 4).times.size > 0


@pytest.mark.parametrize(
    ("x", "name", "place"), [(0, "OL", 0), (4, "OL", 1), (63, "OL", 15), (64, "OR", 15), (127, "OR", 0)]
)
def test_graded_an_event_reaches_the_owner_of_its_column(x: int, name: str, place: int) -> None:
    found = obstacle_inputs(NETWORK, event(x, 10), "graded", 2)
    assert set(found.neurons.tolist()) == {NETWORK[name].neurons[place]}
    assert found.times.size == 2


def test_graded_every_neuron_owns_four_columns() -> None:
    owners = [int(obstacle_inputs(NETWORK, event(x, 0), "graded", 1).neurons[0]) for x in range(128)]
    # 64 columns a side for 16 neurons
    assert set(np.bincount(owners)[: 2 * 16].tolist()) == {4}


@pytest.mark.parametrize("x", [0, 22, 105, 127])
def test_the_edges_reach_only_the_graded_populations(x: int) -> None:
    assert obstacle_inputs(NETWORK, event(x, 10), "plain", 4).times.size == 0
    assert obstacle_inputs(NETWORK, event(x, 10), "graded", 4).times.size == 4


def test_the_field_has_a_neuron_a_column_of_the_upper_half() -> None:
    field = NETWORK["target"].neurons
    assert [int(target_inputs(NETWORK, event(x, 100), 1).neurons[0]) for x in (0, 77, 127)] == [
        field[0], field[77], field[127],
    ]  # fmt: skip
    assert target_inputs(NETWORK, event(3, 10), 1).times.size == 0


def test_inputs_come_in_the_order_of_time() -> None:
    times = np.array([0.1, 0.2, 0.3])
    events = Events(times, np.array([100, 3, 90]), np.array([1, 1, 1]), np.ones(3, dtype=np.bool_))
    assert (np.diff(obstacle_inputs(NETWORK, events, "plain", 4).times) >= 0.0).all()
    assert (np.diff(kick(NETWORK, 4).times) >= 0.0).all()
