"""The innermost of a sweep: operating points over one source, or at one place alone."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from circuits.arrays import F64, Bools
from circuits.errors import SolverError
from circuits.lowering.kernel import Machine
from circuits.measure.current import static_currents
from circuits.solver.operating_point import OperatingPoint, operating_point, solve_near
from circuits.solver.outcome import Outcome
from circuits.solver.sweep.continuation import are_stable, trace
from circuits.solver.sweep.direct_current import with_source


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
    if first is None:
        found, count = np.empty((0, machine.kernel.columns)), 0
    elif source is None:
        found, count = first.voltage[None], 1
    else:
        found, count = trace(machine, source, values, first.voltage)
    return _line(machine, found[:count], values, _failure(machine, source, values, count))


def _first(machine: Machine, near: F64 | None, start: Mapping[str, float] | None) -> OperatingPoint | None:
    if near is not None and near.size == machine.kernel.columns:
        found = solve_near(machine, near)
        if found is not None:
            return found
    try:
        return operating_point(machine, start=start)
    except SolverError:
        return None


def _failure(machine: Machine, source: int | None, values: F64, count: int) -> str:
    if count == values.size:
        return ""
    at = ""
    if source is not None:
        unit = "V" if machine.source_quantities[source] == "voltage" else "A"
        at = f".{machine.source_names[source]}: {values[count]:g} {unit}"
    return f"{machine.testbench.title}{at}: {Outcome.NO_OPERATING_POINT.value}"


def _line(machine: Machine, found: F64, values: F64, failure: str) -> Line:
    missing = values.size - len(found)
    voltage = np.pad(found[:, machine.column], ((0, missing), (0, 0)), constant_values=np.nan)
    currents = {
        name: np.pad(current, (0, missing), constant_values=np.nan)
        for name, current in static_currents(machine, found).items()
    }
    stable = np.pad(are_stable(machine, found), (0, missing), constant_values=False)
    ends = found[0] if len(found) else None, found[-1] if len(found) and not missing else None
    return Line(voltage, currents, stable, ends, failure)


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
