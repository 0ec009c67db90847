"""Closed forms against the integrals that they solve."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from chips.latency.law import evaluation_latency, race_latency

TIMES = st.lists(st.floats(0.0, 0.04), min_size=1, max_size=8)


@given(TIMES)
def test_the_charge_at_the_latency_is_the_threshold(times: list[float]) -> None:
    current = 125.0
    latency = evaluation_latency(times, current)
    # equal but for rounding: latencies of some 10 ms, a threshold of 1
    assert sum(current * max(latency - t, 0.0) for t in times) == pytest.approx(1.0, rel=1e-9)


@given(TIMES, st.floats(0.0, 0.03))
def test_one_more_input_never_comes_later(times: list[float], more: float) -> None:
    # rounding of latencies of some 10 ms
    assert evaluation_latency([*times, more], 125.0) <= evaluation_latency(times, 125.0) + 1e-15


def test_no_input_makes_no_spike() -> None:
    assert evaluation_latency([], 125.0) == math.inf


@given(st.lists(st.tuples(st.floats(0.0, 0.05), st.floats(0.1, 3.0)), max_size=5), st.floats(0.0, 0.3))
def test_the_race_reaches_its_threshold(inhibitions: list[tuple[float, float]], charge: float) -> None:
    passive = 20.0  # more than all inhibitions together
    latency = race_latency(passive, charge, inhibitions)
    reached = charge + passive * latency - sum(i * max(latency - t, 0.0) for t, i in inhibitions)
    assert reached == pytest.approx(1.0, rel=1e-9)


def test_too_much_inhibition_makes_no_spike_unless_it_comes_after() -> None:
    assert race_latency(20.0, 0.0, [(0.01, 25.0)]) == math.inf
    assert race_latency(20.0, 0.0, [(0.06, 25.0)]) == pytest.approx(0.05)
