"""Descriptions of networks: what is refused, and what is counted."""

from __future__ import annotations

import pytest

from chips.nef.network.network import (
    Connection,
    Ensemble,
    EnsembleArray,
    Network,
    Node,
    Probe,
    join,
    neurons_of,
)
from circuits.errors import ParameterError, TopologyError, UnknownNameError
from tests.refusals import refusals


def test_neurons_are_counted() -> None:
    network = Network((Ensemble("a", 30, 2), EnsembleArray(Ensemble("b", 10), 4)))
    assert network.neurons == 70
    assert neurons_of(network.ensemble("b")) == 40


def test_networks_are_joined() -> None:
    joined = join(
        (
            Network((Ensemble("a", 10),), (Node("in", 1),), (Connection("in", "a"),)),
            Network((Ensemble("b", 10),), (), (Connection("a", "b"),), (Probe("b?", "b"),)),
        )
    )
    assert [e.name for e in joined.ensembles] == ["a", "b"]
    assert len(joined.connections) == 2
    assert joined.node("in").size_out == 1


def test_names_are_told_apart() -> None:
    with pytest.raises(TopologyError, match="a: twice in a network"):
        join((Network((Ensemble("a", 10),)), Network((), (Node("a", 1),))))
    with pytest.raises(UnknownNameError, match="ensemble c: unknown; known are a"):
        Network((Ensemble("a", 10),)).ensemble("c")
    with pytest.raises(UnknownNameError, match="node a: unknown"):
        Network((Ensemble("a", 10),)).node("a")


test_ensembles_that_cannot_be = refusals(
    ParameterError,
    lambda fields: Ensemble(**{"name": "a", "neurons": 10, **fields}),
    [
        ({"neurons": 0}, "a.neurons: 0, must be at least 1"),
        ({"dimensions": 0}, "a.dimensions: 0, must be at least 1"),
        ({"radius": 0.0}, "a.radius: 0, must be above 0"),
        ({"radius": float("nan")}, "a.radius: nan, must be above 0"),
        ({"max_rates": (0.0, 100.0)}, "a.max_rates: 0 to 100 Hz, must be above 0"),
        ({"max_rates": (200.0, 100.0)}, "a.max_rates: 200 to 100 Hz"),
        ({"intercepts": (0.0, 1.0)}, "a.intercepts: 0 to 1, must be from -1 to below 1"),
        ({"encoders": ((1.0, 0.0),)}, r"a.encoders: shape \(1, 2\), must be \(k, 1\)"),
        ({"encoders": ((0.0,),)}, "a.encoders: one of length 0"),
    ],
)


def test_arrays_are_of_one_dimension() -> None:
    with pytest.raises(ParameterError, match="a: 3 ensembles of 2 dimensions"):
        EnsembleArray(Ensemble("a", 10, 2), 3)


def test_connections_that_cannot_be() -> None:
    with pytest.raises(ParameterError, match=r"a->b.synapse: -1 s, must be >= 0"):
        Connection("a", "b", synapse=-1.0)
    with pytest.raises(ParameterError, match=r"a->b.regularisation: 0, must be above 0"):
        Connection("a", "b", regularisation=0.0)
