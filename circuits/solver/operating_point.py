"""Operating point of a circuit: a true solution of `G v + i(v) = 0`, with no conductance left over.

Newton's method is tried from the start. Where it fails, a conductance to the start is added and taken away
decade by decade; where that fails too, the circuit's own dynamics are followed with growing steps (which can
lock onto a cycle), and Newton's method ends them. Last come larger strides, for nodes beyond 100 V. A circuit
can have several rest states. The one that is found is called stable or not by the eigenvalues of
`-C^-1 dI/dv`. Where a start was given, the state that is found without it is reported beside if it is
another one.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from circuits.arrays import F64
from circuits.compiled import compiled
from circuits.errors import SolverError
from circuits.lowering.kernel import Kernel, Machine, on_die, to_kernel
from circuits.silicon.die import NOMINAL
from circuits.silicon.silicon import Silicon
from circuits.solver.integrate import source_values
from circuits.solver.modes import ROUNDING, natural_rates, without_charges
from circuits.solver.newton import Work, allocate, evaluate, fill_jacobian, newton, set_base, store_charges
from circuits.solver.outcome import Outcome
from circuits.testbench import Testbench

DECADES = tuple(10.0**-k for k in range(3, 20))
TOLERANCE = 1e-9  # V, last update of a converged solve
_SAME_STATE = 1e-3  # V, closer states are one
GROWTH = 1.15  # of steps along the dynamics, slow enough that an unstable state is left; ours
NUDGE = 10e-3  # V, ours: how far beside an unstable state the circuit is let go
MAX_REST_UPDATE = 0.2  # V, of each node in one iteration
_ROUNDED = 64.0 * 2.0**-52  # of the currents at a node, what rounding leaves of their sum; ours
_HONOURED = 0.1  # V, ours: how far from a start the state may be before one is looked for with it held
FAR = 100.0  # V, where a solve has run away
_STRIDES = (2.0, 20.0, 200.0)  # V, of each node in one iteration, of a circuit that has no state within FAR


@dataclass(frozen=True, slots=True)
class OperatingPoint:
    """A rest state of a testbench; `point[path]` is the voltage of a node, V.

    machine: the testbench on its silicon. voltage: the voltage vector, float64[columns], V; `voltages` has it
    by name. stable: whether the circuit comes back to it by itself. others: other rest states that were met
    on the way.
    """

    machine: Machine
    voltage: F64
    stable: bool
    others: tuple[OperatingPoint, ...] = ()

    def __getitem__(self, node: str) -> float:
        """Voltage of the node at a path, V."""
        return float(self.voltage[self.machine.column_of(node)])

    def voltages(self) -> dict[str, float]:
        """Voltage of every node by path, V."""
        return {
            name: float(self.voltage[c])
            for name, c in zip(self.machine.names, self.machine.column, strict=True)
        }


@compiled()
def write_dense(k: Kernel, w: Work, matrix: F64) -> None:
    """Write the sparse Jacobian into a dense matrix, float64[unknowns, unknowns]."""
    f = k.factor
    for i in range(k.unknowns):
        for j in range(k.unknowns):
            matrix[i, j] = 0.0
    for i in range(k.unknowns):
        matrix[i, i] = w.jacobian[f.diagonal[i]]
        for p in range(f.lower_start[i], f.lower_start[i + 1]):
            matrix[f.lower_row[p], i] = w.jacobian[f.lower[p]]
        for p in range(f.upper_start[i], f.upper_start[i + 1]):
            matrix[i, f.upper_column[p]] = w.jacobian[f.upper[p]]


@compiled()
def linearised(k: Kernel, v: F64, w: Work, matrix: F64) -> None:
    """Fill `matrix`, float64[unknowns, unknowns], with the conductances (S) at the voltages v."""
    set_base(k, 0.0, w)
    evaluate(k, v, w)
    fill_jacobian(k, w)
    write_dense(k, w, matrix)


@compiled()
def put(vector: F64, values: F64) -> None:
    """Fill a vector with the values of another of its length.

    Of a slice that is assigned to, numba compiles the text of an error about its shape, which takes seconds.
    """
    for i in range(vector.size):
        vector[i] = values[i]


@compiled()
def _direct(
    k: Kernel, v: F64, anchor: F64, g: float, w: Work, matrix: F64, most: float, iterations: np.int64
) -> bool:
    """Newton on `G v + i(v) + g (v - anchor) = 0` by dense LU with pivoting and row scaling.

    most: largest move of a node in one iteration, V. iterations: an `int64`, since numba compiles a function
    anew for each literal that kernels call it with.
    """
    n, right = k.unknowns, w.rest[3, : k.unknowns]
    far = FAR / MAX_REST_UPDATE * most
    set_base(k, 0.0, w)
    for _ in range(iterations):
        evaluate(k, v, w)
        fill_jacobian(k, w)
        write_dense(k, w, matrix)
        for i in range(n):
            matrix[i, i] += g
            right[i] = w.residual[i] + g * (v[i] - anchor[i])
        _scale_rows(matrix, right)
        if not solve_dense(matrix, right):
            return False
        largest = 0.0
        for i in range(n):
            if not np.isfinite(right[i]):
                return False
            largest = max(largest, abs(right[i]))
        for i in range(n):
            v[i] -= min(max(right[i], -most), most)
            if abs(v[i]) > far:
                return False
        if largest < TOLERANCE:
            return True
    return False


@compiled()
def _scale_rows(matrix: F64, right: F64) -> None:
    """Divide each equation by its largest coefficient."""
    n = right.size
    for i in range(n):
        scale = 1e-300
        for j in range(n):
            scale = max(scale, abs(matrix[i, j]))
        right[i] /= scale
        for j in range(n):
            matrix[i, j] /= scale


@compiled()
def solve_dense(a: F64, b: F64) -> bool:  # noqa: C901 - Gaussian elimination as it is in every book
    """Solve `a x = b` in place by LU with partial pivoting; false where a pivot vanishes.

    a: float64[n, n], overwritten. b: float64[n], replaced by x. The solver of numpy raises an exception from
    compiled code, which would end a batch; this one reports.
    """
    n = b.size
    for c in range(n):
        pivot = c
        for i in range(c + 1, n):
            if abs(a[i, c]) > abs(a[pivot, c]):
                pivot = i
        if a[pivot, c] == 0.0:
            return False
        if pivot != c:
            for j in range(n):
                a[c, j], a[pivot, j] = a[pivot, j], a[c, j]
            b[c], b[pivot] = b[pivot], b[c]
        for i in range(c + 1, n):
            factor = a[i, c] / a[c, c]
            if factor != 0.0:
                for j in range(c + 1, n):
                    a[i, j] -= factor * a[c, j]
                b[i] -= factor * b[c]
    for c in range(n - 1, -1, -1):
        for j in range(c + 1, n):
            b[c] -= a[c, j] * b[j]
        b[c] /= a[c, c]
    return True


@compiled()
def _settle(k: Kernel, v: F64, w: Work, history: F64, growth: float) -> bool:
    """Backward Euler with steps that grow by `growth` from v until a step of 1000 s succeeds.

    Backward Euler turns an unstable mode into a decaying one once the step is longer than its time constant
    tau. Until then the mode has had about tau / (1 - 1/growth), so that slow growth lets it leave.
    """
    store_charges(k, v, w)
    h, old = 1e-12, w.rest[0]
    put(old, v)
    for _ in range(2000):
        for i in range(k.columns):
            history[i] = -old[i] / h
        if newton(k, 1.0 / h, history, v, 1e-4, w) > 0:
            moved = 0.0
            for i in range(k.unknowns):
                moved = max(moved, abs(v[i] - old[i]))
            put(old, v)
            if h > 1e3:
                return True
            h *= growth if moved < 0.2 else 1.0 if moved < 0.5 else 0.5
        else:
            put(v, old)
            h *= 0.25
            if h < 1e-18:
                return False
    return False


@compiled()
def settled(k: Kernel, v: F64, w: Work, history: F64, matrix: F64) -> bool:
    """Follow the circuit's own dynamics from v to a rest state, in place; false where they find none."""
    return _settle(k, v, w, history, GROWTH) and _direct(
        k, v, v, 0.0, w, matrix, MAX_REST_UPDATE, np.int64(60)
    )


