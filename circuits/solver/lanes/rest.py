"""Where runs in lanes begin: rest states found in lanes, and their stability.

Newton's method starts from 0 V at all unknown nodes, as `circuits.solver.operating_point` does first, and
where that fails from the rest state of the nominal die. A state that it finds and that is stable is the
operating point. Where it finds none, or one that is not stable, or where the testbench says otherwise how its
runs begin, `circuits.solver.beginning` looks at the machine by itself.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from circuits.arrays import F64, Bools
from circuits.errors import SolverError
from circuits.lowering.kernel import Machine, on_die
from circuits.silicon.die import NOMINAL
from circuits.solver.beginning import Beginning, beginning, held_voltages
from circuits.solver.lanes.layout import DONE, FAILED, Wiring, dense, jobs_of
from circuits.solver.lanes.places import Runs, run_in_lanes
from circuits.solver.modes import ROUNDING, all_natural_rates
from circuits.solver.operating_point import OperatingPoint, charge_matrix, operating_point


def beginnings(
    machines: Sequence[Machine], w: Wiring, runs: Runs = run_in_lanes
) -> list[Beginning | Exception]:
    """Where a run of each machine begins, or why there is no such state; w: the structure of them all."""
    kinds = {(id(m.testbench), id(m.flat)): m for m in machines}
    at_rest = {key: begins_at_rest(machine) for key, machine in kinds.items()}
    every = [at_rest[id(m.testbench), id(m.flat)] for m in machines]
    found = iter(rest_states([m for m, rests in zip(machines, every, strict=True) if rests], w, runs))
    points = [next(found) if rests else None for rests in every]
    return [
        _alone(machine) if point is None else Beginning(point, point.voltage)
        for machine, point in zip(machines, points, strict=True)
    ]


def begins_at_rest(machine: Machine) -> bool:
    """Whether runs begin at a rest state that is looked for without a start: so on all dies, or on none."""
    bench = machine.testbench
    held = held_voltages(bench, machine.flat, machine.silicon)
    return not (held or bench.start or bench.begin == "uic")


def _alone(machine: Machine) -> Beginning | Exception:
    try:
        return beginning(machine)
    except Exception as error:  # noqa: BLE001 - whatever it raises is what its run gives
        return error


def rest_states(
    machines: Sequence[Machine], w: Wiring, runs: Runs = run_in_lanes
) -> list[OperatingPoint | None]:
    """The stable rest state of each machine, None where lanes find none; w: the structure of them all."""
    states = _solve(machines, w, [np.zeros(w.columns)] * len(machines), runs)
    lost = [k for k, (state, _) in enumerate(states) if state == FAILED]
    if lost:
        near = nominal_rests([machines[k] for k in lost])
        again = [k for k, start in zip(lost, near, strict=True) if start is not None]
        starts = [start for start in near if start is not None]
        for k, found in zip(again, _solve([machines[k] for k in again], w, starts, runs), strict=True):
            states[k] = found
    return [point for _, point in states]


def nominal_rests(machines: Sequence[Machine]) -> list[F64 | None]:
    """Voltages at rest of each machine's nominal die, which is solved for once for machines that share it."""
    known: dict[tuple[int, float], F64 | None] = {}
    for machine in machines:
        key = id(machine.flat), machine.silicon.temperature_c
        if key not in known:
            try:
                known[key] = operating_point(on_die(machine, NOMINAL), time=0.0).voltage
            except SolverError:
                known[key] = None
    return [known[id(m.flat), m.silicon.temperature_c] for m in machines]


def _solve(
    machines: Sequence[Machine], w: Wiring, starts: Sequence[F64], runs: Runs
) -> list[tuple[int, OperatingPoint | None]]:
    """How each search ended, from voltages at the unknown nodes on, and the state where it is stable."""
    if not machines:
        return []
    *_, found = runs(w, jobs_of(machines, starts, resting=True))
    good = found.state == DONE
    good[good] = _stable(w, [m for m, each in zip(machines, good, strict=True) if each], found.jacobian[good])
    points = [
        OperatingPoint(machine, voltage, stable=True) if each else None
        for machine, voltage, each in zip(machines, found.rest, good, strict=True)
    ]
    return list(zip(found.state.tolist(), points, strict=True))


def _stable(w: Wiring, machines: Sequence[Machine], jacobian: F64) -> Bools:
    """Whether small deviations die out from each rest state, as `circuits.solver.operating_point` has it."""
    matrices, stable = dense(w, jacobian), np.ones(len(machines), dtype=np.bool_)
    charges = [m.kernel.charge.value for m in machines]
    same = all(c is charges[0] or np.array_equal(c, charges[0]) for c in charges)
    for part in [slice(None)] if same else [slice(k, k + 1) for k in range(len(machines))]:
        if machines[part]:
            stable[part] = decays(matrices[part], charge_matrix(machines[part][0].kernel))
    return stable


def decays(conductances: F64, charge: F64) -> Bools:
    """Whether all modes of each state decay; not where their rates cannot be told."""
    try:
        rates = all_natural_rates(conductances, charge)
    except np.linalg.LinAlgError:
        return np.zeros(len(conductances), dtype=np.bool_)
    largest = np.abs(rates).max(axis=1, initial=0.0)
    return np.asarray((rates.real <= ROUNDING * largest[:, None]).all(axis=1))
