"""A course is followed in steps: at each moment within half a step of its straight lines."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from circuits.errors import ParameterError
from circuits.silicon.course import Course, beginning_of, course_through, when
from tests.refusals import refusals

WARMING = Course(((0.0, 27.0), (60.0, 44.0)))


def test_the_temperature_is_the_nearest_whole_step() -> None:
    assert [WARMING.at(t) for t in (-5.0, 0.0, 30.0, 60.0, 1e9)] == [27.0, 27.0, 35.5, 44.0, 44.0]
    # of 0.1 K in 60 s over 17 K: the first change half a step after the beginning
    assert WARMING.next_change(0.0) == pytest.approx(0.05 * 60.0 / 17.0)
    assert WARMING.next_change(60.0) == math.inf


@given(
    st.lists(st.floats(-40.0, 125.0), min_size=1, max_size=5),
    st.floats(-1.0, 6.0),
    st.sampled_from([0.1, 0.25]),
)
def test_it_is_within_half_a_step_of_the_lines(degrees: list[float], time: float, step: float) -> None:
    course = Course(tuple((float(k), celsius) for k, celsius in enumerate(degrees)), step)
    line = float(np.interp(time, np.arange(len(degrees)), degrees))
    # changes within 10 us are one, in which 165 K/s move by 1.7 mK
    assert abs(course.at(time) - line) <= 0.5 * step + 1.7e-3
    after = course.next_change(time)
    assert after > time
    if after < math.inf:
        assert course.at(np.nextafter(after, -math.inf)) == course.at(time)
        assert course.at(after) != course.at(time)


def test_stretches_leave_nothing_out() -> None:
    found = list(WARMING.stretches(10.0, 11.0))
    assert (found[0][0], found[-1][1]) == (10.0, 11.0)
    assert all(a[1] == b[0] and a[2] != b[2] for a, b in pairwise(found))


def test_a_step_is_one_change() -> None:
    course = Course(((0.0, 27.0), (1.0, 27.0), (1.000001, 47.0)))
    assert course.next_change(0.0) == pytest.approx(1.0, abs=1e-6)
    assert (course.at(0.999), course.at(1.00001)) == (27.0, 47.0)
    assert course.next_change(1.00001) == math.inf


def test_where_it_begins() -> None:
    points = ((-10.0, 20.0), (10.0, 30.0))
    assert (beginning_of(27.0, points), beginning_of(27.3, ())) == (25.0, 27.3)
    assert course_through(()) is None
    assert str(course_through(points)) == "20 at -10 s, 30 at 10 s"


def test_a_refusal_says_when() -> None:
    def refuse(celsius: float) -> None:
        if celsius > 30.0:
            raise ParameterError(f"chip.temperature: {celsius:g} degC{when()}, must be at most 30 degC")

    with pytest.raises(ParameterError, match=r"30.1 degC at 10.7647 s, must be"):
        WARMING.check(60.0, refuse)
    WARMING.check(10.0, refuse)
    with pytest.raises(ParameterError, match="40 degC, must be"):
        refuse(40.0)


test_what_is_no_course_is_refused = refusals(
    ParameterError,
    Course,
    [
        ((), "a course without points"),
        (((1.0, 27.0), (1.0, 30.0)), "times must rise"),
        (((0.0, 27.0), (math.inf, 30.0)), "must be at a finite time"),
        (((0.0, 270.0),), "270 degC"),
    ],
)
