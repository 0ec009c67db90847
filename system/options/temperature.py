"""Temperature of a run as the command line has it: one number, or a course of straight lines over time.

`44` is 44 degC throughout; `0s:27,60s:44,120s:44` rises from 27 to 44 degC within a minute, and stays. Before
the first time and after the last one the temperature is the nearest one's.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from circuits.devices.source import Polyline
from circuits.errors import ParameterError
from circuits.silicon.process import check_temperature
from circuits.units import parse_quantity

OPTION = "temperature"


def read_course(text: str) -> float | Polyline:
    """Temperature (degC), or times (s) and temperatures, float64[n] each; raises `ParameterError`."""
    if ":" not in text:
        celsius = parse_quantity(text, "degC", OPTION)
        check_temperature(celsius)
        return celsius
    times, degrees = [], []
    for pair in text.split(","):
        time, found, degree = pair.partition(":")
        if not found:
            raise ParameterError(
                f'{OPTION}: "{pair}", must be TIME:DEGC in a course; write as in 0s:27,60s:44'
            )
        times.append(parse_quantity(time.strip(), "s", OPTION))
        degrees.append(parse_quantity(degree.strip(), "degC", OPTION))
        check_temperature(degrees[-1])
    for before, after in pairwise(times):
        if not before < after:
            raise ParameterError(f"{OPTION}: {after:g} s after {before:g} s, times must rise; sort them")
    return np.array(times), np.array(degrees)
