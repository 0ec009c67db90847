"""The solver's two questions, answered by ngspice: a transient run and an operating point.

The run comes back as the solver's own `Result`, so that measures, pictures and files need no second form.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from circuits.arrays import F64
from circuits.circuit import GROUND
from circuits.errors import SimulatorError, SolverError
from circuits.lowering.kernel import Machine, to_kernel
from circuits.lowering.supply import REARM, spike_levels
from circuits.silicon.silicon import Silicon
from circuits.solver import operating_point as native
from circuits.solver.beginning import Disturbance, beginning
from circuits.solver.integrate import source_values
from circuits.solver.operating_point import OperatingPoint
from circuits.solver.outcome import Outcome
from circuits.solver.swing import uncrossed
from circuits.solver.transient import Result, Steps
from circuits.testbench import Testbench
from netlists.dialects.ngspice import format_testbench, run_name
from netlists.ngspice import run as ngspice
from netlists.ngspice.deadline import DEADLINE
from netlists.ngspice.library import NoOperatingPointError
from netlists.registry import DEFAULT_RELTOL, Method
from netlists.write.traversal import Definition, to_design

Write = Callable[[Testbench], str]  # the deck of a testbench
_POINT_RELTOL = 1e-7  # of an operating point, ours: it chooses no step, and at 1 pA 1e-5 is 1 uV of a diode
_HOLD = 1e-17  # S, ours: with 5 V a twentieth of the current that ngspice takes for nothing (abstol)


class Held(UserWarning):
    """ngspice has found no operating point by itself, and began at the solver's."""


def simulate(
    testbench: Testbench,
    silicon: Silicon,
    *,
    reltol: float = DEFAULT_RELTOL,
    tmax: float | None = None,
    method: Method = "gear",
    deadline_s: float | None = DEADLINE,
) -> Result:
    """Run a testbench in ngspice from its operating point to its stop time.

    Parameters
    ----------
    testbench, silicon
        As for the solver.
    reltol, tmax, method
        Relative tolerance (dimensionless), largest step (s) and integration method of ngspice.
    deadline_s
        Wall-clock time after which a run is halted, s; None for as long as it takes.

    Returns
    -------
    What the solver would return: all nodes at ngspice's accepted points; `spikes` are upward crossings of
    the solver's thresholds by linear interpolation, armed again where the solver's are; `steps.accepted`
    counts the points after the first (ngspice does not tell rejections and iterations: 0). `operating_point`
    has ngspice's voltages at time 0; whether it is stable is our own test at the rest state next to it. Where
    the solver's rest state is not stable, ngspice begins with the same nodes held beside it. Where ngspice
    finds no operating point by itself, it warns (`Held`) and searches beside the solver's (see `_run`).

    Raises
    ------
    SimulatorError
        ngspice is missing, refuses the deck, gives up or is too slow.
    TopologyError
        The circuit cannot be solved, or has names that differ in case only.
    """

    def write(bench: Testbench) -> str:
        return format_testbench(bench, silicon, reltol=reltol, tmax=tmax, method=method)

    return simulate_deck(testbench, silicon, write, deadline_s)


def simulate_deck(
    testbench: Testbench, silicon: Silicon, write: Write, deadline_s: float | None = DEADLINE
) -> Result:
    """Run a testbench in ngspice as `simulate` does, with a deck of one's own.

    Parameters
    ----------
    testbench, silicon
        As for the solver, which gives the names, and a state to begin with.
    write
        Gives the deck of a testbench, which may begin elsewhere. Its nodes have the names of our own decks.
    deadline_s
        Wall-clock time after which a run is halted, s; None for as long as it takes.

    Raises
    ------
    SimulatorError, TopologyError
        As `simulate`.
    """
    machine = to_kernel(testbench, silicon)
    begun, disturbed = _disturbed(machine)
    waveforms = _run(write, begun, machine, deadline_s)
    names = node_names(testbench, silicon)
    columns = [waveforms.values[names[node]] for node in machine.names[1:]]
    voltage = np.stack([np.zeros(waveforms.steps), *columns], axis=1)
    watched = [machine.names[n] for w in testbench.watch for n in machine.flat.watched_nodes(w)]
    levels = spike_levels(machine)
    seen = voltage[:, [machine.names.index(node) for node in watched]]
    spikes = {
        node: upward_crossings(waveforms.axis, wave, *level)
        for node, wave, level in zip(watched, seen.T, levels.T.tolist(), strict=True)
    }
    return Result(
        machine, Outcome.DONE, waveforms.axis, voltage, machine.names, spikes,
        Steps(waveforms.steps - 1, 0, 0), _point(machine, voltage[0]), disturbed,
        uncrossed(watched, levels[0], np.stack([seen.min(axis=0), seen.max(axis=0)])),
    )  # fmt: skip


def operating_point(
    testbench: Testbench, silicon: Silicon, deadline_s: float | None = DEADLINE
) -> dict[str, float]:
    """Voltage (V) of every node by path, with the sources as they are at time 0, by ngspice's `.op`.

    Warns (`Held`) as `simulate` does.

    Parameters
    ----------
    testbench
        The testbench.
    silicon
        Process, temperature and die.
    deadline_s
        Wall-clock time after which the run is halted, s; None for as long as it takes.

    Raises
    ------
    SimulatorError
        ngspice is missing, finds no operating point, or is not done in time.
    """

    def write(bench: Testbench) -> str:
        return format_testbench(bench, silicon, analysis="op", reltol=_POINT_RELTOL)

    return point_of_deck(testbench, silicon, write, deadline_s)


