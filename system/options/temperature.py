"""Temperature of a run as the command line has it: one number, or a course of straight lines over time.

`44` is 44 degC throughout; `0s:27,60s:44,120s:44` rises from 27 to 44 degC within a minute, and stays. Before
the first time and after the last one the temperature is the nearest one's. A name that ends in `.csv` is that
of a file of such points.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from circuits.errors import DataError, ParameterError
from circuits.silicon.course import Course, Points
from circuits.silicon.process import check_temperature
from circuits.units import parse_quantity
from system.option import required
from system.rows import read_rows

OPTION = "temperature"
COURSE = "course"  # field of scenarios whose temperature may change


@dataclass(frozen=True, slots=True)
class _Row:
    """A row of a file of a course: the temperature at a time."""

    time: float = required("time since the run began", unit="s", name="time_s")
    celsius: float = required("temperature of the chips", unit="degC", name="temperature_C")


def read_course(text: str) -> float | Points:
    """Return a temperature (degC), or the points of a course: times (s) and temperatures (degC).

    Raises `ParameterError` for a text that is neither, `DataError` for a file that has none.
    """
    if text.lower().endswith(".csv"):
        return _of_file(text)
    if not is_course(text):
        celsius = parse_quantity(text, "degC", OPTION)
        check_temperature(celsius)
        return celsius
    points = []
    for pair in text.split(","):
        time, found, degree = pair.partition(":")
        if not found:
            raise ParameterError(
                f'{OPTION}: "{pair}", must be TIME:DEGC in a course; write as in 0s:27,60s:44'
            )
        seconds = parse_quantity(time.strip(), "s", OPTION)
        points.append((seconds, parse_quantity(degree.strip(), "degC", OPTION)))
    return Course(tuple(points)).points


def is_course(text: str) -> bool:
    """Whether a text is a course's, or names a file of one."""
    return ":" in text or text.lower().endswith(".csv")


def _of_file(path: str) -> Points:
    points = tuple((row.time, row.celsius) for _, row in read_rows(path, _Row))
    try:
        return Course(points).points
    except ParameterError as error:
        raise DataError(f"{path}: {error}") from error


def temperature_fields(found: float | Points) -> dict[str, Any]:
    """Return the fields of a scenario for a temperature (degC), or for the points of a course."""
    if not isinstance(found, tuple):
        return {"temperature_c": found}
    times, degrees = zip(*found, strict=True)
    return {"temperature_c": float(np.interp(0.0, times, degrees)), COURSE: found}


def temperature_text(temperature_c: float, course: Points = ()) -> str:
    """Return the temperature of a run without its unit, degC: `27`, or `27 to 44` for a course."""
    if not course:
        return f"{temperature_c:g}"
    degrees = [celsius for _, celsius in course]
    return f"{min(degrees):g} to {max(degrees):g}"
