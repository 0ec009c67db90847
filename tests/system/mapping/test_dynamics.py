"""The equations of networks against their closed forms, and distances between spike trains."""

import numpy as np
import pytest

from chips.aer import Events
from circuits.errors import DataError
from system.mapping.chips import map_on
from system.mapping.distance import van_rossum
from system.mapping.dynamics import Cells, Dynamics, Filter, Trains, asked, chosen, rates_of, run
from system.mapping.network import Connection, Input, Network, Population
from system.mapping.rolls.neuron import Curve, Wanted, matched

RATE, TAU = 5e3, 10e-3  # events that hardly ripple
EVENTS = Events(np.arange(int(1.2 * RATE)) / RATE, np.zeros(int(1.2 * RATE), dtype=np.int64))


@pytest.mark.parametrize("leak", ["membrane", "constant"])
@pytest.mark.parametrize("current", [1.3, 3.0])
def test_a_neurons_rate_is_that_of_its_equation(leak: str, current: float) -> None:
    weight = current / (RATE * TAU)
    network = Network(
        (Population("a", 1, 20e-3, 2e-3, leak),),  # type: ignore[arg-type]
        (Input("in", 1),),
        (Connection("in", "a", weight, tau=TAU),),
    )
    found = rates_of(run(asked(network), EVENTS, 1.2), 1, 0.2, 1.2)[0]
    wanted = Wanted(20e-3, 2e-3, leak == "constant").rate(np.array(current))
    assert found == pytest.approx(float(wanted), abs=1.0, rel=0.02)  # whole spikes; a spike's steps


@pytest.mark.parametrize("tau", [1e-3, 2e-3, 10e-3])
def test_the_mean_of_a_current_does_not_hang_on_how_fast_it_falls(tau: float) -> None:
    events = Events(np.arange(5 * int(RATE)) / RATE, np.zeros(5 * int(RATE), dtype=np.int64))
    network = Network(
        (Population("a", 1, 20e-3, 2e-3),),
        (Input("in", 1),),
        (Connection("in", "a", 1.5 / (RATE * tau), tau=tau),),
    )
    found = rates_of(run(asked(network), events, 5.0), 1, 0.2, 5.0)[0]
    wanted = Wanted(20e-3, 2e-3, constant=False).rate(np.array(1.5))
    assert found == pytest.approx(float(wanted), abs=0.3, rel=0.003)


@pytest.mark.parametrize("address", [-1, 1])
def test_an_event_on_a_channel_that_is_not_there_is_refused(address: int) -> None:
    connection = Connection("in", "a", 0.5, tau=TAU)
    network = Network((Population("a", 1),), (Input("in", 1),), (connection,))
    events = Events(np.array([0.0, 0.1]), np.array([0, address]))
    wanted = f"event 1 of address {address}, must be 0 to 0, the channels"
    with pytest.raises(DataError, match=wanted):
        run(asked(network), events, 0.2)
    with pytest.raises(DataError, match=wanted):
        map_on("rolls", network).events(events)


def test_a_neuron_with_an_upstroke_follows_the_closed_form() -> None:
    curve = Curve(40e-12, 18e-3, 0.15, 2e-3)
    current = np.array([1.2, 1.5, 4.0]) * curve.rheobase
    cells = Cells(
        np.full(3, curve.tau), np.full(3, curve.rheobase), np.full(3, curve.refractory), np.ones(3, np.bool_),
        np.full(3, curve.slope),
    )  # fmt: skip
    inputs = Filter(1.0, TAU, np.zeros((3, 3)), current[:, None] / (RATE * TAU))
    found = rates_of(run(Dynamics(cells, (inputs,)), EVENTS, 1.2), 3, 0.2, 1.2)
    assert found == pytest.approx(curve.rate(current), abs=1.0, rel=0.02)
    assert curve.current(curve.rate(current)) == pytest.approx(current, rel=1e-3)


@pytest.mark.parametrize("refractory", [0.0, 2e-3])
def test_an_integrator_stands_for_a_leaky_neuron_within_three_percent(refractory: float) -> None:
    wanted, at = Wanted(20e-3, refractory, constant=False), np.geomspace(1.1, 4.0, 9)
    found = matched(wanted, 0.15)
    curve = Curve(found.scale, found.tau, 0.15, refractory)
    assert curve.rate(at) == pytest.approx(wanted.rate(at), rel=0.03)  # as the how-to page says


def test_van_rossum_of_a_lone_spike_is_a_half_and_of_two_has_a_closed_form() -> None:
    one, nothing = np.array([0.1]), np.empty(0)
    assert van_rossum(one, one, 20e-3) == 0.0
    assert van_rossum(one, nothing, 20e-3) ** 2 == pytest.approx(0.5)
    shifted = van_rossum(one, one + 5e-3, 20e-3) ** 2
    assert shifted == pytest.approx(1.0 - np.exp(-0.25))


def test_spikes_of_chosen_neurons_are_numbered_in_their_order() -> None:
    trains = Trains(np.array([0.1, 0.2, 0.3]), np.array([7, 3, 5]))
    found = chosen(trains, [5, 7])
    assert found.times.tolist() == [0.1, 0.3]
    assert found.neurons.tolist() == [1, 0]
