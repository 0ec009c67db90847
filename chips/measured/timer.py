"""How the deviations of its comparator change a timer (`circuits.blocks.latency.synapse`), measured."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from chips.measured.perturbation import deviating, deviations_of, slopes
from circuits.arrays import F64
from circuits.errors import SolverError
from circuits.event import WIDTH
from circuits.lowering.kernel import Machine
from circuits.solver.transient import Result, simulate

COMPARATOR = tuple(f"mc{k}" for k in range(7))
PARAMETERS = deviations_of(COMPARATOR)
STEPS = {"v_t0": 5e-3, "beta": 0.05}  # V, 1: of the central differences


def timer_slopes(machine: Machine, timer: str, lasts: Callable[[Result], float | None], rtol: float) -> F64:
    """Return slopes d ln Q / dx of a timer's charge by each deviation of its comparator, float64[PARAMETERS].

    timer: its instance path. lasts: for how long it is on in a run, s; its event is `WIDTH` of that. Raises
    `SolverError` where it is never on.
    """

    def log_charge(parameter: str, move: float) -> float:
        found = lasts(simulate(deviating(machine, f"{timer}.{parameter}", move), rtol=rtol))
        if found is None:
            raise SolverError(f"{timer}.{parameter}: the timer is never on in the run")
        return float(np.log(found - WIDTH))

    return slopes(log_charge, PARAMETERS, STEPS)