def point_of_deck(
    testbench: Testbench, silicon: Silicon, write: Write, deadline_s: float | None = DEADLINE
) -> dict[str, float]:
    """Find an operating point in ngspice as `operating_point` does, with a deck of one's own.

    Parameters
    ----------
    testbench, silicon, write, deadline_s
        As of `simulate_deck`; the deck asks for an operating point.

    Raises
    ------
    SimulatorError
        As `operating_point`.
    """
    waveforms = _run(write, testbench, to_kernel(testbench, silicon), deadline_s)
    names = node_names(testbench, silicon)
    return {GROUND: 0.0} | {path: float(waveforms.values[name][0]) for path, name in names.items()}


def node_names(testbench: Testbench, silicon: Silicon) -> Mapping[str, str]:
    """Name in a run of ngspice by our path, of every node but ground."""
    design = to_design(testbench, silicon)
    top: Definition = design.top
    return {path: run_name(path, top) for path in design.nodes}


def upward_crossings(time: F64, voltage: F64, threshold: float, rearm: float | None = None) -> F64:
    """Times (s) at which a waveform rises through `threshold` (V), by linear interpolation.

    After one the detector is armed again by a point below `rearm` (V), 0.8 of the threshold unless given.
    """
    rearm = REARM * threshold if rearm is None else rearm
    above = voltage >= threshold
    found, last = [], -1
    for k in np.flatnonzero(above[1:] & ~above[:-1]):
        if last < 0 or voltage[last : k + 1].min() < rearm:
            share = (threshold - voltage[k]) / (voltage[k + 1] - voltage[k])
            found.append(float(time[k] + share * (time[k + 1] - time[k])))
            last = int(k) + 1
    return np.array(found)


def _run(write: Write, bench: Testbench, machine: Machine, deadline_s: float | None) -> ngspice.Waveforms:
    """Run the deck of `bench`; where ngspice finds no operating point, once more beside the solver's.

    Nodes that all devices leave, as diode-connected ones without a load, have conductances down to nothing,
    which ngspice's elimination calls singular. The second deck has the solver's rest state as its guess and
    each node tied to it by 1e-17 S, whose current is below ngspice's abstol wherever the nodes go.
    """
    try:
        return ngspice.run(write(bench), deadline_s=deadline_s)
    except NoOperatingPointError as error:
        failed = error
    try:
        rest = native.operating_point(machine).voltages()
    except SolverError as error:
        raise SimulatorError(f"{failed} (the solver: {error})") from error
    del rest[GROUND]
    try:
        deck = _held(write(replace(bench, start=rest)), rest, machine)
        waveforms = ngspice.run(deck, deadline_s=deadline_s)
    except NoOperatingPointError:
        raise SimulatorError(f"{failed} (neither beside the solver's, tied to it by {_HOLD:g} S)") from None
    names = node_names(machine.testbench, machine.silicon)
    apart = {node: float(waveforms.values[names[node]][0]) - v for node, v in rest.items()}
    worst = max(apart, key=lambda node: abs(apart[node]))
    warnings.warn(
        f"ngspice.{bench.title}: no operating point by itself; found beside the solver's with each node tied"
        f" to it by {_HOLD:g} S: {worst} at {rest[worst] + apart[worst]:.6g} V, there {rest[worst]:.6g} V",
        Held,
        stacklevel=3,
    )
    return waveforms


def _held(deck: str, rest: Mapping[str, float], machine: Machine) -> str:
    """The deck with a conductance from each node that no source drives to its voltage in `rest`."""
    names = node_names(machine.testbench, machine.silicon)
    free = [n for n in rest if machine.column_of(n) < machine.kernel.unknowns]
    lines = []
    for k, node in enumerate(free):
        lines.append(f"g#hold{k} {names[node]} 0 {names[node]} 0 {_HOLD!r}")
        lines.append(f"i#hold{k} 0 {names[node]} dc {_HOLD * rest[node]!r}")
    head, end, tail = deck.rpartition("\n.end")
    return head + "\n" + "\n".join(lines) + end + tail


def _disturbed(machine: Machine) -> tuple[Testbench, Disturbance | None]:
    """The testbench as the solver would begin its run, and what takes it away from an unstable rest state.

    ngspice finds rest states of its own: the solver's is the guess, and its disturbed nodes are held.
    """
    bench = machine.testbench
    try:
        found = beginning(machine)
    except SolverError:
        return bench, None  # ngspice may find what the solver does not
    if found.disturbance is None:
        return bench, None
    volts = OperatingPoint(machine, found.voltage, stable=False).voltages()
    del volts[GROUND]
    held = {node: volts[node] for node in found.disturbance.nodes}
    return replace(bench, start=volts, initial=held), found.disturbance


def _point(machine: Machine, voltage: F64) -> OperatingPoint:
    """Put the nodes' voltages at time 0 into the solver's form.

    Whether the state is stable is told at the rest state next to it, at the solver's own where a search from
    there is lost: nodes that nothing holds are at rest anywhere.
    """
    start = dict(zip(machine.names[1:], voltage[1:].tolist(), strict=True))
    try:
        nearest = native.operating_point(machine, start=start, time=0.0)
    except SolverError:
        nearest = native.operating_point(machine, time=0.0)
    sources = machine.sources()
    vector = np.zeros(machine.kernel.columns)
    source_values(sources, sources.start[:-1].copy(), 0.0, vector, machine.kernel.unknowns)
    vector[machine.column] = voltage
    return replace(nearest, voltage=vector, others=())
