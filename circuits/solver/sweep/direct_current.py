"""Direct-current sweep: operating points over the values of one source, each continued from the last.

So the sweep of a circuit with several rest states stays on one branch as far as the branch goes
(`circuits.solver.sweep.continuation`). Where it ends, the circuit's own dynamics lead to another one: a sweep
up and one down show hysteresis.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from circuits.arrays import F64, Bools
from circuits.errors import ParameterError, SolverError, unknown_name
from circuits.lowering.kernel import Machine, to_kernel
from circuits.silicon.silicon import Silicon
from circuits.solver.operating_point import OperatingPoint, operating_point
from circuits.solver.outcome import Outcome
from circuits.solver.sweep.continuation import are_stable, trace, with_source
from circuits.testbench import Testbench


@dataclass(frozen=True, slots=True)
class Sweep:
    """Operating points over the values of a source.

    Currents of transistors are those of `circuits.solver.power.drain_current`.

    Attributes
    ----------
    source : str
        Name of the source.
    values : array
        Its values, float64[N], V or A.
    voltage : array
        Voltages of the nodes, float64[N, nodes], V.
    stable : array
        Whether each operating point is stable, bool[N].
    nodes : tuple of str
        Paths of the nodes, in the order of `voltage`.
    machine : Machine
        The lowered testbench that was swept.
    """

    source: str
    values: F64
    voltage: F64 = field(repr=False)
    stable: Bools = field(repr=False)
    nodes: tuple[str, ...] = field(repr=False)
    machine: Machine = field(repr=False)

    def __getitem__(self, node: str) -> F64:
        """Voltage of a node over the sweep, float64[N], V."""
        try:
            return np.asarray(self.voltage[:, self.nodes.index(node)])
        except ValueError:
            raise unknown_name("node", node, self.nodes) from None


def dc_sweep(
    target: Testbench | Machine,
    source: str,
    values: Sequence[float] | F64,
    silicon: Silicon | None = None,
    start: Mapping[str, float] | None = None,
) -> Sweep:
    """Solve for the operating point at each of `values` (V or A) of the source called `source`.

    Parameters
    ----------
    target
        Testbench or lowered testbench; the other sources keep their values at time 0.
    source
        Name of one of its sources, a bias port's included.
    values
        float64[N], in the order in which they are visited.
    silicon
        The nominal process at 27 degC unless given; of no effect on a lowered testbench.
    start
        Voltages (V) by node path to start the first point from.

    Raises
    ------
    UnknownNameError
        If there is no such source.
    ParameterError
        If there are no values, or one is not finite.
    SolverError
        If a point has no solution; the text names the value.
    """
    machine = target if isinstance(target, Machine) else to_kernel(target, silicon)
    if source not in machine.source_names:
        raise unknown_name(f"{machine.testbench.title} source", source, machine.source_names)
    swept = np.asarray(values, dtype=np.float64).ravel()
    if swept.size == 0 or not np.isfinite(swept).all():
        raise ParameterError(f"{source}: values of a sweep must be numbers, at least one")
    position = machine.source_names.index(source)
    first = _first(with_source(machine, position, float(swept[0])), start)
    found = np.full((1, 1), np.nan) if first is None else trace(machine, position, swept, first.voltage)
    missing = np.isnan(found).any(axis=1)
    if missing.any():
        unit = "V" if machine.source_quantities[position] == "voltage" else "A"
        raise SolverError(
            f"{machine.testbench.title}.{source}: {swept[missing.argmax()]:g} {unit}, no operating point;"
            f" {Outcome.NO_OPERATING_POINT.value}, or sweep in smaller steps"
        )
    stable = are_stable(machine, found)
    return Sweep(source, swept, found[:, machine.column], stable, machine.names, machine)


def _first(machine: Machine, start: Mapping[str, float] | None) -> OperatingPoint | None:
    try:
        return operating_point(machine, start=start)
    except SolverError:
        return None
