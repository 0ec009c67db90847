"""Waveforms as polylines, and what is refused."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from circuits.devices.source import (
    Constant,
    Driven,
    PiecewiseLinear,
    Pulse,
    Sampled,
    Source,
    Waveform,
    polyline,
    vertices,
)
from circuits.errors import ParameterError
from tests.refusals import refusals


def test_constant_and_driven_are_one_vertex() -> None:
    for waveform in (Constant(1.8), Driven(1.8)):
        time, value = polyline("v", waveform)
        assert (time.tolist(), value.tolist()) == ([0.0], [1.8])


def test_sampled_vertices_lie_on_the_samples() -> None:
    time, value = polyline("v", Sampled(2e-3, 1e4, np.array([0.0, 1.0, 0.5])))
    np.testing.assert_allclose(time, [2e-3, 2.1e-3, 2.2e-3], rtol=1e-14)
    assert value.tolist() == [0.0, 1.0, 0.5]


def test_pulse_has_the_corners_of_its_trapezoid() -> None:
    time, value = polyline("v", Pulse(0.0, 5.0, (1e-3,), 10e-6, 1e-6, 2e-6))
    np.testing.assert_allclose(time, [0.0, 1e-3, 1.001e-3, 1.011e-3, 1.013e-3], rtol=1e-12)
    assert value.tolist() == [0.0, 0.0, 5.0, 5.0, 0.0]


def test_pulse_at_time_zero_and_back_to_back() -> None:
    time, value = polyline("v", Pulse(0.0, 1.0, (0.0, 4.0), 2.0, 1.0, 1.0))
    assert time.tolist() == [0.0, 1.0, 3.0, 4.0, 5.0, 7.0, 8.0]
    assert value.tolist() == [0.0, 1.0, 1.0, 0.0, 1.0, 1.0, 0.0]


def test_no_pulse_is_the_low_level() -> None:
    time, value = polyline("v", Pulse(0.3, 1.0, (), 2.0, 1.0, 1.0))
    assert (time.tolist(), value.tolist()) == ([0.0], [0.3])


EDGE = st.floats(min_value=1e-9, max_value=1e-3)


@given(
    gaps=st.lists(st.floats(min_value=1e-6, max_value=1.0), min_size=1, max_size=6),
    width=EDGE,
    rise=EDGE,
    fall=EDGE,
    low=st.floats(min_value=-5.0, max_value=5.0),
    high=st.floats(min_value=-5.0, max_value=5.0),
    backwards=st.booleans(),
)
def test_pulses_are_high_inside_and_low_outside(
    gaps: list[float], width: float, rise: float, fall: float, low: float, high: float, backwards: bool
) -> None:
    starts, now = [], 0.0
    for gap in gaps:
        starts.append(now + gap)
        now = starts[-1] + rise + width + fall
    order = tuple(reversed(starts)) if backwards else tuple(starts)
    time, value = polyline("v", Pulse(low, high, order, width, rise, fall))
    assert (np.diff(time) > 0.0).all()
    assert time.size == 1 + 4 * len(starts)
    middle = np.array(starts) + rise + 0.5 * width
    np.testing.assert_allclose(np.interp(middle, time, value), high, rtol=1e-12, atol=1e-12)
    before = np.array(starts) - 0.5 * np.array(gaps)
    np.testing.assert_allclose(np.interp(before, time, value), low, rtol=1e-12, atol=1e-12)
    half = np.interp(np.array(starts) + 0.5 * rise, time, value)
    # the edge's ends are rounded to 1e-16 of a time up to 6 s, the edge is 1 ns or longer
    np.testing.assert_allclose(half, 0.5 * (low + high), atol=1e-5 * (1.0 + abs(high - low)))


BAD: list[tuple[Waveform, str]] = [
    (Constant(math.nan), "not finite"),
    (Driven(math.inf), "not finite"),
    (Pulse(0.0, 1.0, (0.0,), 0.0, 1e-6, 1e-6), "must be > 0"),
    (Pulse(0.0, 1.0, (0.0,), 1e-6, -1e-6, 1e-6), "must be > 0"),
    (Pulse(0.0, 1.0, (1e-3, 1.001e-3), 1e-6, 1e-6, 1e-6), "begins before the one before has ended"),
    (Pulse(0.0, 1.0, (-1e-3,), 1e-6, 1e-6, 1e-6), "times must rise"),
    (Pulse(0.0, math.nan, (1e-3,), 1e-6, 1e-6, 1e-6), "not finite"),
    (PiecewiseLinear((), ()), "at least one"),
    (PiecewiseLinear((0.0, 1.0), (0.0,)), "equally many"),
    (PiecewiseLinear((0.0, 1.0, 1.0), (0.0, 1.0, 2.0)), "time 1 s after 1 s, times must rise"),
    (PiecewiseLinear((0.0, math.nan), (0.0, 1.0)), "not finite"),
    (Sampled(0.0, 0.0, np.zeros(3)), "rate 0 Hz, must be > 0"),
    (Sampled(0.0, 1e3, np.zeros(0)), "at least one"),
    (Sampled(0.0, 1e3, np.array([0.0, math.nan])), "not finite"),
]


test_bad_waveforms_name_the_source_and_the_rule = refusals(
    ParameterError,
    lambda waveform: Source("echo", "echo", waveform).check(),
    BAD,
    start="^echo: .*",
)


def test_vertices_take_lists_and_return_arrays() -> None:
    time, value = vertices("v", [0, 1], [2, 3])
    assert time.dtype == value.dtype == np.float64


def test_a_direct_value_is_a_number_beside_a_waveform_that_moves() -> None:
    ramp = PiecewiseLinear((0.0, 1.0), (0.0, 1.0))
    assert Source("v", "v", ramp, direct=2.0).direct == 2.0
    assert repr(Source("v", "v", ramp)).endswith("quantity='voltage')")  # hashes of older sources hold
    with pytest.raises(ParameterError, match="direct: nan, must be finite"):
        Source("v", "v", ramp, direct=math.nan)
    with pytest.raises(ParameterError, match="beside a constant; leave it out"):
        Source("v", "v", Constant(1.0), direct=2.0)
    with pytest.raises(ParameterError, match="1e\\+06 V, must be"):
        Source("v", "v", ramp, direct=1e6)
