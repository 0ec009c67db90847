"""The bus, and events as arrays."""

from __future__ import annotations

import numpy as np
import pytest

from system.dvs_event import Events, frame, joined, read_out


def read(times: list[float], gap: float, depth: int, free: float = -np.inf) -> tuple[int, list[float], float]:
    time, kept, bus = np.array(times), np.zeros(len(times), dtype=np.bool_), np.array([free])
    lost = read_out(time, gap, depth, bus, kept)
    assert lost == (~kept).sum()
    return lost, time[kept].tolist(), float(bus[0])


def test_a_slow_stream_passes_unchanged() -> None:
    assert read([0.0, 1.0, 2.0], 0.5, 0) == (0, [0.0, 1.0, 2.0], 2.5)


def test_a_burst_waits_and_what_finds_no_room_is_lost() -> None:
    # one is read at once, four wait: five pass, a gap apart
    lost, times, free = read([0.0] * 12, 0.1, 4)
    assert lost == 7
    assert times == pytest.approx([0.0, 0.1, 0.2, 0.3, 0.4])
    assert free == pytest.approx(0.5)


def test_the_bus_remembers_what_waits() -> None:
    assert read([1.0], 0.1, 0, free=1.05)[0] == 1
    assert read([1.0], 0.1, 1, free=1.05)[1] == [1.05]


def test_more_than_the_bus_carries_is_cut_to_its_rate() -> None:
    # 1000 events/s over a bus of 250/s, for 4 s: the bus is never idle, and ends with its queue full
    lost, times, _ = read([k * 1e-3 for k in range(4000)], 4e-3, 10)
    assert len(times) == pytest.approx(1010, abs=2)
    assert lost + len(times) == 4000
    assert np.diff(times) == pytest.approx(4e-3, abs=1e-9)


def some() -> Events:
    return Events(
        np.array([0.1, 0.2, 0.3]),
        np.array([3, 3, 0]),
        np.array([1, 1, 2]),
        np.array([True, True, False]),
        lost=2,
    )


def test_events_join_and_are_chosen() -> None:
    both = joined([some(), some()])
    assert (len(both), both.lost) == (6, 4)
    assert both.where(both.on).time.tolist() == [0.1, 0.2, 0.1, 0.2]
    assert len(joined([])) == 0


def test_a_frame_counts_on_minus_off() -> None:
    image = frame(some(), 4, 3)
    assert image.shape == (3, 4)
    assert (image[1, 3], image[2, 0], image.sum()) == (2, -1, 1)
