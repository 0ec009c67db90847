"""Specifications are read with their units, and every sample that does not pass has its cause."""

import math

import numpy as np
import pytest

from circuits.errors import ParameterError, UnknownNameError
from system.study.specification import Classes, Limits, judge, parse_spec
from system.study.table import FAILED
from tests.refusals import refusals

METRICS = {"best_delay": "s", "width": "s", "spikes_per_echo": ""}
CLASSES = ("works", "echo-alone", "call-alone")


@pytest.mark.parametrize(
    ("text", "low", "high"),
    [
        ("best_delay in 5.9ms:6.8ms", 5.9e-3, 6.8e-3),
        ("  best-delay   in 5.9m : 6.8e-3s ", 5.9e-3, 6.8e-3),
        ("best_delay in 5.9ms:", 5.9e-3, math.inf),
        ("best_delay in :6.8ms", -math.inf, 6.8e-3),
        ("best_delay in -1ms:1ms", -1e-3, 1e-3),
    ],
)
def test_limits(text: str, low: float, high: float) -> None:
    found = parse_spec(text, METRICS)
    assert found == Limits("best_delay", low, high, "s")
    assert parse_spec(str(found), METRICS) == found


def test_a_plain_number() -> None:
    assert parse_spec("spikes_per_echo in 1:2", METRICS) == Limits("spikes_per_echo", 1.0, 2.0, "")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("class is works", ("works",)),
        ("class in works|echo-alone", ("works", "echo-alone")),
        ("class in works | works", ("works",)),
    ],
)
def test_classes(text: str, words: tuple[str, ...]) -> None:
    found = parse_spec(text, METRICS, CLASSES)
    assert found == Classes(words)
    assert parse_spec(str(found), METRICS) == found


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("best_delay", "must be METRIC in LOW:HIGH"),
        ("best_delay < 6ms", "must be METRIC in LOW:HIGH"),
        ("best_delay in 6ms", "must be best_delay in LOW:HIGH"),
        ("best_delay is 6ms:7ms", "must be best_delay in LOW:HIGH"),
        ("best_delay in 1:2:3", "must be best_delay in LOW:HIGH"),
        ("best_delay<6ms", 'write "best_delay in :6ms"'),
        ("best_delay >= 6ms", 'write "best_delay in 6ms:"'),
        ("best_delay in :", "must have a limit"),
        ("best_delay in 5V:6V", "best_delay: .*must be a time in s"),
        ("best_delay in 6.8ms:5.9ms", "must have low <= high; write best_delay in 5.9ms:6.8ms"),
        ("class is ", "must have a word on each side"),
        ("class in works|", "must have a word on each side"),
    ],
)
def test_another_form_is_refused(text: str, message: str) -> None:
    with pytest.raises(ParameterError, match=f"^spec: .*{message}") as caught:
        parse_spec(text, METRICS)
    assert "\n" not in str(caught.value)


test_an_unknown_name_is_refused = refusals(
    UnknownNameError,
    lambda text: parse_spec(text, METRICS, CLASSES),
    [
        ("best_dely in 1ms:", "spec: metric best_dely: unknown; did you mean best_delay"),
        ("class is work", "spec: class work: unknown; did you mean works"),
    ],
)


def test_every_sample_has_its_first_cause() -> None:
    specs = [parse_spec("best_delay in 5.9ms:6.8ms", METRICS), parse_spec("class is works", METRICS)]
    outcomes = ["works", "works", "works", "works", "works", "call-alone", "call-alone", FAILED]
    delay = np.array([5.9e-3, 6.8e-3, 5.8e-3, 6.9e-3, np.nan, 6e-3, np.nan, np.nan])
    verdict = judge(specs, outcomes, {"best_delay": delay})
    assert verdict.causes == (
        "",
        "",
        "best_delay below 5.9ms",
        "best_delay above 6.8ms",
        "best_delay not defined",
        "class call-alone",
        "best_delay not defined",
        "failed",
    )
    assert verdict.passed.tolist() == [True, True, False, False, False, False, False, False]
    assert verdict.counts == {
        "best_delay not defined": 2,
        "best_delay above 6.8ms": 1,
        "best_delay below 5.9ms": 1,
        "class call-alone": 1,
        "failed": 1,
    }
    assert next(iter(verdict.counts)) == "best_delay not defined"
    assert verdict.passed.sum() + sum(verdict.counts.values()) == len(outcomes)


def test_a_failed_sample_fails_whatever_its_value() -> None:
    spec = parse_spec("best_delay in 0s:1s", METRICS)
    assert judge([spec], [FAILED], {"best_delay": np.array([0.5])}).counts == {"failed": 1}
    assert judge([], [FAILED, "works"], {}).passed.tolist() == [False, True]


def test_no_samples() -> None:
    verdict = judge([parse_spec("class is works", METRICS)], [], {})
    assert verdict.passed.size == 0
    assert verdict.counts == {}
