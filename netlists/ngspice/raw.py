"""ngspice's binary rawfile, written and read: waveforms of a run for viewers and other tools.

A header of text lines, then after the line `Binary:` the points as little-endian float64, the variables of a
point side by side:

    Title: ..., Plotname: Transient Analysis, Flags: real
    No. Variables: N, No. Points: T
    Variables:      a line `<tab>index<tab>name<tab>type` each
    Binary:         T x N x 8 bytes

The first variable is the time (s); the others are the nodes' voltages, called `v(name)` with the names that
a run of the exported netlist has (`netlists.dialects.ngspice`: `v_mem[3]` is `v(v_mem#3)`), ground left out.
ngspice writes the same names, so that a file of ours and one of its own stand side by side in a viewer.
There is no date in it: the same run gives the same bytes.
The format is ngspice's own; ngspice 39 and spicelib 1.6 read it (tests).
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from circuits.arrays import F64
from circuits.circuit import GROUND
from circuits.errors import DataError
from circuits.solver.transient import Result
from netlists.dialects.ngspice import run_name
from netlists.write.traversal import to_design

_MARK = b"Binary:\n"
# ngspice writes its version here, and runs what stands here when it loads a file; other readers look for the
# word ngspice, which tells its doubles from the mixed words of LTspice
_COMMAND = "Command: echo noctule: in the format of ngspice"
_PLOT = "Transient Analysis"
_HEADER_LIMIT = 1 << 26  # bytes in which a header must end


@dataclass(frozen=True, slots=True)
class RawFile:
    """Contents of a rawfile. `values`: float64[T, N], SI units, the first of the N variables being the axis.

    `names` and `types` (`time`, `voltage`, `current`, ...) by variable.
    """

    title: str
    plot: str
    names: tuple[str, ...]
    types: tuple[str, ...]
    values: F64

    def __getitem__(self, name: str) -> F64:
        """Values of a variable, float64[T]; case does not count. Raises `DataError` for an unknown one."""
        lower = [n.lower() for n in self.names]
        if name.lower() not in lower:
            raise DataError(f"rawfile: no variable {name}; it has {', '.join(self.names)}")
        return self.values[:, lower.index(name.lower())]


def write_raw(result: Result, path: Path | str) -> None:
    """Write all recorded nodes of a run to the file `path`; the title is that of the testbench.

    Times repeated by a restart of the solver stay as they are.
    """
    bench, silicon = result.machine.testbench, result.machine.silicon
    top = to_design(bench, silicon).top
    kept = [k for k, node in enumerate(result.nodes) if node != GROUND]
    names = ["time", *(f"v({run_name(result.nodes[k], top)})" for k in kept)]
    types = ["time"] + ["voltage"] * len(kept)
    table = np.column_stack([result.time, result.voltage[:, kept]])
    Path(path).write_bytes(format_raw(RawFile(bench.title, _PLOT, tuple(names), tuple(types), table)))


def format_raw(contents: RawFile) -> bytes:
    """Bytes of a rawfile; line ends in the title and the plot's name become blanks."""
    points, variables = contents.values.shape
    title, plot = (" ".join(text.split()) for text in (contents.title, contents.plot))
    lines = [
        f"Title: {title}",
        f"Plotname: {plot}",
        "Flags: real",
        _COMMAND,
        f"No. Variables: {variables}",
        f"No. Points: {points}",
        "Variables:",
    ]
    for k, (name, kind) in enumerate(zip(contents.names, contents.types, strict=True)):
        lines.append(f"\t{k}\t{name}\t{kind}")
    header = "\n".join(lines).encode() + b"\n" + _MARK
    return header + contents.values.astype("<f8").tobytes()


def read_raw(path: Path | str) -> RawFile:
    """Read a binary rawfile of real numbers that holds one plot.

    Raises
    ------
    DataError
        No such file, no binary rawfile, complex numbers, points missing or too many.
    """
    try:
        data = Path(path).read_bytes()
    except OSError as error:
        raise DataError(f"{path}: cannot be read, {error.strerror}; check the path") from error
    header, mark, body = data.partition(b"\n" + _MARK)
    if not mark or len(header) > _HEADER_LIMIT:
        raise DataError(f"{path}: no line Binary:, must be a binary rawfile; write it without filetype=ascii")
    fields, variables = _read_header(path, header.decode("utf-8", "replace").splitlines())
    if "real" not in fields.get("flags", "").lower().split():
        raise DataError(
            f"{path}: flags {fields.get('flags', 'none')}, must be real; write a transient or dc run"
        )
    width, points = (_count(path, fields, key) for key in ("no. variables", "no. points"))
    if len(variables) != width or any(len(v) < 3 for v in variables):
        raise DataError(f"{path}: {len(variables)} variables listed, must be {width} of index, name and type")
    if len(body) != 8 * width * points:
        raise DataError(
            f"{path}: {len(body)} bytes of points, must be {8 * width * points}; the file is cut short"
            " or holds more than one plot"
        )
    values = np.frombuffer(body, "<f8").reshape(points, width).astype(np.float64)
    names, types = (tuple(v[k] for v in variables) for k in (1, 2))
    return RawFile(fields.get("title", ""), fields.get("plotname", ""), names, types, values)


def _read_header(path: Path | str, lines: list[str]) -> tuple[dict[str, str], list[list[str]]]:
    """Fields by lower-case name, and the words of each variable's line."""
    fields: dict[str, str] = {}
    for k, line in enumerate(lines):
        name, colon, value = line.partition(":")
        if name.lower() == "variables":
            first = [value.split()] if value.split() else []
            return fields, [*first, *(rest.split() for rest in lines[k + 1 :])]
        if not colon:
            raise DataError(f"{path}: line {k + 1}, must be NAME: VALUE; is it a rawfile?")
        fields[name.lower()] = value.strip()
    raise DataError(f"{path}: no line Variables:; is it a rawfile?")


def _count(path: Path | str, fields: dict[str, str], key: str) -> int:
    text = fields.get(key, "")
    if not (text.isascii() and text.isdigit()):
        raise DataError(f"{path}: {key} {text or 'missing'}, must be a number; is it a rawfile?")
    return int(text)
