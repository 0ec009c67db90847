"""Success in a user's words is read by a grammar, and held against metrics."""

import numpy as np
import pytest

from circuits.errors import CircuitError
from system.study.metrics.success import read_success
from tests.refusals import refusals

UNITS = {"collided": "", "distance_m": "m", "path_m": "m", "time_s": "s"}
VALUES = {
    "collided": np.array([0.0, 1.0, 0.0, np.nan]),
    "distance_m": np.array([25.0, 30.0, 10.0, 40.0]),
    "path_m": np.array([25.0, 40.0, 10.0, 40.0]),
    "time_s": np.array([1.0, 2.0, 3.0, 4.0]),
}


@pytest.mark.parametrize(
    ("text", "met"),
    [
        ("collided == 0 and distance_m >= 20", [True, False, False, False]),
        ("not collided", [True, False, True, False]),
        ("distance_m > 0.02km or time_s<=1", [True, True, False, True]),
        ("collided == 0 and (distance_m >= 20 or time_s >= 3)", [True, False, True, False]),
        ("collided == 0 and distance_m >= 20 or time_s >= 2", [True, True, True, False]),
        ("distance_m == path_m", [True, False, True, True]),
        ("30m <= distance_m", [False, True, False, True]),
        ("not (distance_m < 20m) and time_s != 2", [True, False, False, True]),
    ],
)
def test_a_text_is_met_where_its_metrics_say_so(text: str, met: list[bool]) -> None:
    wanted = read_success(text, UNITS)
    assert wanted.met(VALUES).tolist() == met
    assert set(wanted.metrics) <= set(UNITS)


def test_a_metric_that_is_not_defined_is_no_success_whatever_else_is() -> None:
    wanted = read_success("time_s > 0 or collided == 1", UNITS)
    assert wanted.met(VALUES).tolist() == [True, True, True, False]
    assert wanted.undefined(VALUES).tolist() == [False, False, False, True]


test_what_is_no_success_is_refused = refusals(
    CircuitError,
    lambda text: read_success(text, UNITS),
    [
        ("way >= 20", "metric way: unknown; known are"),
        ("distance >= 20", "metric distance: unknown; did you mean distance_m"),
        ("collided = 0", r'"collided = 0", column 10: =, must be otherwise; write as "collided == 0 and'),
        ("collided == 0 and", "column 18: the end"),
        ("3 < 4", "column 1: 3 beside 4, must compare a metric"),
        ("distance_m > time_s", "column 1: distance_m beside time_s, must be of one unit"),
        ("distance_m > 3s", "must be a length in m"),
        ("__import__('os')", r"column 11: \("),
        ("and", "column 1: and"),
        ("", "column 1: the end"),
        ("(" * 2000, "2000 characters, must be at most 1000"),
    ],
    start="success: .*",
)
