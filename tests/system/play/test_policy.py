"""Codes make events of numbers and actions of events; a chip between them steers, each run alike."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from chips.aer import Events
from chips.live.chip import LiveChip
from chips.live.table import open_chip
from circuits.errors import ParameterError
from circuits.silicon.die import Die
from system.play.decoder import LatencyDecoder, PopulationDecoder, RateDecoder, VoteDecoder
from system.play.encoder import LatencyCode, PopulationCode, Ranges, RateCode
from system.play.policy import ChipPolicy

TWO = Ranges((0.0, -1.0), (1.0, 1.0), ((0, 1), (2,)))
SIDES = ((0, 1), (2, 3))


@given(st.floats(0.0, 1.0), st.integers(1, 40))
def test_a_rate_goes_on_from_window_to_window(share: float, pieces: int) -> None:
    code = RateCode(TWO, most=200.0)
    window = 1.0 / pieces
    found = [code.events(np.array([share, -1.0]), k * window, window) for k in range(pieces)]
    times = np.concatenate([t for t, _ in found])
    assert np.all(np.diff(times) >= 0.0)
    assert abs(np.concatenate([a for _, a in found]).size - 2.0 * 200.0 * share) <= 2.0
    for k, (when, _) in enumerate(found):
        assert np.all((when >= k * window - 1e-12) & (when <= (k + 1) * window))


def test_what_is_out_of_range_is_cut_off_and_counted() -> None:
    code = RateCode(TWO, most=100.0)
    times, addresses = code.events(np.array([5.0, -3.0]), 0.0, 0.1)
    assert sorted(addresses.tolist()) == [0] * 10 + [1] * 10
    assert code.clipped == 2
    assert times.size == 20
    with pytest.raises(ParameterError, match="encoder: 3 numbers, must be 2"):
        code.events(np.zeros(3), 0.0, 0.1)
    with pytest.raises(ParameterError, match=r"encoder\[0\]: 1 to 1, must be finite and rise"):
        Ranges((1.0,), (1.0,), ((0,),))


def test_the_larger_a_number_the_sooner_its_event() -> None:
    times, addresses = LatencyCode(TWO).events(np.array([0.25, 1.0]), 2.0, 0.1)
    assert addresses.tolist() == [2, 0, 1]
    assert np.allclose(times, [2.0, 2.075, 2.075])
    assert LatencyCode(TWO).events(np.array([0.0, -1.0]), 0.0, 0.1)[0].size == 0


def test_addresses_of_a_population_answer_about_their_centres() -> None:
    code = PopulationCode(Ranges((0.0,), (4.0,), ((0, 1, 2, 3, 4),)), most=1000.0)
    _, addresses = code.events(np.array([3.0]), 0.0, 1.0)
    counts = np.bincount(addresses, minlength=5)
    assert np.allclose(counts, 1000.0 * np.exp(-0.5 * (np.arange(5) - 3.0) ** 2), atol=1.0)


def test_decoders_make_actions_of_events() -> None:
    events = Events(np.array([0.01, 0.02, 0.03]), np.array([2, 0, 1]))
    assert VoteDecoder(SIDES).action(events, 0.0, 0.1) == 0
    assert LatencyDecoder(SIDES).action(events, 0.0, 0.1) == 1
    assert PopulationDecoder(SIDES, np.array([-1.0, 2.0])).action(events, 0.0, 0.1) == pytest.approx([0.0])
    rates = RateDecoder(SIDES, np.array([[1.0, -1.0]]), offset=0.5)
    assert rates.action(events, 0.0, 0.1) == pytest.approx([10.0 - 5.0 + 0.5])
    slow = RateDecoder(SIDES, np.eye(2), tau=0.1)
    first = slow.action(events, 0.0, 0.1)
    assert first == pytest.approx((1.0 - np.exp(-1.0)) * np.array([10.0, 5.0]))
    with pytest.raises(ParameterError, match="1 values and 2 groups"):
        PopulationDecoder(SIDES, np.array([1.0]))


def test_without_events_the_last_choice_stands_and_is_counted() -> None:
    nothing = Events(np.empty(0), np.empty(0, dtype=np.int64))
    one = Events(np.array([0.0]), np.array([3]))
    vote, late = VoteDecoder(SIDES), LatencyDecoder(SIDES)
    assert [vote.action(e, 0.0, 0.1) for e in (one, nothing)] == [1, 1]
    assert [late.action(e, 0.0, 0.1) for e in (one, nothing)] == [1, 1]
    assert (vote.ties, late.silent) == (1, 1)
    vote.begin()
    assert vote.action(nothing, 0.0, 0.1) == 0


@dataclass
class Calls:
    """Calls and echoes of a ranging chip: an echo after a call, the later the larger a number."""

    begun: int = field(default=0)

    def begin(self) -> None:
        self.begun += 1

    def events(self, values: Any, start: float, window: float) -> Any:
        return np.array([start, start + values[0]]), np.array([0, 1])


def chip() -> LiveChip:
    return open_chip("ranging-chip", Die("A", 1001))


def test_a_chip_chooses_by_what_it_hears_and_begins_anew() -> None:
    policy = ChipPolicy(
        chip(), Calls(), VoteDecoder([[k] for k in range(13)]), 40e-3, lambda seen: seen / 1e3
    )
    first = [policy(np.array([8.0 + 4.0 * k])) for k in range(3)]
    assert policy.chip.time == pytest.approx(0.12)
    policy.begin()
    assert policy.chip.time == 0.0
    assert [policy(np.array([8.0 + 4.0 * k])) for k in range(3)] == first
    with pytest.raises(ParameterError, match=r"policy\.window: 0 s"):
        ChipPolicy(chip(), Calls(), VoteDecoder(SIDES), 0.0)
