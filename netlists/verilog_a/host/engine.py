"""A transient of a testbench whose transistors are modules of Verilog-A.

Charges are integrated by the backward differences of second order with steps that follow the error, which is
told by the parabola through the points before. It begins where the native solver begins, moved to the rest
state of these models. Every step takes each instance's own currents, charges and derivatives, by Newton's
method. It is written for comparison and small circuits: a matrix is dense.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from circuits.arrays import F64
from circuits.errors import SolverError
from circuits.lowering.kernel import to_kernel
from circuits.lowering.supply import spike_levels
from circuits.silicon.process import Polarity
from circuits.silicon.silicon import Silicon
from circuits.solver.beginning import beginning
from circuits.solver.outcome import Outcome
from circuits.solver.transient import Result, Steps
from circuits.testbench import Testbench
from netlists.ngspice.engine import upward_crossings
from netlists.verilog_a.host.equations import Equations, equations_of
from netlists.verilog_a.host.models import Model

RTOL = 1e-5
"""Local error of a step, relative to 1 V; ours."""
_CLOSE = 1e-9  # V, the last update of a solve
_LARGEST = 0.3  # V, of an unknown in one iteration
_ITERATIONS = 40
_DECADES = (*(10.0**-k for k in range(3, 16)), 0.0)  # S, to the beginning, while a rest state is sought
_FIRST = 1e-6  # of the run, the first step
_LEAST = 1e-12  # of the run, the least step


def simulate(
    testbench: Testbench, models: Mapping[Polarity, Model], silicon: Silicon | None = None, rtol: float = RTOL
) -> Result:
    """Run a testbench on models in Verilog-A, on the nominal die.

    Parameters
    ----------
    testbench
        The testbench; its transistors' sizes are the models' `width`, `length` and `multiplicity`.
    models
        What the transistors of each polarity are.
    silicon
        Temperature, and the process of what is no transistor; 27 degC unless given.
    rtol
        Local error of a step, relative to 1 V.

    Raises
    ------
    SolverError
        There is no rest state, or steps become too small.
    ParameterError
        A die that deviates, an operational amplifier, or a diode.
    """
    machine = to_kernel(testbench, silicon or Silicon())
    equations = equations_of(machine, models)
    begun = beginning(machine)
    x = _inner(equations, begun.voltage)
    if testbench.begin != "uic":
        nudge = np.zeros_like(x)
        if begun.disturbance is not None:
            columns = [machine.column_of(node) for node in begun.disturbance.nodes]
            nudge[[int(np.flatnonzero(equations.free == c)[0]) for c in columns]] = begun.disturbance.voltage
        x = (x if testbench.initial else rest_state(equations, x)) + nudge
    time, states, rejected = _integrate(equations, x, testbench.stop, rtol)
    voltage = np.array([equations.place(s, t) for t, s in zip(time, states, strict=True)])
    by_node = voltage[:, machine.column]
    watched = [machine.names[n] for w in testbench.watch for n in machine.flat.watched_nodes(w)]
    spikes = {
        node: upward_crossings(time, by_node[:, machine.names.index(node)], *level)
        for node, level in zip(watched, spike_levels(machine).T.tolist(), strict=True)
    }
    steps = Steps(time.size - 1, rejected, equations.evaluations)
    return Result(
        machine, Outcome.DONE, time, by_node, machine.names, spikes, steps, begun.point, begun.disturbance
    )


def rest_state(equations: Equations, start: F64, time: float = 0.0) -> F64:
    """Voltages of the unknowns at rest near `start`, V; raises `SolverError` where none are found."""
    x = start.copy()
    for tied in _DECADES:
        found = _newton(equations, x, time, tied * np.eye(x.size), tied * start, 0.0)
        if found is None:
            raise SolverError(
                f"{equations.machine.testbench.title}: no rest state of the models in Verilog-A;"
                " give voltages to begin with, as initial"
            )
        x = found
    return x


def _inner(equations: Equations, voltage: F64) -> F64:
    """A first guess of the unknowns: internal nodes stand at zero, or where their instance's source is."""
    v = np.zeros(equations.columns)
    v[: voltage.size] = voltage
    for each in equations.instances:
        names = [name.lower() for name in each.module.nodes]
        for k, column in enumerate(each.columns[4:], start=4):
            like = {"di": 0, "gp": 1, "gi": 1, "si": 2}.get(names[k], 3 if names[k].startswith("b") else None)
            v[column] = 0.0 if like is None else v[each.columns[like]]
    return np.asarray(v[equations.free])


