"""Operating points along a source by ngspice: its `.dc` where values are evenly spaced, else an `.op` each.

What comes back is the native solver's `Line`. Currents are those of the sources; whether a point is stable is
our own test at ngspice's voltages.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from circuits.arrays import F64
from circuits.circuit import GROUND
from circuits.devices.source import Constant, Source
from circuits.errors import SimulatorError
from circuits.lowering.kernel import Machine, complete_sources
from circuits.solver.sweep.continuation import are_stable, with_source
from circuits.sweep.line import Line
from circuits.testbench import Testbench
from netlists.dialects.ngspice import format_testbench
from netlists.ngspice import run as ngspice
from netlists.ngspice.deadline import DEADLINE
from netlists.ngspice.engine import node_names

RELTOL = 1e-9  # ours: at ngspice's usual 1e-3 a point may be off by a millivolt
_EVEN = 1e-9  # share of the range by which evenly spaced values may be off
_NOTE = "*% source name="


def solve_line(
    machine: Machine,
    source: int | None,
    values: F64,
    near: F64 | None,
    start: Mapping[str, float] | None,
    deadline_s: float | None = DEADLINE,
) -> Line:
    """Operating points of a machine along a source.

    Parameters
    ----------
    machine, source, values, near, start
        As for `circuits.sweep.line.Solve`.
    deadline_s
        Wall-clock time that a run may take, s; None for as long as it takes.

    Raises
    ------
    SimulatorError
        ngspice is missing, refuses the deck, finds no operating point or is not done in time.
    """
    guess = {} if start is None else dict(start)
    if near is not None and near.size == machine.kernel.columns:
        known = zip(machine.names, near[machine.column].tolist(), strict=True)
        guess = {name: v for name, v in known if name != GROUND}
    if source is None or values.size == 1 or not _evenly(values):
        return _one_by_one(machine, source, values, guess, deadline_s)
    bench = _held(machine, guess)
    deck = _deck(bench, machine)
    step = (values[-1] - values[0]) / (values.size - 1)
    element = _elements(deck)[machine.source_names[source]]
    card = f".dc {element} {values[0]:.17g} {values[-1] + 1e-3 * step:.17g} {step:.17g}\n"
    waves = ngspice.run(deck.replace("\n.op\n", f"\n{card}"), deadline_s=deadline_s)
    if waves.steps != values.size:
        raise SimulatorError(f"ngspice: {waves.steps} points, must be {values.size}; sweep fewer")
    return _line(machine, source, values, waves.values, deck)


def _evenly(values: F64) -> bool:
    even = np.linspace(values[0], values[-1], values.size)
    return bool(np.abs(values - even).max() <= _EVEN * abs(values[-1] - values[0]))


def _one_by_one(
    machine: Machine, source: int | None, values: F64, guess: Mapping[str, float], deadline_s: float | None
) -> Line:
    """An operating point a value, each of which begins at the one before."""
    found: list[dict[str, F64]] = []
    names, deck = node_names(machine.testbench, machine.silicon), ""
    for value in values:
        at = machine if source is None else with_source(machine, source, float(value))
        deck = _deck(_held(at, guess), at)
        found.append(ngspice.run(deck, deadline_s=deadline_s).values)
        guess = {path: float(found[-1][name][0]) for path, name in names.items()}
    joined = {name: np.concatenate([each[name] for each in found]) for name in found[0]}
    return _line(machine, source, values, joined, deck)


def _held(machine: Machine, guess: Mapping[str, float]) -> Testbench:
    """The testbench with every source, a bias's too, at its value in the machine."""
    bench = machine.testbench
    sources = complete_sources(bench, machine.flat, machine.silicon)
    held = (
        Source(s.name, s.node, Constant(machine.given(number)), s.quantity)
        for number, s in enumerate(sources)
    )
    return replace(bench, sources=tuple(held), start={**bench.start, **guess})


def _deck(bench: Testbench, machine: Machine) -> str:
    """Deck of an operating point that saves the currents of its sources too."""
    deck = format_testbench(bench, machine.silicon, analysis="op", reltol=RELTOL)
    kinds = dict(zip(machine.source_names, machine.source_quantities, strict=True))
    branches = [f"i({e})" for name, e in _elements(deck).items() if kinds[name] == "voltage"]
    saved = "".join(f"\n.save {branch}" for branch in branches)
    return deck.replace("\n.op\n", f"{saved}\n.op\n")


def _elements(deck: str) -> dict[str, str]:
    """Name of the element of each source, by the source's name, from the notes above them."""
    found, name = {}, ""
    for line in deck.splitlines():
        if line.startswith(_NOTE):
            name = line.removeprefix(_NOTE).split()[0]
        elif name and not line.startswith("*"):
            found[name], name = line.split()[0], ""
    return found


def _line(machine: Machine, source: int | None, values: F64, waves: Mapping[str, F64], deck: str) -> Line:
    names, elements = node_names(machine.testbench, machine.silicon), _elements(deck)
    columns = [waves[names[path]] for path in machine.names[1:]]
    voltage = np.stack([np.zeros(values.size), *columns], axis=1)
    v = np.zeros((values.size, machine.kernel.columns))
    v[:, machine.column] = voltage
    currents = {}
    for number, name in enumerate(machine.source_names):
        quantity = machine.source_quantities[number]
        if quantity == "voltage":
            currents[name] = waves[f"{elements[name].lower()}#branch"]
        else:
            constant = np.full(values.size, machine.given(number))
            currents[name] = values.copy() if number == source else constant
            v[:, machine.kernel.unknowns + number] = currents[name]
    return Line(voltage, currents, are_stable(machine, v), (v[0], v[-1]))
