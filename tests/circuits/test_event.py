"""An event's pulse as a source and as a polyline is one; the crossing is where the line says."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from chips.cell import add_pulse
from circuits.devices.source import Pulse
from circuits.event import (
    EDGE,
    HALF_WIDTH,
    LENGTH,
    WIDTH,
    falling_crossing,
    pulse,
    pulse_line,
    rising_crossing,
    sort_events,
)


def test_both_forms_are_one_pulse_of_10_us() -> None:
    time, volts = pulse_line(2e-3, 5.0)
    wave = pulse((2e-3,), 5.0)
    assert isinstance(wave, Pulse)
    assert (wave.width, wave.rise, wave.fall) == (WIDTH, EDGE, EDGE)
    assert time - 2e-3 == pytest.approx([0.0, EDGE, EDGE + WIDTH, LENGTH], abs=1e-15)
    assert np.array_equal(volts, [0.0, 5.0, 5.0, 0.0])
    rise, fall = rising_crossing(time, volts, 2.5), falling_crossing(time, volts, 2.5)
    assert rise is not None
    assert fall is not None
    assert fall - rise == pytest.approx(HALF_WIDTH, rel=1e-9) == pytest.approx(WIDTH + EDGE, rel=1e-15)


def test_a_cell_s_event_is_that_pulse() -> None:
    (time, volts), merged = add_pulse((np.zeros(1), np.zeros(1)), 1e-3, 5.0)
    expected, levels = pulse_line(1e-3, 5.0)
    assert merged == 0
    assert time[1:] == pytest.approx(expected, abs=1e-15)
    assert np.array_equal(volts[1:], levels)


def test_without_events_the_line_is_at_rest_and_nothing_crosses() -> None:
    assert not isinstance(pulse((), 5.0), Pulse)
    assert rising_crossing(np.array([0.0, 1.0]), np.zeros(2), 2.5) is None


@given(st.lists(st.integers(0, 9), max_size=30), st.integers(0, 30))
def test_events_are_sorted_by_time_and_those_of_one_time_stay_in_order(times: list[int], first: int) -> None:
    count = min(first, len(times))
    time, value = np.array(times, dtype=np.float64), np.arange(len(times))
    order = np.concatenate([np.argsort(time[:count], kind="stable"), np.arange(count, len(times))]).astype(
        int
    )
    expected = time[order]
    sort_events(time, value, count)
    assert value.tolist() == order.tolist()
    assert time.tolist() == expected.tolist()
