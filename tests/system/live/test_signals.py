"""Observations and actions: what is of their kind passes, what is not is refused by its number and name."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from circuits.errors import ParameterError
from system.live.signals import Channel, Signals, gathered, padded

STEER = Signals((Channel("speed", "m/s", 0.0, 0.3), Channel("turns", "rad/s", -2.0, 2.0, (2,))))
CHOICE = Signals((Channel("arc", "", 0, 32), Channel("head", "", 0, 4)), "whole")
PICTURE = Signals((Channel("events", "", 0, 255, (2, 3)),), "frame")


def test_an_array_of_the_signals_is_taken_as_it_is() -> None:
    assert STEER.checked([0.3, -2.0, 0.0], "a").tolist() == [0.3, -2.0, 0.0]
    whole = CHOICE.checked([32.0, 0], "a")
    assert whole.dtype == np.int64
    assert whole.tolist() == [32, 0]
    assert PICTURE.checked(np.full((2, 3), 255), "a").dtype == np.uint8
    assert Signals((Channel("turn", "rad/s", -1.0, 1.0),)).checked(0.5, "a").shape == (1,)


@pytest.mark.parametrize(
    ("signals", "value", "told"),
    [
        (STEER, [0.3, 2.5, 0.0], r"^run\.action\[1\] \(turns\): 2\.5 rad/s, must be a number from -2 to 2$"),
        (STEER, [np.nan, 0.0, 0.0], r"\[0\] \(speed\): nan m/s"),
        (STEER, [0.1, 0.0], r"shape \(2,\), must be \(3,\)$"),
        (STEER, "left", r"'left', must be 3 numbers$"),
        (STEER, [0.1 + 2.0j, 0.0, 0.0], r"must be 3 numbers$"),
        (STEER, ["1", "0", "0"], r"must be 3 numbers$"),
        (CHOICE, [33, 0], r"\[0\] \(arc\): 33, must be a whole number from 0 to 32$"),
        (CHOICE, [1.5, 0], r"\[0\] \(arc\): 1\.5, must be a whole number"),
        (PICTURE, np.full((2, 3), 256), r"\[0\] \(events\): 256"),
    ],
)
def test_what_is_not_of_the_signals_is_refused_by_its_number_and_name(
    signals: Signals, value: object, told: str
) -> None:
    with pytest.raises(ParameterError, match=told):
        signals.checked(value, "run.action")  # type: ignore[arg-type]


@given(st.lists(st.floats(0.0, 1.0), min_size=3, max_size=3))
def test_every_array_within_the_bounds_passes(shares: list[float]) -> None:
    value = STEER.low + np.array(shares) * (STEER.high - STEER.low)
    assert np.array_equal(STEER.checked(value, "a"), value)


def test_the_table_counts_on_over_channels_of_several_numbers() -> None:
    assert [row[0] for row in STEER.table()] == ["0", "1..2"]


def test_rows_are_filled_up_and_cut_off() -> None:
    rows = np.array([[1.0, 2.0], [3.0, 4.0]])
    assert padded(rows, 3, 0.0).tolist() == [[1.0, 2.0], [3.0, 4.0], [0.0, 0.0]]
    assert padded(rows, 1, 0.0).tolist() == [[1.0, 2.0]]
    assert gathered(1, [2.0, 3.0], rows.T).tolist() == [1, 2, 3, 1, 3, 2, 4]
