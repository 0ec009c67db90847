"""The network's size and its measured constants: a driving synapse's latency, a coincidence's window."""

import numpy as np
import pytest

from circuits.errors import ParameterError
from system.openspace.law import Bat, arcs_of
from system.spiking_bat.network.network import (
    STEP,
    Conductors,
    Inputs,
    Network,
    Projection,
    new_state,
    run,
    wire,
)
from system.spiking_bat.numbers import DIRECTION_PRIORITY, Numbers
from system.spiking_bat.topology import goal_charge, layer_delays, published, suppression

S = Numbers()
ARCS = arcs_of(Bat(ping_rate=10.0))


@pytest.fixture(scope="module")
def network() -> Network:
    return published(ARCS, S)


def one_neuron(peak: float, tau: float, arrivals: list[float]) -> list[float]:
    """Spikes (s) of a neuron at rest after spikes that arrive at these times."""
    net = wire(
        {"cell": Conductors((1,), tau), "given": Inputs((1,))},
        [Projection("in", "given", "cell", (0, 0), peak)],
    )
    # a spike that is given in a step acts from the next one on
    inputs = np.array([(round(t / STEP) - 1, 1) for t in arrivals], dtype=np.int64)
    times = run(net, new_state(net), 40e-3, inputs)[0].of("cell")[0]
    return [float(t) for t in times]


def test_the_network_has_the_published_numbers_of_neurons(network: Network) -> None:
    assert network.wiring.conductors == 2078
    assert network.wiring.decay.size == 2931


def test_a_driving_synapse_takes_as_long_as_the_numbers_say() -> None:
    found = one_neuron(S.drive, S.tau_drive, [5e-3])
    assert found == pytest.approx([5e-3 + S.drive_latency], abs=1e-9)


def test_the_delay_line_hops_by_its_delay(network: Network) -> None:
    spikes, _ = run(
        network, new_state(network), 60e-3, np.array([(100, network.number("onset"))], dtype=np.int64)
    )
    times = spikes.of("tap")[0]
    hops = np.rint(np.diff([101 * STEP, *times]) / STEP)
    assert hops == pytest.approx(np.full(15, round(S.tap_delay / STEP)))


@pytest.mark.parametrize(
    ("gap", "spikes"), [(None, 0), (0.0, 1), (1.5e-3, 1), (2.8e-3, 1), (3.02e-3, 0), (6e-3, 0)]
)
def test_two_spikes_coincide_within_3_ms(gap: float | None, spikes: int) -> None:
    arrivals = [10e-3] if gap is None else [10e-3, 10e-3 + gap]
    assert len(one_neuron(S.coincidence, S.tau_coincidence, arrivals)) == spikes


def test_groups_are_preferred_as_the_paper_says() -> None:
    delays = layer_delays(S)
    assert [int(k) for k in np.argsort(delays)] == list(DIRECTION_PRIORITY) == [2, 1, 3, 0, 4]
    assert np.diff(np.sort(delays)) == pytest.approx(np.full(4, S.between))


def test_weights_are_gaussians() -> None:
    weight = suppression(S)
    assert weight[10, 10] * S.race == pytest.approx(S.suppression)
    assert weight[10, 11] / weight[10, 10] == pytest.approx(np.exp(-0.5))
    assert np.count_nonzero(weight[16]) == 7
    assert goal_charge(S)[5, 13] / S.goal == pytest.approx(np.exp(-1.0))


def test_numbers_that_cannot_be_are_refused() -> None:
    with pytest.raises(ParameterError, match=r"numbers\.drive: -1, must be >= 0 and finite"):
        Numbers(drive=-1.0)
    with pytest.raises(
        ParameterError, match=r"numbers\.integration: 0\.02 s, must be less than step_current"
    ):
        Numbers(integration=20e-3)
