"""Every sample of nodes and probes beside nengo's own simulator, in the step in which it is there."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any

import nengo
import numpy as np
import pytest

from chips.nef.nengo.simulator import Simulator
from circuits.errors import ParameterError

pytestmark = pytest.mark.filterwarnings("ignore::nengo.exceptions.NengoWarning")

STEPS = 200
SYNAPSES = (None, 0.0, 1e-5, 0.01, nengo.Alpha(0.02), nengo.LinearFilter([1.0, 2.0], [0.02, 1.0]))
ROUNDING = 1e-12  # of values up to 1


def wave(t: float) -> list[float]:
    return [float(np.sin(40.0 * t)), 0.5]


def beside_nengo(network: nengo.Network, steps: int = STEPS) -> None:
    """Compare all probes."""
    ours = Simulator(network, chip=None)
    ours.run_steps(steps)
    with nengo.Simulator(network, progress_bar=False) as theirs:
        theirs.run_steps(steps)
        for probe in network.all_probes:
            found, wanted = ours.data[probe], theirs.data[probe]
            assert found.shape == wanted.shape
            assert np.abs(found - wanted).max() <= ROUNDING * max(1.0, np.abs(wanted).max()), probe


@pytest.mark.parametrize("behind", SYNAPSES)
@pytest.mark.parametrize("before", SYNAPSES)
def test_chains_of_nodes_are_nengos(before: Any, behind: Any) -> None:
    with nengo.Network(seed=1) as network:
        given = nengo.Node(wave)
        passed, called = nengo.Node(size_in=1), nengo.Node(lambda t, x: x + t, size_in=1, size_out=1)
        nengo.Connection(given[0], passed, synapse=before)
        nengo.Connection(passed, called, transform=2.0, synapse=behind)
        nengo.Connection(given, called, function=lambda x: x[0] * x[1], synapse=before)
        for node in (given, passed, called):
            nengo.Probe(node)
            nengo.Probe(node[[0]], synapse=behind, sample_every=0.003)
    beside_nengo(network)


@pytest.mark.parametrize("synapse", SYNAPSES[1:])
def test_nodes_that_feed_themselves_are_nengos(synapse: Any) -> None:
    with nengo.Network(seed=1) as network:
        loop, far = nengo.Node(lambda _, x: 0.5 * x + 1.0, size_in=2, size_out=2), nengo.Node(size_in=2)
        nengo.Connection(loop, loop, transform=[[0.9, 0.1], [-0.2, 0.8]], synapse=synapse)
        nengo.Connection(loop, far, synapse=None)
        nengo.Connection(far, loop, transform=0.1, synapse=synapse)
        nengo.Probe(loop), nengo.Probe(far, synapse=0.005)
    beside_nengo(network)


@pytest.mark.parametrize("synapse", SYNAPSES)
def test_what_neurons_send_to_nodes_and_probes_is_nengos(synapse: Any) -> None:
    with nengo.Network(seed=1) as network:
        given, ensemble = nengo.Node(wave), nengo.Ensemble(60, 2, radius=1.3)
        nengo.Connection(given, ensemble, synapse=None)
        decoded, counted, mixed = (nengo.Node(lambda t, x: x + t, size_in=1, size_out=1) for _ in range(3))
        nengo.Connection(ensemble, decoded, function=lambda x: x[0] * x[1], synapse=synapse)
        nengo.Connection(ensemble.neurons[:7], counted, transform=np.full((1, 7), 1e-3), synapse=synapse)
        nengo.Connection(decoded, mixed, synapse=None)
        nengo.Connection(ensemble[1], mixed, synapse=0.004)
        nengo.Connection(mixed, counted, synapse=0.01)
        for seen in (decoded, counted, mixed, ensemble, ensemble[0], ensemble.neurons):
            nengo.Probe(seen, synapse=synapse)
    beside_nengo(network)


@pytest.mark.parametrize("synapse", [0.0, 1e-5, 0.01])
def test_what_comes_to_neurons_by_synapses_is_nengos(synapse: float) -> None:
    """Spike by spike, from the drawn membranes on."""
    with nengo.Network(seed=1) as network:
        given, passed = nengo.Node(wave), nengo.Node(size_in=2)
        a, b = nengo.Ensemble(60, 2), nengo.Ensemble(50, 1)
        nengo.Connection(given, passed, synapse=synapse)
        nengo.Connection(passed, a, synapse=None)
        nengo.Connection(given[0], b, function=lambda x: -x, synapse=synapse)
        nengo.Connection(a, b, function=lambda x: x[0] * x[1], synapse=synapse)
        nengo.Connection(b, a[1], synapse=synapse)
        nengo.Connection(given[1], b.neurons, transform=np.full((50, 1), -0.1), synapse=synapse)
        array = nengo.networks.EnsembleArray(30, 2)
        nengo.Connection(a, array.input, synapse=synapse)
        nengo.Connection(array.output, a, synapse=synapse, transform=0.3)
        for ensemble in network.all_ensembles:
            nengo.Probe(ensemble.neurons)
    beside_nengo(network)


def test_membranes_begin_where_they_are_told_to() -> None:
    with nengo.Network(seed=1) as network:
        for voltage in (nengo.dists.Choice([0.5]), np.linspace(0.1, 0.9, 40)):
            state = {"voltage": voltage, "refractory_time": nengo.dists.Uniform(0.0, 0.01)}
            ensemble = nengo.Ensemble(40, 1, neuron_type=nengo.LIF(initial_state=state))
            nengo.Probe(ensemble.neurons)
    beside_nengo(network)


@pytest.mark.parametrize("tau_rc", [0.4e-3, 2e-3, 0.1])
def test_neurons_with_other_membranes_are_nengos(tau_rc: float) -> None:
    with nengo.Network(seed=1) as network:
        ensemble = nengo.Ensemble(60, 1, neuron_type=nengo.LIF(tau_rc=tau_rc, tau_ref=0.001))
        nengo.Connection(nengo.Node(wave)[0], ensemble, synapse=None)
        nengo.Probe(ensemble.neurons)
    beside_nengo(network)


def test_processes_draw_by_the_simulators_seed() -> None:
    with nengo.Network(seed=1) as network:
        drawn = nengo.Probe(nengo.Node(nengo.processes.WhiteNoise(), size_out=2))
        fixed = nengo.Probe(nengo.Node(nengo.processes.WhiteNoise(seed=5), size_out=2))
    with nengo.Simulator(network, progress_bar=False) as theirs:
        theirs.run_steps(20)
    seen = []
    ours = Simulator(network, chip=None)
    assert ours.seed == theirs.seed == 2
    for seed in (None, None, 7, 2):
        ours.reset(seed)
        ours.run_steps(20)
        assert (ours.data[fixed] == theirs.data[fixed]).all()
        seen.append(ours.data[drawn])
    assert (seen[0] == seen[1]).all()
    assert (seen[0] != seen[2]).all()
    assert (seen[0] == seen[3]).all()


@pytest.mark.parametrize("found", [None, np.nan, "string", [1.0, 2.0]])
@pytest.mark.parametrize("where", ["node", "connection"])
def test_functions_that_give_no_numbers_in_a_run_are_refused(found: Any, where: str) -> None:
    def late(t: Any) -> Any:
        return 1.0 if t < 0.005 else found

    with nengo.Network() as network:
        given: Any = nengo.Node(late if where == "node" else lambda t: t)
        function: Callable[[Any], Any] | None = None if where == "node" else (lambda x: late(x[0]))
        nengo.Connection(given, nengo.Node(size_in=1), function=function)
    run = Simulator(network, chip=None)
    run.run_steps(4)
    with pytest.raises(ParameterError, match=r"must be 1 finite numbers"):
        run.run_steps(4)


@pytest.mark.parametrize("synapse", [None, 0.0])
def test_spikes_that_act_a_step_late_are_warned_of(synapse: float | None) -> None:
    with nengo.Network(seed=1) as network:
        a, b, node = nengo.Ensemble(30, 1), nengo.Ensemble(30, 1), nengo.Node(size_in=1)
        nengo.Connection(nengo.Node([0.7]), a, synapse=None)
        nengo.Connection(a, node, synapse=None)
        nengo.Connection(node, b, transform=0.01, synapse=synapse)
        nengo.Connection(a, b.neurons, transform=np.full((30, 1), 1e-3), synapse=synapse)
        nengo.Probe(b.neurons)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        beside_nengo(network) if synapse is not None else Simulator(network, chip=None)
    says = [str(each.message) for each in caught if "a step later than in nengo" in str(each.message)]
    assert len(says) == (synapse is None)
    assert all("and 1 more: spikes without a synapse" in each for each in says)
