"""Claim: the latency unit and the racing layer spike in the solver with ngspice's, within 10 us.

The blocks' own testbenches, nominal, at 27 degC. The unit over 0.15 s, two pings of it: what is stored at the
first tap's event, 25 ms, comes again 0.1 s later, while INH is silent for all of it. The layer of three cells
over 58 ms: the cell with the charge wins, and recurrent inhibition stops the others. The tests of the blocks
follow smaller ones for less long, and nodes besides. One run of ngspice each, from the solver's state of
rest; ours, peer: CPU seconds of both; ratio: the largest distance of spikes, us.

Returns 1 where a claim is missed.
"""

from __future__ import annotations

import math
import sys
import time
from dataclasses import replace

import numpy as np

from _report import Row, parser_of, report
from circuits.blocks.block import Block
from circuits.blocks.latency import layer as latency_layer
from circuits.blocks.latency import unit as latency_unit
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.transient import simulate
from netlists.ngspice import engine
from netlists.ngspice.agreement import SOLVER_RTOL
from netlists.ngspice.form import scaled_testbench

UNIT, LAYER, QUICK = 0.15, 58e-3, 32e-3  # s
ALLOWED = 10.0  # us
RELTOL, TMAX = 1e-4, 20e-6  # of ngspice, the latter in s


def main() -> int:
    """Run both engines and print what came of it."""
    options = parser_of(__doc__, "the unit's first ping alone").parse_args()
    runs = [(latency_unit.BLOCK, QUICK)]
    if not options.quick:
        runs = [(latency_unit.BLOCK, UNIT), (latency_layer.BLOCK, LAYER)]
    return report((compared(block, stop) for block, stop in runs), options, figures)


def figures(row: Row) -> str:
    """Both times, and how far spikes are apart."""
    return f"solver {row.ours:.2f} s of CPU, ngspice {row.peer:.2f} s, {row.ratio:.3g} us apart"


def compared(block: Block, stop: float) -> Row:
    """A block in both engines for so long (s)."""
    silicon = Silicon(AMI_1500_IDEAL)
    bench = replace(scaled_testbench(block, silicon), stop=stop)
    simulate(replace(bench, stop=1e-3), silicon, rtol=SOLVER_RTOL)  # compiles
    start = time.process_time()
    one = simulate(bench, silicon, rtol=SOLVER_RTOL)
    ours = time.process_time() - start
    start = time.process_time()
    other = engine.simulate(bench, silicon, reltol=RELTOL, tmax=TMAX)
    peer = time.process_time() - start
    apart, counts = 0.0, []
    for port, found in one.spikes.items():
        expected = other.spikes[port]
        same = found.size == expected.size
        apart = max(apart, 1e6 * float(np.abs(found - expected).max(initial=0.0)) if same else math.inf)
        counts.append(f"{port} {found.size} and {expected.size}")
    note = f"spikes: {', '.join(counts)}"
    return Row(f"{block.name}, {stop:g} s", ours, peer, apart, note, most=ALLOWED)


if __name__ == "__main__":
    sys.exit(main())
