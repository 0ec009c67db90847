"""nengo's own networks, unmodified: an ideal die beside nengo's simulator, and a chip beside it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import nengo
import numpy as np
import pytest

from chips.nef.chip import NefChip
from chips.nef.nengo.simulator import Simulator
from circuits.silicon.die import Die

pytestmark = pytest.mark.filterwarnings("ignore::nengo.exceptions.NengoWarning")

DURATION = 0.5  # s
SETTLED = 100  # steps of 1 ms


def product() -> Any:
    given, net = nengo.Node([0.5, -0.8]), nengo.networks.Product(100, 2)
    nengo.Connection(given, net.input_a, synapse=None)
    nengo.Connection(given, net.input_b, synapse=None)
    return net.output


def convolution() -> Any:
    one, two = nengo.Node(np.ones(4) / 2.0), nengo.Node([1.0, 0.0, 0.0, 0.0])
    net = nengo.networks.CircularConvolution(100, 4)
    nengo.Connection(one, net.input_a, synapse=None)
    nengo.Connection(two, net.input_b, synapse=None)
    return net.output


def thalamus() -> Any:
    given, ganglia, net = (
        nengo.Node([0.3, 0.9, 0.5]),
        nengo.networks.BasalGanglia(3),
        nengo.networks.Thalamus(3),
    )
    nengo.Connection(given, ganglia.input, synapse=None)
    nengo.Connection(ganglia.output, net.input)
    return net.output


def gated_memory() -> Any:
    """Its gate inhibits neurons through pass-throughs as wide as they are many."""
    given, gate = nengo.Node(lambda t: 0.6 if t < 0.25 else -0.5), nengo.Node(lambda t: float(t >= 0.25))
    net = nengo.networks.InputGatedMemory(100, 1)
    nengo.Connection(given, net.input, synapse=None)
    nengo.Connection(gate, net.gate, synapse=None)
    return net.output


def winner() -> Any:
    given, net = nengo.Node([0.6, 0.9, 0.1]), nengo.networks.AssociativeMemory(np.eye(3), n_neurons=50)
    net.add_wta_network(1.5)
    net.add_threshold_to_outputs()
    nengo.Connection(given, net.input, synapse=None)
    return net.output


def rms(values: Any) -> float:
    return float(np.sqrt(np.mean(values**2)))


@pytest.mark.parametrize("make", [product, convolution, thalamus, gated_memory, winner])
def test_networks_of_nengo_do_the_same(make: Callable[[], Any]) -> None:
    found = []
    for chip in (None, None, NefChip(Die(number=7))):
        with nengo.Network(seed=4) as net:
            probe = nengo.Probe(make(), synapse=0.05)
        ours = {"chip": chip} if found else {"optimize": False, "progress_bar": False}
        with (Simulator if found else nengo.Simulator)(net, **ours) as run:
            run.run(DURATION)
            found.append(run.data[probe][SETTLED:])
    nengos, ideal, die = found
    scale = rms(nengos)
    # the same spikes; the winner's thresholds get theirs without a synapse, which takes a step here
    assert rms(ideal - nengos) < (0.005 if make is winner else 1e-12) * scale
    # other neurons: each population's own noise and decoding error, of 50 to 100 neurons
    assert rms(die - nengos) < 0.2 * scale


@pytest.mark.parametrize("inhibition", [0.0, -0.5, -1.0, -3.0])
def test_currents_into_neurons_are_scaled_by_their_gains(inhibition: float) -> None:
    def counts(make: Any, **options: Any) -> Any:
        with nengo.Network(seed=4) as net:
            ensemble = nengo.Ensemble(100, 1)
            nengo.Connection(nengo.Node([0.6]), ensemble, synapse=None)
            nengo.Connection(
                nengo.Node([inhibition]), ensemble.neurons, transform=np.ones((100, 1)), synapse=None
            )
            probe = nengo.Probe(ensemble.neurons)
        with make(net, **options) as run:
            run.run(0.4)
            return run.data[probe].sum(axis=0) * run.dt

    ours = counts(Simulator, chip=None)
    theirs = counts(nengo.Simulator, optimize=False, progress_bar=False)
    assert np.abs(ours - theirs).max() <= 1.0  # a spike more or less where the run ends
    assert (ours.max() == 0.0) == (inhibition == -3.0)
