"""Small signals and noise in ngspice: the exported testbench with `.ac`, or with `.noise`.

The deck is the one of an operating point, begun in the solver's rest state. ngspice differentiates the B
sources of our transistors itself, so that its transfer is its own. B sources make no noise: each of our
noise currents of density S becomes a resistor of 1 ohm beside the circuit, whose own noise 4 k T is turned
into a current between the device's nodes by a transconductance of sqrt(S / 4 k T). So a transistor's density
is ours, and how it reaches the output is ngspice's; resistors of the circuit make ngspice's own noise.
Flicker is left out: its density is ours too, and it takes the same paths.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from circuits.arrays import C128, F64
from circuits.circuit import GROUND
from circuits.devices.source import Source
from circuits.errors import SimulatorError, unknown_name
from circuits.measure.current import current_in
from circuits.silicon.process import BOLTZMANN, kelvin
from circuits.solver.noise.analysis import NoiseSources
from circuits.solver.operating_point import OperatingPoint
from netlists.dialects.ngspice import DIALECT, format_testbench, run_name
from netlists.ngspice.deadline import DEADLINE
from netlists.ngspice.library import simulated
from netlists.ngspice.run import node_name
from netlists.write.traversal import Definition, to_design

_RELTOL = 1e-6  # of the operating point


@dataclass(frozen=True, slots=True)
class Decades:
    """ngspice's grid: `per_decade` frequencies a decade from `low` to `high`, Hz."""

    low: float
    high: float
    per_decade: int

    @property
    def card(self) -> str:
        """Words of an analysis."""
        return f"dec {self.per_decade} {self.low!r} {self.high!r}"


def ac(
    point: OperatingPoint,
    source: str,
    grid: Decades,
    nodes: Sequence[str],
    deadline_s: float | None = DEADLINE,
) -> tuple[F64, C128]:
    """Transfer from a source to nodes, and to currents of sources, over frequency, by ngspice.

    Parameters
    ----------
    point
        The operating point.
    source
        Name of the source.
    grid
        The frequencies.
    nodes
        Paths of the nodes, and i(NAME) of sources of voltage.
    deadline_s
        Wall-clock time after which the run is halted, s; None for as long as it takes.

    Returns
    -------
    Frequencies, float64[F], Hz, and the transfer, complex128[F, nodes], V or A for a V or A.

    Raises
    ------
    SimulatorError
        ngspice is missing or fails.
    UnknownNameError
        There is no such source.
    """
    top, currents = _top(point), {n: name for n in nodes if (name := current_in(n)) is not None}
    vectors = {n: [run_name(n, top).lower()] for n in nodes if n not in currents}
    branches = {n: [_source_name(e).lower() for e in _elements(point, name)] for n, name in currents.items()}
    saved = [f".save i({each})" for own in branches.values() for each in own]
    lines = _deck(point, list(vectors) or None, source, f".ac {grid.card}", saved)
    plots = _plots(lines, deadline_s)
    found = plots[next(name for name in plots if name.startswith("ac"))]
    vectors |= {n: [f"{each}#branch" for each in own] for n, own in branches.items()}
    columns = [sum(np.asarray(found[each], dtype=complex) for each in vectors[n]) for n in nodes]
    return np.asarray(found["frequency"].real), np.stack(columns, axis=1)


def noise(
    point: OperatingPoint,
    node: str,
    source: str,
    grid: Decades,
    sources: NoiseSources,
    deadline_s: float | None = DEADLINE,
) -> tuple[F64, F64, F64]:
    """White noise at a node over frequency, by ngspice.

    Parameters
    ----------
    point
        The operating point.
    node
        Path of the node.
    source
        Name of the source that the noise is referred to.
    grid
        The frequencies.
    sources
        Our noise currents, of which those of resistors are ngspice's own.
    deadline_s
        Wall-clock time after which the run is halted, s; None for as long as it takes.

    Returns
    -------
    Frequencies, float64[F], Hz; the density at the node, float64[F], V^2/Hz; and the density referred to the
    source, float64[F], V^2/Hz or A^2/Hz.
    """
    drive = _elements(point, source)[0]
    card = f".noise v({run_name(node, _top(point)).lower()}) {_source_name(drive)} {grid.card}"
    lines = _deck(point, None, source, card, _noise_elements(point, sources))
    plots = _plots(lines, deadline_s)
    found = next(p for p in plots.values() if "onoise_spectrum" in p)
    output, referred = (np.asarray(found[f"{x}_spectrum"].real) ** 2 for x in ("onoise", "inoise"))
    return np.asarray(found["frequency"].real), output, referred


