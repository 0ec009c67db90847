"""Sweeps: operating points, or measures of a transient each, over sources, silicon and parameters.

What is named first runs innermost, as in SPICE's `.dc`: a source there is followed from point to point in one
compiled loop, and everything else is nested around it. All points are kept in one dataset.
"""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import groupby, product
from typing import TYPE_CHECKING, Any, Literal, final

import numpy as np

from circuits.arrays import F64
from circuits.errors import CircuitError, ParameterError
from circuits.lowering.kernel import Machine, on_die, to_kernel
from circuits.measure.measure import Measure, Reading, read_measures
from circuits.measure.scope import Scope, TableRecord, TransientRecord, scope_of
from circuits.measure.unit import unit_named
from circuits.silicon.silicon import Silicon
from circuits.solver.lanes.layout import structure_of
from circuits.solver.lanes.simulate import fits, simulate_each
from circuits.solver.sweep.continuation import with_source
from circuits.solver.transient import Result, simulate
from circuits.sweep.axis import Axis, Way, axes_of
from circuits.sweep.dataset import measures_dataset, points_dataset
from circuits.sweep.line import Line, Solve, joined, solve_line
from circuits.testbench import Testbench

if TYPE_CHECKING:
    import xarray as xr

Build = Callable[..., Testbench]
Progress = Callable[[float], None] | None


@dataclass(frozen=True, slots=True)
class Plan:
    """A sweep that is asked for.

    Attributes
    ----------
    build : makes the testbench of values of its parameters, by name.
    parameters : unit of each of them.
    over : what is swept, the innermost first.
    silicon : where it is swept, but for what is swept of it.
    start : voltages (V) by node path to start the first point from.
    way : `up` takes the innermost values as they are given, `down` from the last to the first, `both` one
        after the other.
    solve : what solves for operating points.
    turned : names of sources that the testbench has at minus the values that are swept, since the netlist
        that it was read from sees them from their other end.
    """

    build: Build
    parameters: Mapping[str, str]
    over: Mapping[str, Sequence[Any] | F64]
    silicon: Silicon
    start: Mapping[str, float] | None = None
    way: Way = "up"
    solve: Solve = solve_line
    turned: frozenset[str] = frozenset()

    def bench(self) -> Bench:
        """The testbench at any place of the sweep; raises `ParameterError` for what cannot be swept."""
        names = [name for name in self.over if name in self.parameters]
        first = {name: np.asarray(self.over[name]).ravel()[0] for name in names}
        return Bench(self, to_kernel(self.build(**first), self.silicon))


def sweep(
    target: Testbench | Build,
    over: Mapping[str, Sequence[Any] | F64],
    silicon: Silicon | None = None,
    *,
    measures: Sequence[str] = (),
    analysis: Literal["dc", "tran"] = "dc",
    way: Way = "up",
    start: Mapping[str, float] | None = None,
) -> xr.Dataset:
    """Sweep a testbench: operating points, or measures of a transient at each point.

    Parameters
    ----------
    target
        A testbench, or a function that makes one of its parameters.
    over
        Values, float64[N], by name, the innermost first: of a source (V or A), a bias port's included, of
        `temperature` (degC), of a parameter of the function; whole numbers of `die`, words of `corner`.
    silicon
        The nominal process at 27 degC unless given.
    measures
        Expressions (`circuits.measure`): of each curve over the innermost, or of each transient.
    analysis
        `dc` for operating points; `tran` for a transient at every point, of which the measures are kept.
    way
        `up` takes the innermost values as they are given, `down` the other way round, and `both` goes back
        from where the way up ends, so that hysteresis shows.
    start
        Voltages (V) by node path to start the first operating point from.

    Returns
    -------
    A dimension a name. Of operating points `voltage` (V, by `node`), `current` (A, by `device`, as
    `circuits.measure.current` has them) and `stable`; of measures a variable each, with `reason` where one
    has no value. Points without a solution are NaN, and `failures` among the attributes says which.

    Raises
    ------
    ParameterError
        A value or a measure breaks its rule.
    UnknownNameError
        There is nothing of a name to sweep.
    """
    if isinstance(target, Testbench):
        build, parameters = _constant(target), {}
    else:
        build, parameters = target, dict.fromkeys(inspect.signature(target).parameters, "")
    plan = Plan(build, parameters, over, silicon or Silicon(), start, way)
    return run_transients(plan, measures) if analysis == "tran" else run_points(plan, measures)


