"""Networks in time: communication, functions, integration, inhibition, nodes in Python."""

from __future__ import annotations

import math

import numpy as np
import pytest

from chips.nef.build import build
from chips.nef.network.curves import IdealCurves
from chips.nef.network.network import Connection, Ensemble, EnsembleArray, Network, Neurons, Node, Probe
from chips.nef.simulation import Simulation
from circuits.arrays import F64
from circuits.errors import ParameterError

NOISE = 0.06  # of 100 neurons' decoded value through 50 ms, and of the fit; three of its standard deviations


def simulated(network: Network, seed: int = 0, interval: float = 0.001) -> Simulation:
    return Simulation(build(network, IdealCurves(), seed), interval)


def mean(run: Simulation, name: str, duration: float = 0.5) -> F64:
    values = []
    for _ in range(round(duration / 0.01)):
        run.advance(0.01)
        values.append(run.read(name))
    return np.asarray(np.mean(values, axis=0))


def test_a_value_its_square_and_a_turned_vector() -> None:
    run = simulated(
        Network(
            (Ensemble("a", 100, 2), Ensemble("square", 100, 2), Ensemble("turned", 100, 2)),
            (Node("in", 2),),
            (
                Connection("in", "a"),
                Connection("a", "square", np.square),
                Connection("a", "turned", transform=[[0.0, -1.0], [1.0, 0.0]]),
            ),
            tuple(Probe(f"{name}?", name, synapse=0.05) for name in ("a", "square", "turned")),
        )
    )
    run.set("in", [0.6, -0.3])
    run.advance(0.2)
    assert mean(run, "a?") == pytest.approx([0.6, -0.3], abs=NOISE)
    assert mean(run, "square?") == pytest.approx([0.36, 0.09], abs=NOISE)
    assert mean(run, "turned?") == pytest.approx([0.3, 0.6], abs=NOISE)


def test_arrays_take_each_number_by_itself() -> None:
    run = simulated(
        Network(
            (EnsembleArray(Ensemble("a", 80), 3), Ensemble("sum", 100, radius=2.0)),
            (Node("in", 3),),
            (Connection("in", "a"), Connection("a", "sum", np.square, [[1.0, 1.0, 2.0]])),
            (Probe("a?", "a", synapse=0.05), Probe("sum?", "sum", synapse=0.05)),
        )
    )
    run.set("in", [0.5, -0.5, 0.8])
    run.advance(0.2)
    assert mean(run, "a?") == pytest.approx([0.5, -0.5, 0.8], abs=NOISE)
    assert mean(run, "sum?") == pytest.approx([0.25 + 0.25 + 2.0 * 0.64], abs=2.0 * NOISE)  # radius 2


def test_an_integrator_integrates() -> None:
    tau = 0.1
    run = simulated(
        Network(
            (Ensemble("x", 300),),
            (Node("in", 1),),
            (
                Connection("in", "x", transform=tau, synapse=tau),
                Connection("x", "x", synapse=tau, regularisation=0.01),
            ),
            (Probe("x?", "x", synapse=0.05),),
        )
    )
    run.set("in", 0.5)
    run.advance(1.0)
    run.set("in", 0.0)
    run.advance(0.2)
    assert run.read("x?")[0] == pytest.approx(0.5, abs=NOISE)


@pytest.mark.parametrize("transform", [[[-500.0]], [[-500.0]] * 60])
def test_neurons_can_be_silenced(transform: list[list[float]]) -> None:
    run = simulated(
        Network(
            (EnsembleArray(Ensemble("a", 20), 3),),
            (Node("in", 3), Node("stop", 1)),
            (Connection("in", "a"), Connection("stop", Neurons("a"), transform=transform, synapse=0.001)),
            (Probe("a?", "a"),),
        )
    )
    run.set("in", [0.7] * 3)
    run.set("stop", 1.0)
    run.advance(0.02)
    spikes = run.spikes
    run.advance(0.3)
    assert run.spikes == spikes
    run.set("stop", 0.0)
    run.advance(0.3)
    assert run.spikes > spikes


def test_currents_can_differ_from_neuron_to_neuron() -> None:
    weights = np.zeros((40, 1))
    weights[:20] = -500.0
    run = simulated(
        Network(
            (Ensemble("a", 40, intercepts=(-0.5, -0.4), encoders=((1.0,),)),),
            (Node("stop", 1),),
            (Connection("stop", Neurons("a"), transform=weights),),
        )
    )
    run.set("stop", 1.0)
    run.advance(0.5)
    assert run.state.spikes[:20].max() <= 1  # before the inhibition has risen
    assert run.state.spikes[20:].min() > 10


def test_nodes_are_called_with_what_they_get() -> None:
    seen: list[tuple[float, float]] = []

    def robot(time: float, value: F64) -> F64:
        seen.append((time, float(value[0])))
        return np.array([math.cos(time)])

    run = simulated(
        Network(
            (Ensemble("a", 100),),
            (Node("robot", 1, 1, robot),),
            (Connection("robot", "a"), Connection("a", "robot", synapse=0.05)),
        ),
        interval=0.01,
    )
    run.advance(0.3)
    assert [time for time, _ in seen] == pytest.approx(0.01 * np.arange(30))
    assert seen[-1][1] == pytest.approx(math.cos(0.25), abs=2.0 * NOISE)  # behind by the synapses


@pytest.mark.parametrize("interval", [1e-3, 2e-3])
def test_sums_of_what_probes_show_call_nodes_as_ever(interval: float) -> None:
    called: list[float] = []

    def given(time: float, _: F64) -> list[float]:
        called.append(time)
        return [math.sin(300.0 * time)]

    network = Network(
        (Ensemble("a", 30),),
        (Node("in", 1, output=given),),
        (Connection("in", "a"),),
        (Probe("a?", "a", synapse=0.01), Probe("twice?", "a", transform=2.0, synapse=0.01)),
    )
    run, other = simulated(network, interval=interval), simulated(network, interval=interval)
    found, wanted = run.summed(["twice?", "a?"], 30), np.zeros(2)
    times = list(called)
    assert len(times) == 30
    for _ in range(30):
        other.advance(interval)
        wanted += [*other.read("twice?"), *other.read("a?")]
    assert found.tolist() == wanted.tolist()
    assert called == [*times, *times]
    assert run.time == other.time


def test_the_same_seed_is_the_same_run() -> None:
    network = Network((Ensemble("a", 50, 2),), (), (Connection("a", "a", synapse=0.1),))
    spikes = []
    for seed in (1, 1, 2):
        run = simulated(network, seed)
        run.advance(0.2)
        spikes.append(run.state.spikes.tolist())
    assert spikes[0] == spikes[1] != spikes[2]


def test_an_interval_is_of_whole_steps() -> None:
    built = build(Network((Ensemble("a", 5),)), IdealCurves(), 0)
    with pytest.raises(ParameterError, match=r"interval: 0.0015 s, must be a whole number of steps"):
        Simulation(built, 0.0015)
