"""The solver's two questions, answered by ngspice: a transient run and an operating point.

The run comes back as the solver's own `Result`, so that measures, pictures and files need no second form.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from circuits.circuit import GROUND
from circuits.lowering.kernel import Machine, to_kernel
from circuits.silicon import Silicon
from circuits.solver import operating_point as native
from circuits.solver.integrate import source_values
from circuits.solver.operating_point import OperatingPoint
from circuits.solver.outcome import Outcome
from circuits.solver.transient import Result, Steps
from circuits.testbench import Testbench
from netlists import ngspice
from netlists.ngspice_text import DEFAULT_RELTOL, Method, format_testbench, run_name
from netlists.traversal import Definition, to_design

F64 = NDArray[np.float64]

_REARM = 0.8  # share of the threshold below which a spike detector is armed again, as in the solver


def simulate(
    testbench: Testbench,
    silicon: Silicon,
    *,
    reltol: float = DEFAULT_RELTOL,
    tmax: float | None = None,
    method: Method = "gear",
    deadline_s: float | None = None,
) -> Result:
    """Run a testbench in ngspice from its operating point to its stop time.

    Parameters
    ----------
    testbench, silicon
        As for the solver.
    reltol, tmax, method
        As for `netlists.ngspice_text.format_testbench`.
    deadline_s
        Wall-clock seconds after which the run is halted.

    Returns
    -------
    What the solver would return: all nodes at ngspice's accepted points; `spikes` are upward crossings of
    half the supply by linear interpolation, rearmed below 0.8 of it; `steps.accepted` counts the points after
    the first (ngspice does not tell rejections and iterations: 0). `operating_point` has ngspice's voltages
    at time 0; whether it is stable is our own test at the rest state next to it.

    Raises
    ------
    SimulatorError
        ngspice is missing, refuses the deck, gives up or is too slow.
    TopologyError
        The circuit cannot be solved, or has names that differ in case only.
    """
    machine = to_kernel(testbench, silicon)
    deck = format_testbench(testbench, silicon, reltol=reltol, tmax=tmax, method=method)
    waveforms = ngspice.run(deck, deadline_s=deadline_s)
    names = node_names(testbench, silicon)
    columns = [waveforms.values[names[node]] for node in machine.names[1:]]
    voltage = np.stack([np.zeros(waveforms.steps), *columns], axis=1)
    watched = [machine.names[n] for w in testbench.watch for n in machine.flat.port_nodes(w)]
    threshold = 0.5 * silicon.process.v_dd
    spikes = {
        node: upward_crossings(waveforms.axis, voltage[:, machine.names.index(node)], threshold)
        for node in watched
    }
    return Result(
        machine, Outcome.DONE, waveforms.axis, voltage, machine.names, spikes,
        Steps(waveforms.steps - 1, 0, 0), _point(machine, voltage[0]),
    )  # fmt: skip


def operating_point(testbench: Testbench, silicon: Silicon) -> dict[str, float]:
    """Voltage (V) of every node by path, the sources as they are at time 0, by ngspice's `.op`.

    Raises `SimulatorError` where ngspice is missing or finds none.
    """
    waveforms = ngspice.run(format_testbench(testbench, silicon, analysis="op"))
    names = node_names(testbench, silicon)
    return {GROUND: 0.0} | {path: float(waveforms.values[name][0]) for path, name in names.items()}


def node_names(testbench: Testbench, silicon: Silicon) -> Mapping[str, str]:
    """Name in a run of ngspice by our path, of every node but ground."""
    design = to_design(testbench, silicon)
    top: Definition = design.top
    return {path: run_name(path, top) for path in design.nodes}


def upward_crossings(time: F64, voltage: F64, threshold: float) -> F64:
    """Times (s) at which a waveform rises through `threshold` (V), by linear interpolation.

    After one the detector is armed again by a point below 0.8 of the threshold.
    """
    above = voltage >= threshold
    found, last = [], -1
    for k in np.flatnonzero(above[1:] & ~above[:-1]):
        if last < 0 or voltage[last : k + 1].min() < _REARM * threshold:
            share = (threshold - voltage[k]) / (voltage[k + 1] - voltage[k])
            found.append(float(time[k] + share * (time[k + 1] - time[k])))
            last = int(k) + 1
    return np.array(found)


def _point(machine: Machine, voltage: F64) -> OperatingPoint:
    """Put the nodes' voltages at time 0 into the solver's form."""
    start = dict(zip(machine.names[1:], voltage[1:].tolist(), strict=True))
    nearest = native.operating_point(machine, start=start)
    sources = machine.sources()
    vector = np.zeros(machine.kernel.columns)
    source_values(sources, sources.start[:-1].copy(), 0.0, vector, machine.kernel.unknowns)
    vector[machine.column] = voltage
    return replace(nearest, voltage=vector, others=())
