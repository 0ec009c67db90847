"""Networks as arrays: lanes are shared, transforms are in the decoders, and what does not fit is refused."""

from __future__ import annotations

import numpy as np
import pytest

from chips.nef.build import build
from chips.nef.network.curves import IdealCurves
from chips.nef.network.kernel import DT
from chips.nef.network.network import Connection, Ensemble, EnsembleArray, Network, Neurons, Node, Probe
from circuits.errors import ParameterError, TopologyError, UnknownNameError

ENDS = ((Ensemble("a", 20, 2), Ensemble("b", 20), EnsembleArray(Ensemble("c", 5), 3)), (Node("n", 2),))


@pytest.mark.parametrize(
    ("connection", "error", "says"),
    [
        (Connection("a", "x"), UnknownNameError, "node x: unknown"),
        (Connection("x", "a"), UnknownNameError, "node x: unknown"),
        (Connection("a", "b"), ParameterError, "a->b.transform: 2 results, must be the 1 that the end takes"),
        (Connection("a", "b", transform=[[1.0]]), ParameterError, r"shape \(1, 1\), must be \(results, 2\)"),
        (Connection("a", "b", transform=[[1.0, np.nan]]), ParameterError, "not finite, must be numbers"),
        (Connection("n", "a", np.square), TopologyError, "n->a.function: on a node"),
        (Connection("a", "b", lambda x: x[:, :1] / 0.0 * 0.0), ParameterError, "a->b.function: not finite"),
        (Connection("a", "b", lambda x: x[:, 0]), ParameterError, "a->b.function: shape"),
        (Connection("c", "b", lambda x: np.hstack([x, x])), ParameterError, "c->b.function: 2 results of a"),
        (Connection("b", Neurons("a"), transform=[[1.0]] * 7), ParameterError, r"shape \(7, 1\), must be"),
        (Connection("b", Neurons("n"), transform=[[1.0]]), UnknownNameError, "ensemble n: unknown"),
    ],
)
@pytest.mark.filterwarnings("ignore:divide by zero", "ignore:invalid value")
def test_connections_that_do_not_fit(connection: Connection, error: type[Exception], says: str) -> None:
    with pytest.raises(error, match=says):
        build(Network(*ENDS, (connection,)), IdealCurves(), 0)


def test_what_goes_to_one_slot_with_one_time_constant_shares_a_lane() -> None:
    one = Connection("a", "b", transform=[[1.0, 0.0]])
    lanes = [len(build(Network(*ENDS, held), IdealCurves(), 0).net.keep) for held in ((one,), (one, one))]
    assert lanes == [1, 1]
    other = Connection("a", "b", transform=[[1.0, 0.0]], synapse=0.1)
    assert len(build(Network(*ENDS, (one, other)), IdealCurves(), 0).net.keep) == 2


def test_decoders_add_up_with_their_transforms() -> None:
    one, two = (Connection("a", "b", transform=[row]) for row in ([2.0, 0.0], [0.0, -1.0]))
    both = Connection("a", "b", transform=[[2.0, -1.0]])
    found = [build(Network(*ENDS, held), IdealCurves(), 0).net.decoder for held in ((one, two), (both,))]
    assert found[0] == pytest.approx(found[1])  # rounding


def test_decoders_are_those_of_the_population_over_a_step() -> None:
    built = build(Network(*ENDS, (Connection("b", "b"),)), IdealCurves(), 0)
    (p,) = built.populations["b"]
    assert built.net.decoder == pytest.approx(p.decoders(p.points, p.factor(0.1))[:, 0] / DT)


def test_numbers_of_neurons_and_lanes_of_probes() -> None:
    built = build(Network(*ENDS, (), (Probe("a?", "a"), Probe("c?", "c"))), IdealCurves(), 0)
    assert [built.neurons(name) for name in "abc"] == [slice(0, 20), slice(20, 40), slice(40, 55)]
    assert [built.read[name].stop - built.read[name].start for name in ("a?", "c?")] == [2, 3]
    assert len(built.net.bias) == built.network.neurons
