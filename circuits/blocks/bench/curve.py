"""Curves of the bench: slow ramps of a voltage over time, and what is read off them.

A ramp has as many vertices as a laboratory's sweep has points: the solver stops at each of them, so that a
curve is known there however little moves. It is slow enough for displacement currents not to show.
"""

from __future__ import annotations

import numpy as np

from circuits.arrays import F64, Bools
from circuits.blocks.block import Stimulus, Values, lasting
from circuits.blocks.drive import Wave, driven
from circuits.circuit import Circuit
from circuits.devices.source import PiecewiseLinear
from circuits.errors import ParameterError
from circuits.event import rising_crossing
from circuits.silicon.silicon import Silicon
from circuits.solver.transient import Result
from circuits.testbench import Testbench

DIFFERENCE_POINTS = 240  # of a sweep of a difference: 2.5 mV apart at 0.3 V
LEAST = 1e-30  # A, of a current whose logarithm is taken: far below what any device leaks; ours


def ramp(begin: float, end: float, first: float, last: float, points: int) -> PiecewiseLinear:
    """A straight ramp with as many vertices as points.

    Parameters
    ----------
    begin, end
        When it begins and ends, s.
    first, last
        The level before and after it, V.
    points
        How many steps it has.
    """
    time, level = np.linspace(begin, end, points + 1), np.linspace(first, last, points + 1)
    return PiecewiseLinear(tuple(map(float, time)), tuple(map(float, level)))


def within_supply(name: str, v_dd: float, *levels: float) -> None:
    """Raise `ParameterError` for levels (V) of a sweep called `name` that leave ground or the supply, V."""
    for level in levels:
        if not 0.0 <= level <= v_dd:
            raise ParameterError(
                f"{name}: {level:g} V, must be within 0 V and the supply of {v_dd:g} V; sweep less far"
            )


def difference_knobs(span: float, drains: str) -> tuple[Stimulus, ...]:
    """Knobs of a `difference_sweep` to a difference of `span` (V), and what it calls its drains."""
    return (
        Stimulus("common", "V", 0.9, "mean of both gates"),
        Stimulus("span", "V", span, "largest difference of the gates"),
        Stimulus("out", "V", 1.2, f"of {drains} drains"),
        lasting(1.0, "length of the sweep"),
    )


def difference_sweep(
    title: str, drains: tuple[str, ...], circuit: Circuit, stimuli: Values, v_dd: float
) -> Testbench:
    """A sweep of v1 - v2 from -span to +span about `common`, with all drains at `out`.

    Raises `ParameterError` for a sweep that leaves the supply.

    Parameters
    ----------
    title
        Name of the testbench.
    drains
        Nodes that are held at `out`.
    circuit
        A circuit with ports v1 and v2, and the drains.
    stimuli
        Values of `difference_knobs`.
    v_dd
        The supply, V.
    """
    common, span, out, duration = (stimuli[name] or 0.0 for name in ("common", "span", "out", "duration"))
    low, high = common - 0.5 * span, common + 0.5 * span
    within_supply("span", v_dd, low, high)
    within_supply("out", v_dd, out)
    held: dict[str, Wave] = dict.fromkeys(drains, out)
    up, down = (ramp(0.0, duration, *ends, DIFFERENCE_POINTS) for ends in ((low, high), (high, low)))
    return Testbench(title, circuit, driven({"v1": up, "v2": down, **held}), duration)


def slope(x: F64, y: F64, chosen: Bools) -> float | None:
    """Slope of the best straight line through chosen points, in y's unit a unit of x; None below three.

    x, y: float64[T]; chosen: bool[T].
    """
    if int(chosen.sum()) < 3:
        return None
    return float(np.polyfit(x[chosen] - x[chosen].mean(), y[chosen], 1)[0])


def crossing(x: F64, y: F64, level: float) -> float | None:
    """The first x at which y passes a level, up or down; None where it never does.

    x, y: float64[T], in any order of x; level: in y's unit.
    """
    up, down = rising_crossing(x, y, level), rising_crossing(x, -y, -level)
    found = [each for each in (up, down) if each is not None]
    return min(found, key=lambda at: abs(at - x[0])) if found else None


def thermal_voltage(result: Result) -> float:
    """U_T of a run, V."""
    silicon: Silicon = result.machine.silicon
    return silicon.thermal_voltage


def log_ratio(one: F64, other: F64) -> F64:
    """Return ln(one / other) of two currents, A, of which each counts as `LEAST` at least."""
    return np.asarray(np.log(np.maximum(one, LEAST) / np.maximum(other, LEAST)))
