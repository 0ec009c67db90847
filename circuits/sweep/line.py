"""The innermost of a sweep: operating points over one source, or at one place alone."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from circuits.arrays import F64, Bools
from circuits.errors import SolverError
from circuits.lowering.kernel import Machine
from circuits.measure.current import current_names, static_currents
from circuits.solver.operating_point import OperatingPoint, operating_point, solve_near
from circuits.solver.outcome import Outcome
from circuits.solver.sweep.continuation import are_stable, trace, with_source


@dataclass(frozen=True, slots=True, eq=False)
class Line:
    """Operating points along a source, in the order in which they were found; NaN where there are none.

    Attributes
    ----------
    voltage : float64[N, nodes], V, in the order of the machine's names.
    currents : float64[N] by name, A.
    stable : bool[N].
    ends : vectors of voltages of the first and the last point, float64[columns], V; None where there is none.
    failure : what was not found; empty where all was.
    """

    voltage: F64
    currents: Mapping[str, F64]
    stable: Bools
    ends: tuple[F64 | None, F64 | None] = field(default=(None, None), repr=False)
    failure: str = ""


# of a machine, the number of the source that is swept, None for the machine as it is, its values, the vector
# of voltages near which the first point is looked for, and voltages by node that the user gives for it
Solve = Callable[[Machine, int | None, F64, F64 | None, Mapping[str, float] | None], Line]


def solve_line(
    machine: Machine, source: int | None, values: F64, near: F64 | None, start: Mapping[str, float] | None
) -> Line:
    """Solve for operating points along a source with the native solver; parameters as of `Solve`."""
    here = machine if source is None else with_source(machine, source, float(values[0]))
    first = _first(here, near, start)
    v = None if first is None else first.voltage
    if source is not None:
        found = trace(machine, source, values, v)
    else:
        found = np.full((1, machine.kernel.columns), np.nan) if v is None else v[None]
    return _line(machine, source, values, found)


def _first(machine: Machine, near: F64 | None, start: Mapping[str, float] | None) -> OperatingPoint | None:
    if near is not None and near.size == machine.kernel.columns:
        found = solve_near(machine, near)
        if found is not None:
            return found
    try:
        return operating_point(machine, start=start)
    except SolverError:
        return None


def _failure(machine: Machine, source: int | None, missing: F64) -> str:
    """What has no operating point: the first of the values of the source, and how many more."""
    at = machine.testbench.title
    if source is not None:
        unit = "V" if machine.source_quantities[source] == "voltage" else "A"
        more = f" and {missing.size - 1} more" if missing.size > 1 else ""
        at += f".{machine.source_names[source]}: {missing[0]:g} {unit}{more}"
    return f"{at}: {Outcome.NO_OPERATING_POINT.value}"


def _line(machine: Machine, source: int | None, values: F64, found: F64) -> Line:
    solved: Bools = np.asarray(np.isfinite(found).all(axis=1))
    there = found[solved]
    currents = {name: np.full(len(found), np.nan) for name in current_names(machine)}
    for name, current in static_currents(machine, there).items():
        currents[name][solved] = current
    stable = np.zeros(len(found), np.bool_)
    stable[solved] = are_stable(machine, there)
    failure = "" if solved.all() else _failure(machine, source, values[~solved])
    ends = (found[k] if solved[k] else None for k in (0, -1))
    return Line(found[:, machine.column], currents, stable, (next(ends), next(ends)), failure)


def joined(lines: Sequence[Line]) -> Line:
    """Lines one after the other as one."""
    failures = tuple(line.failure for line in lines if line.failure)
    return Line(
        np.concatenate([line.voltage for line in lines]),
        {name: np.concatenate([line.currents[name] for line in lines]) for name in lines[0].currents},
        np.concatenate([line.stable for line in lines]),
        (lines[0].ends[0], lines[-1].ends[1]),
        "; ".join(failures),
    )
