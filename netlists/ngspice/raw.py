"""ngspice's binary rawfile: the waveforms of a run, written for viewers and other tools.

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

from pathlib import Path

import numpy as np

from circuits.circuit import GROUND
from circuits.measure.branch import waveform
from circuits.solver.transient import Result
from netlists.dialects.ngspice import run_name
from netlists.write.traversal import to_design

# ngspice writes its version here, and runs what stands here when it loads a file; other readers look for the
# word ngspice, which tells its doubles from the mixed words of LTspice
_COMMAND = "Command: echo noctule: in the format of ngspice"


def write_raw(result: Result, path: Path | str) -> None:
    """Write all recorded nodes of the run `result` to the file `path`.

    The title is that of the testbench, its line ends as blanks. Times that a restart of the solver repeats
    stay as they are. A node that stands for an element's current is that current, `i(ELEMENT)`. Raises
    `OSError` where the file cannot be written.
    """
    bench = result.machine.testbench
    top = to_design(bench, result.machine.silicon).top
    kept = [k for k, node in enumerate(result.nodes) if node != GROUND]
    told = [waveform(result, result.nodes[k]) for k in kept]
    names = [("time", "time")]
    for k, one in zip(kept, told, strict=True):
        voltage = one.unit == "V"
        names.append(
            (f"v({run_name(result.nodes[k], top)})", "voltage") if voltage else (one.name, "current")
        )
    table = np.column_stack([result.time, *(one.values for one in told)])
    lines = [
        f"Title: {' '.join(bench.title.split())}",
        "Plotname: Transient Analysis",
        "Flags: real",
        _COMMAND,
        f"No. Variables: {table.shape[1]}",
        f"No. Points: {table.shape[0]}",
        "Variables:",
        *(f"\t{k}\t{name}\t{kind}" for k, (name, kind) in enumerate(names)),
        "Binary:",
    ]
    header = "".join(f"{line}\n" for line in lines).encode()
    Path(path).write_bytes(header + table.astype("<f8").tobytes())
