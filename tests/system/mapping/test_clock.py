"""Inputs that send by themselves: at their times, whatever the pieces that a run goes on by."""

from pathlib import Path

import numpy as np
import pytest

from chips.aer import Events
from circuits.errors import ParameterError
from system.mapping.certify.spiking import IdealPlayer
from system.mapping.certify.task import Samples
from system.mapping.clock import outside, own_rates, with_own, with_own_rates
from system.mapping.dynamics import asked, rates_of, run, usual_rates
from system.mapping.network import Connection, Input, Network, Population, Probe
from system.mapping.network_file import read_network, write_network

NOTHING = Events(np.empty(0), np.empty(0, np.int64))
NETWORK = Network(
    (Population("cells", 2, 20e-3, 0.0),),
    (Input("clock", 1, 500.0), Input("in", 2)),
    (Connection("clock", "cells", 0.5, tau=5e-3), Connection("in", "cells", 1e-6, "one-to-one")),
    (Probe("out", "cells"),),
)


def test_events_are_in_the_middle_of_each_period() -> None:
    found = with_own(NETWORK, Events(np.array([3.5e-3]), np.array([2])), 0.0, 6e-3)
    assert found.times.tolist() == pytest.approx([1e-3, 3e-3, 3.5e-3, 5e-3])
    assert found.addresses.tolist() == [0, 0, 2, 0]


@pytest.mark.parametrize("at", [0.4e-3, 1e-3, 3e-3, 4e-3])
def test_pieces_have_the_events_of_the_whole(at: float) -> None:
    whole = with_own(NETWORK, NOTHING, 0.0, 0.1)
    parts = [with_own(NETWORK, NOTHING, begin, end) for begin, end in ((0.0, at), (at, 0.1))]
    assert np.array_equal(np.concatenate([part.times for part in parts]), whole.times)
    assert all(
        ((part.times >= b) & (part.times < e)).all()
        for part, b, e in zip(parts, (0.0, at), (at, 0.1), strict=True)
    )


def test_a_network_without_a_clock_has_its_events_as_they_are() -> None:
    plain = Network(NETWORK.populations, (Input("in", 2),))
    events = Events(np.array([0.1]), np.array([1]))
    assert with_own(plain, events, 0.0, 1.0) is events
    assert outside(plain).tolist() == [0, 1]


def test_rates_of_outside_are_put_beside_those_of_the_clock() -> None:
    assert own_rates(NETWORK).tolist() == [500.0, 0.0, 0.0]
    assert with_own_rates(NETWORK, np.array([[1.0, 2.0], [3.0, 4.0]])).tolist() == [
        [500.0, 1.0, 2.0],
        [500.0, 3.0, 4.0],
    ]
    assert usual_rates(NETWORK, NOTHING, 1.0).channels.tolist() == [500.0, 0.0, 0.0]


def test_a_task_gives_the_channels_of_outside_alone_and_the_clock_goes_on() -> None:
    Samples(np.ones((1, 2)), np.zeros(1, np.int64), 0.1, 1).check(NETWORK)
    with pytest.raises(ParameterError, match=r"inputs: 3 channels, must be the network's 2"):
        Samples(np.ones((1, 3)), np.zeros(1, np.int64), 0.1, 1).check(NETWORK)
    player = IdealPlayer(NETWORK)
    counts = sum(player([0.0, 0.0], 0.1)[0] for _ in range(10))
    trains = run(asked(NETWORK), with_own(NETWORK, NOTHING, 0.0, 1.0), 1.0)
    assert counts == pytest.approx(rates_of(trains, 2, 0.0, 1.0).sum(), abs=4.0)  # a spike or two a neuron
    assert counts > 40.0


def test_a_file_keeps_the_rate(tmp_path: Path) -> None:
    write_network(tmp_path / "n.toml", NETWORK)
    assert "rate" in (tmp_path / "n.toml").read_text(encoding="utf-8")
    assert read_network(tmp_path / "n.toml") == NETWORK
