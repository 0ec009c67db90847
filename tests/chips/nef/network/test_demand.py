"""What a network takes of a chip, told before anything is drawn: filters and slots that are then built."""

from __future__ import annotations

import numpy as np
import pytest

from chips.nef.build import build
from chips.nef.chip import NefChip
from chips.nef.network.curves import IdealCurves
from chips.nef.network.demand import check_demand, demand_of
from chips.nef.network.network import Connection, Ensemble, EnsembleArray, Network, Neurons, Node, Probe
from circuits.errors import ParameterError

PARTS = (Ensemble("a", 20, 2), EnsembleArray(Ensemble("b", 10), 3), Ensemble("c", 8))
NETWORK = Network(
    PARTS,
    (Node("in", 2), Node("out", 0, 3)),
    (
        Connection("in", "a", synapse=0.01),
        Connection("a", "a", synapse=0.1),
        Connection("in", "a", synapse=0.1),  # shares the filters of the one before
        Connection("a", "b", transform=np.ones((3, 2)), synapse=0.02),
        Connection("in", Neurons("b"), transform=[[1.0, 0.0]], synapse=0.01),  # one current into all
        Connection("a", Neurons("b"), transform=[[0.5, 0.0]], synapse=0.01),  # the same one, and its filter
        Connection("a", Neurons("b"), transform=[[0.5, 0.0]], synapse=0.03),
        Connection("a", Neurons("b", scaled=True), transform=[[1.0, 1.0]], synapse=0.01),
        Connection("b", Neurons("c"), transform=np.ones((8, 3)), synapse=0.01),
        Connection("b", "out"),
    ),
    (Probe("a?", "a"),),
)


def test_a_network_takes_what_is_built_of_it() -> None:
    found, net = demand_of(NETWORK), build(NETWORK, IdealCurves(), 1).net
    assert found.filters == int((net.goes >= 0).sum()) == 2 + 2 + 3 + 3 + 3 + 3 + 3
    assert found.lines == net.slot[-1] == 2 + 3 * (1 + 2) + (1 + 3)
    assert found.dimensions == {"a": 2, "b": 1, "c": 1}
    assert found.currents == {"a": 0, "b": 2, "c": 3}
    check_demand(NETWORK, NefChip())


@pytest.mark.parametrize(
    ("network", "told"),
    [
        (Network((Ensemble("x", 101),)), r"^x: neurons up to number 101, the chip has 100; take"),
        (Network((Ensemble("x", 5, 64),)), r"^x: 64 dimensions and 0 currents .* 65 encoder columns"),
        (
            Network((Ensemble("x", 50), Ensemble("y", 50)), (), (
                Connection("x", Neurons("y"), transform=np.ones((50, 16))),
            )),
            r"^y: 1 dimensions and 16 currents into its neurons take 66 encoder columns, the chip has 64",
        ),
        (
            Network((EnsembleArray(Ensemble("x", 1), 90),), (Node("in", 90),), tuple(
                Connection("in", "x", synapse=0.01 * k) for k in range(1, 7)
            )),
            r"^nef-chip: 540 filters, the chip has 512; take fewer slots or time constants$",
        ),
        (
            Network(tuple(Ensemble(f"e{k}", 1, 60) for k in range(9))),
            r"^nef-chip: 540 dimensions and currents into neurons, the chip has 512 lines",
        ),
    ],
    ids=["neurons", "dimensions", "currents", "filters", "lines"],
)  # fmt: skip
def test_a_network_that_has_no_room_is_refused(network: Network, told: str) -> None:
    with pytest.raises(ParameterError, match=told):
        check_demand(network, NefChip(neurons=100))
