"""A netlist as something to run: its testbench, or one of its sub-circuits."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path

from circuits.circuit import Circuit
from circuits.errors import DataError, unknown_name
from circuits.testbench import Testbench
from netlists.read.netlist import Imported, read_netlist
from netlists.read.text.name import circuit_name


def read_bench(
    path: Path, subcircuit: str = "", parameters: Mapping[str, float] | None = None
) -> Testbench | Circuit:
    """Read a netlist as a testbench with its own sources and end.

    Parameters
    ----------
    path
        The file.
    subcircuit
        Name of a sub-circuit, which is given without sources; the whole netlist where it is empty.
    parameters
        Values in the place of those of its own `.param` cards.

    Raises
    ------
    DataError
        Anything that cannot be read in full, and transistors that deviate by their own cards.
    UnknownNameError
        The netlist uses no such sub-circuit.
    """
    return bench_in(read_netlist(path, parameters=parameters), path, subcircuit)


def bench_in(imported: Imported, path: Path, subcircuit: str) -> Testbench | Circuit:
    """Give what `read_bench` does of a netlist that has been read."""
    if imported.silicon is None and imported.deviations:
        first = next(iter(imported.deviations))
        raise DataError(
            f"{path.name}: {first} has delvto or mulu0, which a run on a die would not keep; leave them out"
        )
    found = imported.testbench
    if not subcircuit:
        return found
    inside = {circuit.name: circuit for circuit in (found.circuit, *_inside(found.circuit))}
    name = circuit_name(subcircuit.lower())
    if name not in inside:
        raise unknown_name(f"{path}: subcircuit", subcircuit, inside)
    return inside[name]


def _inside(circuit: Circuit) -> Iterator[Circuit]:
    for instance in circuit.instances:
        yield instance.circuit
        yield from _inside(instance.circuit)
