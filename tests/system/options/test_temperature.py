"""A course comes from text, and what is none is refused."""

import numpy as np

from circuits.errors import ParameterError
from system.options.temperature import read_course
from tests.refusals import refusals


def test_a_number_and_a_course() -> None:
    assert read_course("44") == 44.0
    time, celsius = read_course("0s:27, 60s:44")
    assert time.tolist() == [0.0, 60.0]
    assert np.interp([-1.0, 30.0, 90.0], time, celsius).tolist() == [27.0, 35.5, 44.0]


test_what_is_no_course_is_refused = refusals(
    ParameterError,
    read_course,
    [
        ("0s:27,60s", r'temperature: "60s", must be TIME:DEGC in a course'),
        ("60s:27,0s:44", "temperature: 0 s after 60 s, times must rise"),
        ("0s:27,60s:200", "200 degC"),
        ("0s:27,60s:5V", "temperature"),
    ],
)