@compiled()
def _is_rounded(k: Kernel, v: F64, w: Work, update: F64) -> bool:
    """Whether the currents at every node cancel but for rounding, where the updates do not get smaller.

    Of nodes that hang on leakage alone, and on each other by far larger conductances, rounding moves the
    voltage that they share by more than a converged solve's last update; it is then known to 1 mV.
    """
    for i in range(k.unknowns):
        if not abs(update[i]) < _SAME_STATE:
            return False
    evaluate(k, v, w)
    total = w.rest[0]
    for i in range(k.unknowns):
        total[i] = 0.0
        for p in range(k.conductance.start[i], k.conductance.start[i + 1]):
            total[i] += abs(k.conductance.value[p] * v[k.conductance.column[p]])
    for p in range(k.stamps.row.size):
        total[k.stamps.row[p]] += abs(w.current[k.stamps.current[p]])
    for i in range(k.unknowns):  # noqa: SIM110 - a loop, which numba compiles
        if abs(w.residual[i]) > _ROUNDED * total[i]:
            return False
    return True


@compiled()
def stride_state(k: Kernel, v: F64, w: Work, matrix: F64, decades: F64, most: float) -> bool:
    """Solve for a rest state near `v` by Newton's method, in place; false where none is found.

    most: largest move of a node in one iteration, V.
    """
    store_charges(k, v, w)
    anchor = w.rest[1]
    put(anchor, v)
    if _direct(k, v, anchor, 0.0, w, matrix, most, np.int64(200)):
        return True
    put(v, anchor)
    found = True
    for g in decades:
        found = found and _direct(k, v, anchor, g, w, matrix, most, np.int64(200))
    return found and _direct(k, v, anchor, 0.0, w, matrix, most, np.int64(200))


