"""Thinning keeps a polyline within its tolerance."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from chips.polyline import thin


@settings(deadline=None)  # the first example compiles
@given(
    st.lists(st.floats(-5.0, 5.0), min_size=2, max_size=60),
    st.floats(1e-4, 1.0),
    st.integers(0, 2**32 - 1),
)
def test_left_out_vertices_stay_within_the_tolerance(values: list[float], tolerance: float, key: int) -> None:
    step = np.random.Generator(np.random.Philox(key)).uniform(1e-6, 1e-3, len(values))
    time, value = np.cumsum(step), np.array(values)
    kept_time, kept_value = thin(time, value, tolerance)
    assert kept_time[0] == time[0]
    assert kept_time[-1] == time[-1]
    # 1e-9 V for the rounding of slopes
    assert np.abs(np.interp(time, kept_time, kept_value) - value).max() <= tolerance + 1e-9


def test_a_straight_line_keeps_its_ends() -> None:
    time = np.linspace(0.0, 1.0, 101)
    kept_time, _ = thin(time, 3.0 * time, 1e-6)
    assert kept_time.tolist() == [0.0, 1.0]


def test_a_corner_is_kept() -> None:
    time = np.linspace(0.0, 1.0, 101)
    kept_time, _ = thin(time, np.maximum(time - 0.5, 0.0), 1e-9)
    assert kept_time.tolist() == [0.0, 0.5, 1.0]