def _constant(bench: Testbench) -> Build:
    return lambda: bench


def run_points(plan: Plan, measures: Sequence[str] = ()) -> xr.Dataset:
    """Sweep operating points; measures are of each curve over the innermost."""
    bench = plan.bench()
    axes = bench.axes
    inner, outer = axes[0], axes[:0:-1]
    read = read_measures(measures, _curve_scope(bench.first, inner)) if measures else ()
    ways: tuple[Way, ...] = ("up", "down") if plan.way == "both" else (plan.way,)
    lines: list[Line] = []
    readings: list[list[Reading]] = []
    for place, near in _places(outer, lines, len(ways)):
        begin = near
        for way in ways:
            line = _line(bench, place, inner, way, begin)
            begin = line.ends[1]
            lines.append(line)
            readings.append([each.of(_record(bench, line, inner, way)) for each in read])
    found = points_dataset(axes, ways, bench.first, lines)
    if read:
        found = found.merge(measures_dataset(axes[1:], ways, read, readings))
    return _described(found, plan, lines)


def run_transients(plan: Plan, measures: Sequence[str], progress: Progress = None) -> xr.Dataset:
    """Sweep transients, and keep what is measured of each.

    progress: is called with the fraction that is done.
    """
    if not measures:
        raise ParameterError("measure: none, must be at least one of a transient; give one, or sweep dc")
    if plan.way != "up":
        raise ParameterError(f"way: {plan.way}, a transient at every point has none; leave it out")
    bench = plan.bench()
    axes = bench.axes
    read = read_measures(measures, scope_of(bench.first))
    places = [place for place, _ in _places(axes[::-1], [], 1)]
    readings = []
    for k, result in enumerate(_runs(bench.machine(place) for place in places)):
        readings.append(_readings(result, read))
        if progress is not None:
            progress((k + 1) / len(places))
    return _described(measures_dataset(axes, ("up",), read, readings), plan, [])


@final
class Bench:
    """The testbench of a sweep at any place of it; what stays the same over places is lowered once."""

    def __init__(self, plan: Plan, first: Machine) -> None:
        """Read what is swept; first: the machine at the first value of every parameter."""
        self._plan, self.first, self.axes = plan, first, axes_of(plan.over, first, plan.parameters)
        own = {axis.name: axis.values[0] for axis in self.axes if axis.kind == "parameter"}
        self._lowered: tuple[object, Machine] = _key(own, first.silicon.temperature_c), first
        self._made: tuple[object, Machine] | None = None

    def machine(self, place: Mapping[str, Any]) -> Machine:
        """The machine at a place, the first values standing for what the place does not name."""
        values = {axis.name: place.get(axis.name, axis.values[0]) for axis in self.axes}
        kinds = {axis.name: axis.kind for axis in self.axes}
        machine = self._on_silicon({n: v for n, v in values.items() if kinds[n] != "source"})
        for name, value in values.items():
            if kinds[name] == "source":
                given = self.sign(name) * float(value)
                machine = with_source(machine, machine.source_names.index(name), given)
        return machine

    def sign(self, source: str) -> float:
        """What a swept value is multiplied by for the testbench."""
        return -1.0 if source in self._plan.turned else 1.0

    def _on_silicon(self, values: Mapping[str, Any]) -> Machine:
        die_of = {"die": "number", "corner": "corner"}
        key = tuple(sorted(values.items()))
        if self._made is None or self._made[0] != key:
            lowered = self._lower({n: v for n, v in values.items() if n not in die_of})
            die = replace(self._plan.silicon.die, **{die_of[n]: v for n, v in values.items() if n in die_of})
            self._made = key, lowered if die == lowered.silicon.die else on_die(lowered, die)
        return self._made[1]

    def _lower(self, values: Mapping[str, Any]) -> Machine:
        own = {n: v for n, v in values.items() if n in self._plan.parameters}
        celsius = float(values.get("temperature", self._plan.silicon.temperature_c))
        key = _key(own, celsius)
        if self._lowered[0] != key:
            silicon = replace(self._plan.silicon, temperature_c=celsius)
            self._lowered = key, to_kernel(self._plan.build(**own), silicon)
        return self._lowered[1]

    def solve(self, machine: Machine, source: int | None, values: F64, near: F64 | None) -> Line:
        """Operating points of a machine along a source, or of the machine as it is."""
        return self._plan.solve(machine, source, values, near, self._plan.start)