def _newton(
    equations: Equations,
    start: F64,
    time: float,
    tied: F64,
    pull: F64,
    rate: float,
    history: F64 | None = None,
) -> F64 | None:
    """Solve `i + rate q + history + tied x = pull`; None where it does not converge."""
    x = start.copy()
    for _ in range(_ITERATIONS):
        found = equations.evaluate(x, time)
        residual = found.current + rate * found.charge + tied @ x - pull
        if history is not None:
            residual = residual + history
        jacobian = found.conductance + rate * found.capacitance + tied
        scale = np.maximum(np.abs(jacobian).max(axis=1), 1e-300)
        try:
            step = np.linalg.solve(jacobian / scale[:, None], residual / scale)
        except np.linalg.LinAlgError:
            return None
        if not np.isfinite(step).all():
            return None
        x -= np.clip(step, -_LARGEST, _LARGEST)
        if np.abs(step).max() < _CLOSE:
            return x
    return None


def _integrate(equations: Equations, x: F64, stop: float, rtol: float) -> tuple[F64, list[F64], int]:
    """Points of the run, s, the unknowns there, V, and how many steps were rejected."""
    corners = np.unique(np.concatenate([[stop], *(t for t, _ in equations.machine.polylines)]))
    corners = corners[(corners > 0.0) & (corners <= stop)]
    time, states, charges = [0.0], [x], [equations.evaluate(x, 0.0).charge]
    step, since, rejected = _FIRST * stop, 0, 0
    zero, nothing = np.zeros((x.size, x.size)), np.zeros(x.size)
    while time[-1] < stop * (1.0 - 1e-12):
        end = corners[np.searchsorted(corners, time[-1] * (1.0 + 1e-12) + 1e-30, side="right")]
        step = min(step, end - time[-1])
        h = end - time[-1] if end - time[-1] < 1.5 * step else step
        rate, history = _differences(h, time, charges, since)
        guess = _predicted(time[-1] + h, time, states, since)
        found = _newton(equations, guess, time[-1] + h, zero, nothing, rate, history)
        error = np.inf if found is None else float((np.abs(found - guess) / (1.0 + np.abs(found))).max())
        allowed = rtol if since > 1 else 100.0 * rtol
        if found is None or (error > 8.0 * allowed and h > 10.0 * _LEAST * stop):
            rejected += 1
            step = 0.25 * h
            if step < _LEAST * stop:
                title = equations.machine.testbench.title
                raise SolverError(f"{title}: steps too small at {time[-1]:g} s; give a looser rtol")
            continue
        time.append(end if h == end - time[-1] else time[-1] + h)
        states.append(found)
        charges.append(equations.evaluate(found, time[-1]).charge)
        since = 0 if time[-1] == end and end < stop else since + 1
        grown = h * float(np.clip(0.8 * (allowed / max(error, 1e-30)) ** (1.0 / 3.0), 0.3, 2.0))
        step = min(grown, _FIRST * stop if since == 0 else np.inf)
    return np.array(time), states, rejected


def _differences(h: float, time: list[float], charges: list[F64], since: int) -> tuple[float, F64]:
    """Factor of the new charge and the rest of its rate: of second order but for the first step."""
    if since == 0:
        return 1.0 / h, -charges[-1] / h
    ratio = h / (time[-1] - time[-2])
    new, old, older = (1.0 + 2.0 * ratio) / (1.0 + ratio), -(1.0 + ratio), ratio * ratio / (1.0 + ratio)
    return new / h, (old * charges[-1] + older * charges[-2]) / h


def _predicted(at: float, time: list[float], states: list[F64], since: int) -> F64:
    """The polynomial through up to three points since the last corner."""
    count = min(since + 1, 3)
    t = np.array(time[-count:])
    weights = [np.prod([(at - t[j]) / (t[k] - t[j]) for j in range(count) if j != k]) for k in range(count)]
    return np.asarray(sum(w * s for w, s in zip(weights, states[-count:], strict=True)))