@compiled()
def rest_state(k: Kernel, v: F64, w: Work, matrix: F64, decades: F64) -> bool:
    """Solve for a rest state near `v`, in place; false where none is found."""
    anchor, history = w.rest[1], w.rest[2]
    if stride_state(k, v, w, matrix, decades, MAX_REST_UPDATE):
        return True
    put(v, anchor)
    if _settle(k, v, w, history, 2.0):
        if _direct(k, v, anchor, 0.0, w, matrix, MAX_REST_UPDATE, np.int64(60)):
            return True
        return _is_rounded(k, v, w, w.rest[3, : k.unknowns])
    return False


def operating_point(
    target: Testbench | Machine,
    silicon: Silicon | None = None,
    start: Mapping[str, float] | None = None,
    time: float | None = None,
) -> OperatingPoint:
    """Find the rest state of a testbench, with its sources at their direct values or those at one time.

    `target` is the testbench, or one that is lowered already, on which `silicon` has no effect; the nominal
    process at 27 degC unless given.

    Parameters
    ----------
    start
        Voltages (V) by node path near which the state is looked for; nodes that are left out start at 0 V,
        and where that leads away from them, where the circuit rests with these voltages held.
        Without a start, a state that is not stable is left along the circuit's own dynamics where these
        settle (those of a latch do, those of an oscillator do not), and is reported among `others`.
    time
        Time whose values the sources have, s, 0 for where a run begins. Unless it is given, a source has its
        `direct` value, and without one that at 0 s.

    Raises
    ------
    SolverError
        No state is found.
    """
    machine = target if isinstance(target, Machine) else to_kernel(target, silicon)
    given = dict(start) if start is not None else dict(machine.testbench.start)
    cold = _cold(machine, time)
    settled = None if cold is None or cold.stable else _leave(cold, time)
    met = [state for state in (settled, cold) if state is not None]
    if given:
        guess = np.zeros(machine.kernel.columns)
        for node, value in given.items():
            guess[machine.column_of(node)] = value
        found = solve_near(machine, guess, time) or _far(machine, guess, time)
        if found is None or _off(found, given) > _HONOURED:
            held = _near_held(machine, given, time)
            is_nearer = held is not None and (found is None or _off(held, given) < _off(found, given))
            found = held if is_nearer else found
    else:
        found = met[0] if met else None
    if found is None:
        remedy = Outcome.NO_OPERATING_POINT.value
        raise SolverError(f"{machine.testbench.title}: no operating point; {remedy}")
    return replace(found, others=tuple(s for s in met if _apart(s, found)))


def _off(point: OperatingPoint, given: Mapping[str, float]) -> float:
    """How far a point is from voltages that were given, V."""
    return max(abs(point[node] - value) for node, value in given.items())


