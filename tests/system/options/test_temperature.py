"""A course comes from text or a file, and what is none is refused."""

from pathlib import Path

from circuits.errors import DataError, ParameterError
from system.options.temperature import read_course, temperature_fields, temperature_text
from tests.refusals import file_refusals, refusals


def test_a_number_and_a_course() -> None:
    assert read_course("44") == 44.0
    assert read_course("0s:27, 60s:44") == ((0.0, 27.0), (60.0, 44.0))


def test_a_course_of_a_file(tmp_path: Path) -> None:
    path = tmp_path / "afternoon.csv"
    path.write_text("time_s,temperature_C\n-10,20\n10,30\n")
    course = read_course(str(path))
    assert course == ((-10.0, 20.0), (10.0, 30.0))
    assert temperature_fields(course) == {"temperature_c": 25.0, "course": course}
    assert temperature_text(25.0, ((-10.0, 20.0), (10.0, 30.0))) == "20 to 30"


test_a_file_of_no_course_is_refused = file_refusals(
    DataError,
    "warm.csv",
    read_course,
    [
        ("time_s,celsius\n0,27\n", "celsius"),
        ("time_s,temperature_C\n0,27\n0,30\n", ": temperature: 0 s after 0 s, times must rise"),
        ("time_s,temperature_C\n0,270\n", "270"),
    ],
)


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
