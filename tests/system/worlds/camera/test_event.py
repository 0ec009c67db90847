"""The bus, and events as arrays."""

from __future__ import annotations

import numpy as np
import pytest

from system.worlds.camera.event import Bus, Events, frame, in_order, joined, read_out


def read(times: list[float], gap: float, depth: int, free: float = -np.inf) -> tuple[int, list[float], float]:
    codes, bus = np.arange(len(times)), np.array([free])
    events = read_out(Bus(gap, depth), 4, np.array(times), codes, bus)
    assert len(events) + events.lost == len(times)
    assert events.time.size == events.x.size == events.y.size == events.on.size
    return events.lost, events.time.tolist(), float(bus[0])


def test_codes_become_columns_rows_and_polarities() -> None:
    codes = np.array([(3 * 5 + 4) * 2 + 1, 0, (7 * 5) * 2])
    events = read_out(Bus(0.0, 0), 5, np.array([0.0, 1.0, 2.0]), codes, np.array([-np.inf]))
    assert list(zip(events.x, events.y, events.on, strict=True)) == [
        (3, 4, True),
        (0, 0, False),
        (7, 0, False),
    ]


def test_what_the_bus_loses_is_gone_from_its_place() -> None:
    codes = 2 * np.arange(6)
    events = read_out(Bus(0.1, 1), 8, np.array([0.0, 0.0, 0.0, 0.0, 1.0, 2.0]), codes, np.array([-np.inf]))
    assert events.y.tolist() == [0, 1, 4, 5]  # one is read at once, one waits, two are lost
    assert events.lost == 2


@pytest.mark.parametrize(
    "shape", ["even", "ties", "bursts", "one instant", "crowd and outlier", "ordered", "one", "none"]
)
def test_events_are_put_in_order_as_a_stable_sort_does(shape: str) -> None:
    random = np.random.default_rng(4)
    times = {
        "even": random.uniform(0.3, 0.35, 5000),
        "ties": random.integers(0, 50, 5000) / 200.0,
        "bursts": np.concatenate([0.01 * k + random.uniform(0.0, 1e-5, 100) for k in range(9, -1, -1)]),
        "one instant": np.full(40, 2.5),
        "crowd and outlier": np.concatenate([random.uniform(0.0, 1e-6, 4000), [9.0]]),
        "ordered": np.sort(random.uniform(-1.0, 1.0, 300)),
        "one": np.array([0.7]),
        "none": np.empty(0),
    }[shape]
    codes = np.arange(times.size)
    order = np.argsort(times, kind="stable")
    sorted_times, sorted_codes = in_order(times, codes)
    assert np.array_equal(sorted_times, times[order])
    assert np.array_equal(sorted_codes, codes[order])


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
