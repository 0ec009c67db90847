"""What a client sends is taken in the order of its times or counted, whatever it is."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from circuits.arrays import I64, Bools
from system.stream import inlet
from system.stream.inlet import FARTHEST, Inlet
from system.stream.record import Code, Counts, came


def small(addresses: I64) -> Bools:
    """Ten addresses."""
    return addresses < 10


def rows(*pairs: tuple[int, int]) -> I64:
    return np.array(pairs, dtype=np.int64)


def test_events_wait_for_their_time_and_the_last_one_is_taken_at_the_end() -> None:
    found = Inlet(small, Counts())
    found.take(rows((5, 1), (9, 2), (9, 3)), 0)
    assert found.last == 9
    assert found.due(9, 0).tolist() == [[5, 1]]
    found.take(rows((20, Code.TIME), (20, 4), (0, Code.END), (30, 5)), 5)
    assert (found.last, found.ended, found.waiting) == (21, True, 3)
    assert found.due(21, 10).tolist() == [[10, 2], [10, 3], [20, 4]]
    assert found.counts == Counts({Code.TAKEN: 4, Code.LATE: 2, Code.DROPPED_IN: 0})


def test_what_is_not_taken_is_counted_and_the_first_of_it_is_told() -> None:
    found = Inlet(small, Counts())
    found.take(rows((5, 1), (3, 1), (4, 1), (6, 77), (7, -5), (FARTHEST + 11, 1), (-1, 2)), 10)
    assert found.counts[Code.BACKWARDS] == 2
    assert found.counts[Code.UNKNOWN] == 2
    assert found.counts[Code.FAR] == 1
    assert found.remarks == [
        "address 77, not on the chip; see its addresses",
        f"time {FARTHEST + 11} us, must be within an hour of the chip's, 10 us; send later",
        "event at 3 us, after 5 us; send in order",
    ]
    assert found.due(100, 0).tolist() == [[5, 1], [10, 2]]


def test_a_full_queue_drops_and_what_waits_at_the_end_is_left(monkeypatch) -> None:  # type: ignore[no-untyped-def]
    monkeypatch.setattr(inlet, "ROOM", 3)
    found = Inlet(small, Counts())
    found.take(rows(*((t, 1) for t in range(5))), 0)
    assert (found.full, found.counts[Code.DROPPED_IN]) == (True, 2)
    found.due(1, 0)
    found.leave()
    assert (found.counts[Code.LEFT], found.waiting) == (2, 0)


def test_no_more_are_taken_at_once_than_a_slow_chip_can_hear() -> None:
    found = Inlet(small, Counts())
    found.take(rows((5, 1), (5, 2), (9, 3)), 0)
    found.take(rows((9, 4), (12, 5)), 0)
    assert [found.limit(20, most) for most in (1, 2, 3, 4, 5)] == [6, 9, 9, 12, 20]
    assert found.due(20, 0, 3).tolist() == [[5, 1], [5, 2], [9, 3]]
    assert found.due(20, 10, 1).tolist() == [[10, 4]]
    assert (found.due(20, 10).tolist(), found.waiting, found.counts[Code.LATE]) == ([[12, 5]], 0, 1)


WORDS = st.integers(-(2**63), 2**63 - 1) | st.integers(-20, 40)


@settings(max_examples=50)
@given(st.lists(st.lists(st.tuples(WORDS, WORDS), max_size=8), max_size=4))
def test_any_records_do_no_harm_and_none_is_lost(batches: list[list[tuple[int, int]]]) -> None:
    found, events, now, taken = Inlet(small, Counts()), 0, 0, []
    for batch in batches:
        some = np.array(batch, dtype=np.int64).reshape(-1, 2)
        if not found.ended:
            end = np.flatnonzero(some[:, 1] == Code.END)
            before = some[: end[0]] if end.size else some
            events += int(np.count_nonzero(before[:, 1] != Code.TIME))
        found.take(some, now)
        taken.append(found.due(now + 10, now))
        now += 10
    found.leave()
    assert came(found.counts) == events
    out = np.concatenate(taken) if taken else np.empty((0, 2), dtype=np.int64)
    assert (np.diff(out[:, 0]) >= 0).all()
    assert (out[:, 1] < 10).all()
