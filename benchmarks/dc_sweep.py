"""Claim: 1,000 points of amplifiers of five transistors at least 100 times as fast as by ngspice's `.dc`.

One is the tests' own, one the open stage of the block `transamp-n` with the tail of its bias's code.

Both solve the same equations: ngspice has them as expressions, in the deck that the export writes. Time is
that of the processor, of one thread each, the least of several. The sweep itself is what the points take
beyond those of a sweep of two (ngspice), and the followed branch (`trace`); the whole call is from the
testbench to the labelled arrays (ours) and from the deck to its vectors (ngspice). Both are converged: the
largest difference of any node at any point is told, to ngspice at reltol 1e-9, which ngspice is timed at too.

ours, peer: time, ms; ratio: theirs to ours. Returns 1 where a claim is missed.
"""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from _report import Row, parser_of, report
from circuits.api import (
    ROLLS_180,
    Silicon,
    operating_point,
    sweep,
    to_kernel,
)
from circuits.bias import gate_voltage
from circuits.blocks.bench import transamp
from circuits.blocks.drive import powered
from circuits.blocks.mos import mos
from circuits.solver.sweep.continuation import trace, with_source
from circuits.testbench import Testbench
from netlists.ngspice.sweep import solve_line

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from tests.circuits.sweep.amplifier import amplifier

POINTS = 1000
LOW, HIGH = 0.6, 1.2  # V
MIDDLE = 0.9  # V, of the other input
SWEEP_CLAIM, WHOLE_CLAIM = 100.0, 20.0
CONVERGED = 5e-6  # V


def main() -> int:
    """Measure both and print what came of it."""
    options = parser_of(__doc__, "fewer repetitions, and 27 degC alone").parse_args()
    celsius = (27.0,) if options.quick else (-20.0, 27.0, 85.0)
    repeats = 3 if options.quick else 7
    benches = ("amplifier", amplifier(), "plus"), ("transamp-n", transconductor(), "v_plus")
    found = (row for c in celsius for given in benches for row in rows(*given, c, repeats))
    return report(
        found, options, lambda r: f"{r.ours:8.3f} ms, ngspice {r.peer:8.1f} ms, {r.ratio:5.1f} times"
    )


def transconductor() -> Testbench:
    """One copy of the block, its output open, its tail's gate that of the bias at 27 degC."""
    tail = transamp.bias_of("n")
    device = mos("mb", "n", "d", "g", "s", 1.0, 1.0)
    gate = gate_voltage(Silicon(ROLLS_180).law("n"), device, tail.value)
    waves = {"v_plus": MIDDLE, "v_minus": MIDDLE, "v_tail": gate}
    stage = transamp.stage("n", transamp.Params())
    return Testbench("transamp-n", stage, powered(ROLLS_180.v_dd, waves), math.inf)


def rows(title: str, bench: Testbench, source: str, celsius: float, repeats: int) -> Iterator[Row]:
    """Two rows of a testbench and one of its sources at a temperature: the sweep itself, the whole call."""
    values, silicon = np.linspace(LOW, HIGH, POINTS), Silicon(ROLLS_180, celsius)
    machine = to_kernel(bench, silicon)
    plus = machine.source_names.index(source)
    first = operating_point(with_source(machine, plus, LOW)).voltage
    ours = least(lambda: trace(machine, plus, values, first), repeats)
    whole = least(lambda: sweep(bench, {source: values}, silicon), repeats)
    theirs = least(lambda: solve_line(machine, plus, values, None, None), repeats)
    two = least(lambda: solve_line(machine, plus, values[:2], None, None), repeats)
    line = solve_line(machine, plus, values, None, None)
    apart = np.abs(trace(machine, plus, values, first)[:, machine.column] - line.voltage).max()
    said = f"largest difference {1e6 * apart:.2f} uV, at most {1e6 * CONVERGED:g}"
    met = 1.0 if apart <= CONVERGED else 0.0  # what is not converged counts for nothing
    for name, one, other, claim in (
        ("the sweep itself", ours, theirs - two, SWEEP_CLAIM),
        ("the whole call", whole, theirs, WHOLE_CLAIM),
    ):
        yield Row(
            f"{title}, {name}, {celsius:g} degC", 1e3 * one, 1e3 * other, met * other / one, said, least=claim
        )


def least(run: Callable[[], object], repeats: int) -> float:
    """Processor time of the fastest of several runs after a first one, s."""
    run()
    found = []
    for _ in range(repeats):
        begin = time.process_time()
        run()
        found.append(time.process_time() - begin)
    return min(found)


if __name__ == "__main__":
    sys.exit(main())
