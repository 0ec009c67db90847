"""A wave while its temperature moves: what is left of a delay goes on at the new temperature's pace.

An axon's ramp has come some share of its way when the temperature moves, and the rest takes as long as it
does there: an axon of a cell that fired at t_i ends when

    int_(t_i) dt / D(T(t)) = 1

Axons are first come, first served at any temperature, so that the wave is again one of fixed delays, those
from firing to end, which are known as soon as a cell has fired.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from chips.wavefront.axon_graph import AxonGraph
from chips.wavefront.kernel import Wave
from circuits.arrays import F64
from circuits.devices.source import Polyline
from circuits.silicon.course import Course


def course_of(line: Polyline) -> Course:
    """Return the course of times (s) and temperatures (degC), float64[T] each.

    Raises `ParameterError` where they are none.
    """
    return Course(tuple((float(t), float(c)) for t, c in zip(*line, strict=True)))


def wave_along(
    graph: AxonGraph, run: Callable[[F64], Wave], delays_at: Callable[[float], F64], course: Course,
    begin: float,
) -> Wave:  # fmt: skip
    """Return the wave that begins at `begin` (s) of a course of temperature.

    Parameters
    ----------
    graph
        Cells and axons.
    run
        The wave with a delay of each axon, s, float64[edges].
    delays_at
        These delays at a temperature, degC.
    course
        Temperature over time.
    begin
        When the first cell fires, s of the course.
    """
    source, pace = graph.sources(), delays_at(course.at(begin))
    whole, gone, last = pace, np.zeros(graph.edges), 0.0
    wave = run(whole)
    while (now := course.next_change(begin + last) - begin) < _end(wave):
        fired = wave.arrivals.ravel()[source]
        gone += np.maximum(now - np.maximum(fired, last), 0.0) / pace
        pace, last = delays_at(course.at(begin + now)), now
        ahead = np.maximum(now - fired, 0.0) + (1.0 - gone) * pace
        whole = np.where(gone < 1.0, ahead, whole)
        wave = run(whole)
    return wave


def _end(wave: Wave) -> float:
    """When the last cell fired, s."""
    return float(wave.arrivals[np.isfinite(wave.arrivals)].max(initial=0.0))
