"""Bus: times by its recursion, drops counted, any order of hand-in; event files there and back."""

import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from chips.aer import ALIKE, IDLE, MAGIC, Bus, Events, read_events, send, send_on, write_events
from circuits.errors import DataError, ParameterError

events = st.lists(st.tuples(st.integers(0, 40), st.integers(0, 9)), max_size=60)


def _one_by_one(bus: Bus, ordered: list[tuple[float, int]]) -> tuple[list[float], list[int], int]:
    """The bus as a queue that is looked at when each event comes."""
    ends: list[float] = []
    times, addresses, dropped = [], [], 0
    for time, address in ordered:
        if sum(end > time for end in ends) >= bus.depth:
            dropped += 1
            continue
        ends.append(max([time, *ends[-1:]]) + bus.service)
        times.append(ends[-1])
        addresses.append(address)
    return times, addresses, dropped


@settings(deadline=None)  # the first call compiles
@given(events, st.sampled_from([0.0, 0.25, 1.0, 3.0]), st.integers(1, 4), st.randoms(use_true_random=False))
def test_bus_serves_in_order_and_counts_what_it_drops(
    listed: list[tuple[int, int]], service: float, depth: int, shuffle: object
) -> None:
    bus = Bus(service, depth)
    ordered = sorted((float(t), a) for t, a in listed)
    mixed = list(ordered)
    shuffle.shuffle(mixed)  # type: ignore[attr-defined]
    found = send(bus, np.array([t for t, _ in mixed]), np.array([a for _, a in mixed], dtype=np.int64))
    assert (found.times.tolist(), found.addresses.tolist(), found.dropped) == _one_by_one(bus, ordered)


def test_simultaneous_events_leave_one_after_another_lowest_address_first() -> None:
    found = send(Bus(0.5, 3), np.zeros(5), np.array([4, 1, 3, 0, 2]))
    assert found.times.tolist() == [0.5, 1.0, 1.5]
    assert found.addresses.tolist() == [0, 1, 2]
    assert found.dropped == 2


def test_ideal_bus_changes_nothing() -> None:
    found = send(Bus(0.0, 1), np.array([2.0, 1.0, 1.0]), np.array([5, 7, 6]))
    assert (found.times.tolist(), found.addresses.tolist(), found.dropped) == ([1.0, 1.0, 2.0], [6, 7, 5], 0)


def test_many_events_at_one_instant_leave_in_the_order_of_their_addresses() -> None:
    addresses = np.random.default_rng(0).permutation(3 * ALIKE)
    found = send(Bus(0.0, 1), np.zeros(addresses.size), addresses)
    np.testing.assert_array_equal(found.addresses, np.arange(addresses.size))


def test_impossible_buses_are_refused() -> None:
    for service in (-1.0, np.inf, np.nan):
        with pytest.raises(ParameterError, match=r"bus.service"):
            Bus(service)
    with pytest.raises(ParameterError, match=r"bus.depth: 0, must be >= 1"):
        Bus(1.0, 0)


@given(st.lists(st.tuples(st.integers(0, 2**40), st.integers(0, 2**40))))
def test_event_file_there_and_back(rows: list[tuple[int, int]]) -> None:
    rows.sort()
    times, addresses = (np.array([row[k] for row in rows], dtype=np.int64) for k in (0, 1))
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "events"
        write_events(path, Events(times * 1e-6, addresses))
        assert path.stat().st_size == 8 + 16 * len(rows)
        found = read_events(path)
    assert np.rint(found.times / 1e-6).astype(np.int64).tolist() == times.tolist()
    assert found.addresses.tolist() == addresses.tolist()


def test_layout_is_little_endian_pairs(tmp_path: Path) -> None:
    write_events(tmp_path / "e", Events(np.array([3e-6]), np.array([258])))
    assert (tmp_path / "e").read_bytes() == b"NOCTAER1" + bytes([3, *[0] * 7, 2, 1, *[0] * 6])


def test_wrong_files_are_refused_with_file_and_event(tmp_path: Path) -> None:
    path = tmp_path / "e"
    path.write_bytes(b"something")
    with pytest.raises(DataError, match=r"e: no event file"):
        read_events(path)
    path.write_bytes(MAGIC + bytes(20))
    with pytest.raises(DataError, match=r"4 bytes after event 1"):
        read_events(path)
    path.write_bytes(MAGIC + np.array([5, 0, 4, 0], dtype="<i8").tobytes())
    with pytest.raises(DataError, match=r"event 1 at 4 us, must not be before the last, at 5 us"):
        read_events(path)
    with pytest.raises(ParameterError, match=r"events.times: inf s"):
        write_events(path, Events(np.array([np.inf]), np.array([0])))


def test_a_bus_that_is_sent_on_twice_is_one_bus() -> None:
    draw = np.random.default_rng(0)
    times, addresses = np.sort(draw.uniform(0.0, 1e-3, 300)), draw.integers(0, 9, 300)
    bus = Bus(service=5e-6, depth=20)
    whole = send(bus, times, addresses)
    line, found = IDLE, []
    for part in np.array_split(np.arange(300), 17):
        events, line = send_on(bus, line, times[part], addresses[part])
        found.append(events)
    np.testing.assert_array_equal(np.concatenate([e.times for e in found]), whole.times)
    np.testing.assert_array_equal(np.concatenate([e.addresses for e in found]), whole.addresses)
    assert sum(e.dropped for e in found) == whole.dropped > 0