def _deck(
    point: OperatingPoint,
    nodes: Iterable[str] | None,
    source: str,
    analysis: str,
    extra: Sequence[str] = (),
) -> str:
    """The exported testbench with the source's small signal of 1, more elements, and another analysis."""
    machine = point.machine
    rest = {name: v for name, v in point.voltages().items() if name != GROUND}
    bench = replace(machine.testbench, start=rest)
    text = format_testbench(bench, machine.silicon, analysis="op", nodes=nodes, reltol=_RELTOL)
    lines = text.splitlines()
    for element in _elements(point, source):
        head = f"{_source_name(element)} "
        at = next(k for k, line in enumerate(lines) if line.startswith(head)) + 1
        while lines[at].startswith("+"):
            at += 1
        lines.insert(at, "+ ac 1.0")
    if nodes is None:
        lines = _without(lines, ".save")
    end = lines.index(".op")
    return "\n".join([*lines[:end], *extra, analysis, *lines[end + 1 :]]) + "\n"


def _elements(point: OperatingPoint, source: str) -> tuple[Source, ...]:
    """Cards that the source comes to, one a node."""
    drives = to_design(point.machine.testbench, point.machine.silicon).drives
    for drive in drives:
        if drive.source.name == source:
            return drive.elements
    raise unknown_name("source", source, [d.source.name for d in drives])


def _source_name(source: Source) -> str:
    return ("v" if source.quantity == "voltage" else "i") + DIALECT.naming.text(source.name)


def _without(lines: Sequence[str], card: str) -> list[str]:
    """Lines without a card and what continues it."""
    kept: list[str] = []
    inside = False
    for line in lines:
        inside = line.startswith(card) or (inside and line.startswith("+"))
        if not inside:
            kept.append(line)
    return kept


def _noise_elements(point: OperatingPoint, sources: NoiseSources) -> list[str]:
    """A resistor and a transconductance for each white noise current that ngspice does not make itself."""
    machine = point.machine
    top = _top(point)
    names = {int(c): n for c, n in zip(machine.column, machine.names, strict=True)}
    unit = 4.0 * BOLTZMANN * kelvin(machine.silicon.temperature_c)

    def node(column: int) -> str:
        path = names[column]
        return GROUND if path == GROUND else run_name(path, top)

    lines = []
    for k, (kind, white) in enumerate(zip(sources.kind, sources.white.tolist(), strict=True)):
        if kind not in {"resistor", "diode"} and white > 0.0:
            start, end = node(int(sources.start[k])), node(int(sources.end[k]))
            lines.append(f"r#noise{k} n#noise{k} 0 1.0")
            lines.append(f"g#noise{k} {start} {end} n#noise{k} 0 {math.sqrt(white / unit)!r}")
    return lines


def _top(point: OperatingPoint) -> Definition:
    return to_design(point.machine.testbench, point.machine.silicon).top


def _plots(deck: str, deadline_s: float | None) -> dict[str, dict[str, C128]]:
    """Run a deck; vectors of every plot by name, lower case."""
    with simulated(deck, deadline_s) as library:
        found: dict[str, dict[str, C128]] = {}
        for plot in library.plot_names:
            names = library.vector_names(plot)
            found[plot] = {node_name(n): library.copy_complex(plot, n) for n in names}
    for vectors in found.values():
        for name, values in vectors.items():
            if not np.isfinite(values).all():
                raise SimulatorError(f"ngspice.{name}: not finite; check what drives it")
    return found
