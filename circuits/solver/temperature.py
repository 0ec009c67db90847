"""Transient runs at transistor level while the temperature moves.

At another temperature the transistors and the biases are that temperature's, and the nodes' voltages go on:
a capacitor keeps its charge, and its capacitance is the same at all temperatures. A diode's charge becomes
that of its voltage at the new temperature, without a current.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from circuits.lowering.kernel import Machine, to_kernel
from circuits.silicon.course import Course, told_when
from circuits.silicon.silicon import Silicon
from circuits.solver.beginning import beginning
from circuits.solver.newton import with_charges
from circuits.solver.outcome import Outcome
from circuits.solver.swing import uncrossed
from circuits.solver.transient import DEFAULT_RTOL, Result, Runner, State, Steps
from circuits.testbench import Testbench


def at_temperature(machine: Machine, temperature_c: float) -> Machine:
    """Return the same testbench on the same die at another temperature, degC."""
    return to_kernel(machine.testbench, replace(machine.silicon, temperature_c=temperature_c))


def moved(runner: Runner, state: State, machine: Machine) -> tuple[Runner, State]:
    """Go on with `machine`, the same testbench at another temperature; all voltages stay.

    Inputs that were given to the run stay too; biases that were not are those of the new temperature.
    """
    old = runner.machine
    lines = tuple(
        there if np.array_equal(line, here) else line
        for line, here, there in zip(state.lines, old.polylines, machine.polylines, strict=True)
    )
    voltage = with_charges(machine.kernel, state.voltage)
    return Runner(machine, runner.record, runner.rtol), replace(
        state, voltage=voltage, step=np.zeros(1), lines=lines
    )


def simulate_course(
    testbench: Testbench,
    silicon: Silicon,
    course: Course,
    *,
    rtol: float = DEFAULT_RTOL,
    record: tuple[str, ...] | None = None,
) -> Result:
    """Run a testbench to its stop time while the temperature follows a course.

    It begins at rest at the course's temperature at 0 s, unless the testbench says otherwise.

    Parameters
    ----------
    testbench
        The testbench.
    silicon
        Process and die; the course's temperature stands in the place of its own.
    course
        Temperature over time.
    rtol
        Local error of a step, relative to the larger of |v| and 1 V.
    record
        Nodes to keep, by path; all unless given.

    Raises
    ------
    SolverError
        The solver gives up.
    """
    machine = to_kernel(testbench, replace(silicon, temperature_c=course.begin))
    begun = beginning(machine)
    nodes = machine.names if record is None else record
    runner = Runner(machine, nodes, rtol)
    state = runner.enter(begun)
    times = [np.zeros(1)]
    volts = [state.voltage[0][[machine.column_of(n) for n in nodes]][None, :]]
    spikes: list[tuple[str, float]] = []
    extents = []
    for begin, end, celsius in course.stretches(0.0, testbench.stop):
        if celsius != runner.machine.silicon.temperature_c:
            with told_when(begin):
                runner, state = moved(runner, state, at_temperature(runner.machine, celsius))
        state, segment = runner.advance(state, end, stop_at_event=False)
        times.append(segment.time)
        volts.append(segment.voltage)
        spikes += segment.spikes
        extents.append(segment.extent)
    extent = np.stack([np.min([e[0] for e in extents], axis=0), np.max([e[1] for e in extents], axis=0)])
    found = {n: np.array([t for name, t in spikes if name == n]) for n in runner.labels}
    return Result(
        machine, Outcome.DONE, np.concatenate(times), np.vstack(volts), nodes, found,
        Steps(*(int(c) for c in state.counts)), begun.point, begun.disturbance,
        uncrossed(runner.labels, runner.thresholds, extent),
    )  # fmt: skip