def _near_held(machine: Machine, given: Mapping[str, float], time: float | None) -> OperatingPoint | None:
    """Solve from where the circuit rests with the voltages of a start held; None where it finds nothing."""
    k = machine.kernel
    hold = {node: value for node, value in given.items() if machine.column_of(node) < k.unknowns}
    if not hold or len(hold) == np.unique(machine.column[machine.column < k.unknowns]).size:
        return None
    clamped = to_kernel(machine.testbench, machine.silicon, hold)
    lines = (*machine.polylines, *clamped.polylines[len(machine.polylines) :])
    direct = (*machine.direct, *clamped.direct[len(machine.direct) :])
    rest = _cold(replace(clamped, polylines=lines, direct=direct), time)
    if rest is None:
        return None
    guess = np.zeros(k.columns)
    guess[machine.column] = rest.voltage[rest.machine.column]
    return solve_near(machine, guess, time)


def _apart(one: OperatingPoint, other: OperatingPoint) -> bool:
    return bool(np.abs(one.voltage - other.voltage).max(initial=0.0) > _SAME_STATE)


def _cold(machine: Machine, time: float | None) -> OperatingPoint | None:
    """Solve without a start: from 0 V, half and full supply at every node, last from the nominal die's."""
    v_dd = machine.silicon.process.v_dd
    for level in (0.0, 0.5 * v_dd, v_dd):
        found = solve_near(machine, np.full(machine.kernel.columns, level), time)
        if found is not None:
            return found
    if machine.silicon.die != NOMINAL:
        nominal = _cold(on_die(machine, NOMINAL), time)
        return None if nominal is None else solve_near(machine, nominal.voltage, time)
    return _far(machine, np.zeros(machine.kernel.columns), time)


def _far(machine: Machine, start: F64, time: float | None) -> OperatingPoint | None:
    """Solve from a start in strides that reach beyond `FAR`."""
    k, w = machine.kernel, allocate(machine.kernel)
    for most in _STRIDES:
        v, matrix = _driven(machine, start, time), np.zeros((k.unknowns, k.unknowns))
        if stride_state(k, v, w, matrix, np.array(DECADES), most):
            return OperatingPoint(machine, v, _is_stable(k, v, w))
    return None


def _leave(point: OperatingPoint, time: float | None) -> OperatingPoint | None:
    """Stable state that the circuit settles to from beside an unstable one; None where it does not settle."""
    machine = point.machine
    k = machine.kernel
    v = point.voltage.copy()
    v[: k.unknowns] += NUDGE * np.where(np.arange(k.unknowns) % 2 == 0, 1.0, -1.0)
    if not _settle(k, v, allocate(k), np.zeros_like(v), GROWTH):
        return None
    found = solve_near(machine, v, time)
    return found if found is not None and found.stable else None


def solve_near(machine: Machine, start: F64, time: float | None = None) -> OperatingPoint | None:
    """Rest state near the vector of voltages `start` (float64[columns], V), or None where there is none.

    The sources have their values at `time` (s), or without one their direct values, whatever `start` says.
    """
    k = machine.kernel
    v, w = _driven(machine, start, time), allocate(k)
    if not rest_state(k, v, w, np.zeros((k.unknowns, k.unknowns)), np.array(DECADES)):
        return None
    return OperatingPoint(machine, v, _is_stable(k, v, w))


def _driven(machine: Machine, start: F64, time: float | None) -> F64:
    """The vector of voltages `start` with what the sources hold in it, as `solve_near` has them."""
    k, sources = machine.kernel, machine.sources()
    v = start.copy()
    source_values(sources, sources.start[:-1].copy(), time or 0.0, v, k.unknowns)
    if time is None:
        for s, direct in enumerate(machine.direct):
            v[k.unknowns + s] = v[k.unknowns + s] if direct is None else direct
    v[k.columns - 1] = 0.0
    return v


def _is_stable(k: Kernel, v: F64, w: Work) -> bool:
    """Whether small deviations die out: all finite eigenvalues of (-dI/dv, C) have negative real part."""
    if k.unknowns == 0:
        return True
    conductance = np.zeros((k.unknowns, k.unknowns))
    linearised(k, v, w, conductance)
    rates = natural_rates(*without_charges(k.charges, conductance, charge_matrix(k)))
    return bool((rates.real <= ROUNDING * np.abs(rates).max(initial=0.0)).all())


def charge_matrix(k: Kernel) -> F64:
    """Capacitances between the unknown nodes, float64[unknowns, unknowns], F."""
    found = np.zeros((k.unknowns, k.unknowns))
    rows = np.repeat(np.arange(k.unknowns), np.diff(k.charge.start))
    inside = k.charge.entry >= 0
    found[rows[inside], k.charge.column[inside]] = k.charge.value[inside]
    return found
