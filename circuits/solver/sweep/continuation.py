"""A branch of operating points followed over the values of one source, in one compiled loop.

From a point the next is predicted along the last two, and Newton's method corrects it. Where the correction
is more than a tenth of a volt (ours) the step is halved: so a branch is followed through the steepest part of
an amplifier's curve, and is not left for another one where both are there. A branch that ends (a fold, as at
the switching of a latch) is left by the circuit's own dynamics, as on a bench.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from circuits.arrays import F64, Bools
from circuits.compiled import compiled
from circuits.devices.source import vertices
from circuits.errors import SolverError
from circuits.lowering.factor import factor_and_solve
from circuits.lowering.kernel import Kernel, Machine
from circuits.solver.modes import ROUNDING, all_natural_rates, without_charges
from circuits.solver.newton import Work, allocate, evaluate, fill_jacobian, set_base
from circuits.solver.operating_point import FAR, operating_point, put, rest_state, settled, write_dense

_ITERATIONS = 12
_LAST_UPDATE = 1e-9  # V, of a solve that has converged, as of an operating point
_REMAINING = 1e-12  # V, what quadratic convergence may leave where the last update was larger
_FIRST = 1.0  # V, largest update of the prediction
_STRAYED = 0.1  # V, ours: correction beyond the tangent above which a step is halved
_LEAST = 2.0**-24  # share of the distance between two points below which a branch has ended; ours


def trace(machine: Machine, position: int, values: F64, v: F64 | None) -> F64:
    """Follow a branch over the values of a source.

    Where the branch ends and the dynamics lead to no rest state, one is looked for anew, and the branch that
    it is on is followed.

    Parameters
    ----------
    machine
        The circuit.
    position
        Number of the source.
    values
        Values of the source, float64[N], V or A.
    v
        An operating point of the circuit at the first value, float64[columns], V; not changed. None where
        none is known.

    Returns
    -------
    The vectors of voltages, float64[N, columns], V; NaN where there is no operating point.
    """
    k = machine.kernel
    found, w, column = np.empty((values.size, k.columns)), allocate(k), k.unknowns + position
    count = 0
    while count < values.size:
        if v is None:
            v = _anew(machine, position, float(values[count]))
        if v is None:
            found[count] = np.nan
            count += 1
        else:
            count += int(_follow(k, v.copy(), column, values[count:], w, found[count:]))
            v = None
    return found


def _anew(machine: Machine, position: int, value: float) -> F64 | None:
    """An operating point at a value of a source that no branch leads to; None where there is none."""
    try:
        return operating_point(with_source(machine, position, value)).voltage
    except SolverError:
        return None


def with_source(machine: Machine, position: int, value: float) -> Machine:
    """Hold one source of a machine, by its number, at a value, V or A."""
    lines = list(machine.polylines)
    lines[position] = vertices(machine.source_names[position], (0.0,), (value,))
    direct = (*machine.direct[:position], None, *machine.direct[position + 1 :])
    return replace(machine, polylines=tuple(lines), direct=direct)


def are_stable(machine: Machine, v: F64) -> Bools:
    """Say whether operating points are stable, bool[N]; v: their vectors of voltages, float64[N, columns]."""
    k = machine.kernel
    if not k.unknowns:
        return np.ones(len(v), np.bool_)
    conductance = np.empty((len(v), k.unknowns, k.unknowns))
    _conductances(k, v, allocate(k), conductance)
    charge = np.zeros((k.unknowns, k.unknowns))
    rows = np.repeat(np.arange(k.unknowns), np.diff(k.charge.start))
    inside = k.charge.entry >= 0
    charge[rows[inside], k.charge.column[inside]] = k.charge.value[inside]
    rates = all_natural_rates(*without_charges(k.charges, conductance, charge))
    return np.asarray((rates.real <= ROUNDING * np.abs(rates).max(axis=1, initial=0.0)[:, None]).all(axis=1))


@compiled()
def _correct(k: Kernel, v: F64, w: Work) -> float:
    """Newton's method in place; how far it went after its first update, V, or -1 where it fails."""
    strayed = 0.0
    for iteration in range(_ITERATIONS):
        evaluate(k, v, w)
        fill_jacobian(k, w)
        factor_and_solve(k.factor, w.jacobian, w.residual)
        largest = 0.0
        for i in range(k.unknowns):
            update = w.residual[i]
            if not abs(update) < _FIRST:
                return -1.0
            v[i] -= update
            if abs(v[i]) > FAR:
                return -1.0
            largest = max(largest, abs(update))
        if iteration > 0:
            strayed += largest
        if largest < _LAST_UPDATE or largest * largest < _REMAINING * k.curvature:
            return strayed
    return -1.0


@compiled()
def _predict(k: Kernel, v: F64, old: F64, column: int, goal: float, trial: F64) -> float:
    """Extrapolate from the last two points to a goal of the source; how far, in their distance."""
    behind = v[column] - old[column]
    share = (goal - v[column]) / behind if behind != 0.0 else 0.0
    for i in range(k.columns):
        trial[i] = v[i] + share * (v[i] - old[i]) if i < k.unknowns else v[i]
    trial[column] = goal
    return share


@compiled(_nrt=True)
def _land(k: Kernel, v: F64, w: Work) -> bool:
    """From where a branch ends to a rest state beyond, in place."""
    matrix, start = np.zeros((k.unknowns, k.unknowns)), v.copy()
    landed = settled(k, v, w, np.zeros_like(v), matrix)
    if not landed:
        put(v, start)
        landed = rest_state(k, v, w, matrix, 10.0 ** -np.arange(3.0, 20.0))
    set_base(k, 0.0, w)
    return landed


@compiled(_nrt=True)
def _follow(k: Kernel, v: F64, column: int, values: F64, w: Work, found: F64) -> int:
    """Fill in `found`, a row a value, from the point v at the first value; returns how many there are."""
    old, trial = v.copy(), v.copy()
    set_base(k, 0.0, w)
    for p in range(values.size):
        whole = values[p] - v[column]
        step = whole
        while v[column] != values[p]:
            goal = values[p] if abs(step) >= abs(values[p] - v[column]) else v[column] + step
            share = _predict(k, v, old, column, goal, trial)
            if 0.0 <= _correct(k, trial, w) <= _STRAYED:
                for i in range(k.columns):
                    old[i], v[i] = v[i], trial[i]
                step *= 2.0
            elif abs(step) > _LEAST * abs(whole):
                step *= 0.5
                if abs(share) > 1.0:
                    old[column] = v[column]  # a prediction that far fails: the tangent is tried
            else:
                v[column] = values[p]
                if not _land(k, v, w):
                    return p
                put(old, v)
        put(found[p], v)
    return values.size


@compiled()
def _conductances(k: Kernel, v: F64, w: Work, out: F64) -> None:
    """Jacobian of the direct currents at each point, float64[N, unknowns, unknowns], S."""
    set_base(k, 0.0, w)
    for p in range(v.shape[0]):
        evaluate(k, v[p], w)
        fill_jacobian(k, w)
        write_dense(k, w, out[p])
