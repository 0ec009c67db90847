"""Parasitic capacitances of a layout: a CSV file of node and capacitance, merged into a netlist.

    node,capacitance
    neuron[2].membrane.v_r,12.5fF
    spike[0],3f

The header may be left out; lines that begin with `#` and empty ones are skipped; an index with commas needs
quotes (`"w[1,2]",1f`). A node is a path as in results: inside an instance its own nodes, while a port of an
instance goes by the name of the outer node. Each capacitance is between its node and ground, at least 0 F.
"""

from __future__ import annotations

import csv
from collections.abc import Iterator
from pathlib import Path

from circuits.checks import LIMITS
from circuits.circuit import GROUND, Circuit
from circuits.errors import CircuitError, DataError, ParameterError
from circuits.lowering.flatten import FlatCircuit, flatten
from circuits.units import format_quantity, parse_quantity

_HEADER = ("node", "capacitance")
_LARGEST = 1 << 24  # bytes; 16 MB are some 500,000 nodes


def read_parasitics(path: Path | str, circuit: Circuit) -> dict[str, float]:
    """Read the capacitances of a circuit's nodes from the CSV file at `path`, F by node path.

    Raises
    ------
    DataError
        The file cannot be read, is too large, or a row names no node of the circuit, has no capacitance, or
        names a node for the second time; the text has file and line.
    """
    flat = flatten(circuit)
    found: dict[str, float] = {}
    numbers: dict[int, int] = {}
    for line, row in _rows(path):
        where = f"{path}:{line}"
        if len(row) != 2:
            raise DataError(f"{where}: {len(row)} columns, must be node and capacitance; write v_mem,12fF")
        node, text = row
        number = _number(flat, node, where)
        if number in numbers:
            raise DataError(
                f"{where}: {node} has a capacitance in line {numbers[number]}; give their sum once"
            )
        numbers[number] = line
        value = _capacitance(text, where, node)
        if value > 0.0:
            found[node] = value
    return found


def _rows(path: Path | str) -> Iterator[tuple[int, list[str]]]:
    """Line numbers and cells of the rows that hold data."""
    try:
        if Path(path).stat().st_size > _LARGEST:
            raise DataError(f"{path}: more than {_LARGEST} bytes; split the layout")
        text = Path(path).read_text(encoding="utf-8")
    except OSError as error:
        raise DataError(f"{path}: {error.strerror or error}; give a readable CSV file") from None
    except UnicodeDecodeError:
        raise DataError(f"{path}: not UTF-8 text; give a CSV file") from None
    reader = csv.reader(text.splitlines())
    try:
        for cells in reader:
            row = [cell.strip() for cell in cells]
            header = reader.line_num == 1 and tuple(c.lower() for c in row) == _HEADER
            if any(row) and not row[0].startswith("#") and not header:
                yield reader.line_num, row
    except csv.Error as error:
        raise DataError(f"{path}:{reader.line_num}: {error}; write node,capacitance") from None


def _number(flat: FlatCircuit, node: str, where: str) -> int:
    if node == GROUND:
        raise DataError(f"{where}: {node} is ground itself; name another node")
    try:
        return flat.node(node)
    except CircuitError:
        shown = node if len(node) <= 60 else node[:60] + "..."
        raise DataError(
            f"{where}: no node {shown} in {flat.circuit.name}; write its path as in neuron[2].membrane.v_r"
        ) from None


def _capacitance(text: str, where: str, node: str) -> float:
    try:
        value = parse_quantity(text, "F", node)
    except ParameterError as error:
        raise DataError(f"{where}: {error}") from None
    if not 0.0 <= value <= LIMITS["F"][1]:
        most = format_quantity(LIMITS["F"][1], "F")
        raise DataError(f"{where}: {node}: {value:g} F, must be 0 to {most}, as a layout has")
    return value