def _key(own: Mapping[str, Any], celsius: float) -> object:
    """What decides a lowering: values of parameters, and the temperature."""
    return tuple(sorted(own.items())), celsius


def _places(
    outer: Sequence[Axis], lines: Sequence[Line], ways: int
) -> Iterator[tuple[dict[str, Any], F64 | None]]:
    """Every combination of the outer values, the last axis fastest, and the point to look near first.

    That is the first point of the line before, where nothing but sources has moved since: so neither a die
    nor anything else that is made anew depends on what was solved before it.
    """
    before: tuple[Any, ...] = ()
    for values in product(*(axis.values for axis in outer)):
        moved = [axis.kind for axis, a, b in zip(outer, values, before, strict=False) if a != b]
        near = lines[-ways].ends[0] if lines and set(moved) <= {"source"} else None
        before = values
        yield dict(zip((axis.name for axis in outer), values, strict=True)), near


def _line(bench: Bench, place: Mapping[str, Any], inner: Axis, way: Way, near: F64 | None) -> Line:
    """The points over the innermost axis, in the order in which they are visited."""
    values = inner.values[::-1] if way == "down" else inner.values
    if inner.kind == "source":
        machine = bench.machine(place)
        given = bench.sign(inner.name) * np.array(values, float)
        return bench.solve(machine, machine.source_names.index(inner.name), given, near)
    lines = []
    for value in values:
        lines.append(bench.solve(bench.machine({**place, inner.name: value}), None, np.zeros(1), near))
        near = lines[-1].ends[1] if inner.kind in {"temperature", "parameter"} else None
    return joined(lines)


def _curve_scope(machine: Machine, inner: Axis) -> Scope:
    """Names for measures of a curve; raises `ParameterError` where the innermost has no numbers in a unit."""
    if inner.kind in {"die", "corner"} or inner.unit not in {"V", "A", "degC", ""}:
        raise ParameterError(
            f"measure: over {inner.name} there is no curve; name a source or temperature first"
        )
    names = scope_of(machine)
    return Scope(names.nodes, names.currents, axis=unit_named(inner.unit))


def _record(bench: Bench, line: Line, inner: Axis, way: Way) -> TableRecord:
    values = inner.numbers[::-1] if way == "down" else inner.numbers
    return TableRecord(values, dict(zip(bench.first.names, line.voltage.T, strict=True)), line.currents)


def _runs(machines: Iterable[Machine]) -> Iterator[Result | Exception]:
    """What a run of each machine gives, or raises; those of one structure go together in lanes."""
    for structure, some in groupby(machines, lambda m: structure_of(m) if fits(m) else None):
        run_all = partial(map, _alone) if structure is None else simulate_each
        yield from run_all(some)


def _alone(machine: Machine) -> Result | Exception:
    try:
        return simulate(machine)
    except CircuitError as error:
        return error


def _readings(result: Result | Exception, read: Sequence[Measure]) -> list[Reading]:
    if isinstance(result, CircuitError):
        return [Reading(each.name, math.nan, each.unit, str(result)) for each in read]
    if isinstance(result, Exception):
        raise result
    record = TransientRecord(result)
    return [each.of(record) for each in read]


def _described(found: xr.Dataset, plan: Plan, lines: Sequence[Line]) -> xr.Dataset:
    silicon = plan.silicon
    return found.assign_attrs(
        {
            "process": silicon.process.name,
            "temperature_C": silicon.temperature_c,
            "die": str(silicon.die),
            "failures": [line.failure for line in lines if line.failure],
        }
    )
