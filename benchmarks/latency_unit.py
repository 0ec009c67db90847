"""Claim: over 0.15 s, two pings of it, the latency unit's transistors spike with ngspice's, within 10 us.

The block's own testbench: what is stored at the first tap's event, 25 ms, comes again 0.1 s later, while INH
is silent for all of it; the test of the block follows 12 ms, and nodes besides. One run of ngspice, from the
solver's state of rest; the CPU time of both stands beside, with no claim.

Returns 1 where the claim is missed.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
import time
from dataclasses import asdict, dataclass, replace

import numpy as np

from circuits.blocks.latency_unit import BLOCK
from circuits.silicon import Silicon
from circuits.solver.transient import simulate
from netlists import engine
from netlists.agreement import SOLVER_RTOL, scaled_testbench

STOP, QUICK = 0.15, 32e-3  # s
ALLOWED = 10e-6  # s
RELTOL, TMAX = 1e-4, 20e-6  # of ngspice, the latter in s


@dataclass(frozen=True, slots=True)
class Row:
    """One measured figure; ours and peer in s of CPU."""

    name: str
    ours: float
    peer: float
    ratio: float
    accuracy: str
    cores: int = 1
    holds: bool = True


def main() -> int:
    """Run both engines and print what came of it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--quick", action="store_true", help="the first ping alone")
    options = parser.parse_args()
    row = compared(QUICK if options.quick else STOP)
    if options.json:
        print(json.dumps([asdict(row)], indent=2))
    else:
        print(f"{row.name}: solver {row.ours:.2f} s of CPU, ngspice {row.peer:.2f} s; {row.accuracy}")
    return 0 if row.holds else 1


def compared(stop: float) -> Row:
    """The unit in both engines for so long (s)."""
    silicon = Silicon()
    bench = replace(scaled_testbench(BLOCK, silicon), stop=stop)
    simulate(replace(bench, stop=1e-3), silicon, rtol=SOLVER_RTOL)  # compiles
    start = time.process_time()
    one = simulate(bench, silicon, rtol=SOLVER_RTOL)
    ours = time.process_time() - start
    start = time.process_time()
    other = engine.simulate(bench, silicon, reltol=RELTOL, tmax=TMAX)
    peer = time.process_time() - start
    found, expected = one.spikes["spike"], other.spikes["spike"]
    same = found.size == expected.size
    apart = float(np.abs(found - expected).max(initial=0.0)) if same else math.inf
    accuracy = f"{found.size} spikes, ngspice {expected.size}, {1e6 * apart:.3g} us apart at most"
    return Row(f"latency unit, {stop:g} s", ours, peer, peer / ours, accuracy, holds=apart <= ALLOWED)


if __name__ == "__main__":
    sys.exit(main())
