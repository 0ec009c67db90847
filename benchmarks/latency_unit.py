"""Claim: over 0.15 s, two pings of it, the latency unit's transistors agree with ngspice.

The block's own testbench: what is stored at the first tap's event, 25 ms, comes again 0.1 s later, while INH
is silent for all of it; the test of the block follows 12 ms. Spikes, nodes and operating point within what
`noctule reproduce agreement` allows, ngspice's own convergence included. Both engines' CPU time stands
beside, with no claim: ngspice runs several times, with finer and finer steps, and its time is that of all.

Returns 1 where the claim is missed.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from dataclasses import asdict, dataclass, replace

from circuits.blocks.latency_unit import BLOCK
from circuits.silicon import Silicon
from circuits.solver.transient import simulate
from netlists.agreement import SOLVER_RTOL, compare, scaled_testbench

STOP, QUICK = 0.15, 12e-3  # s


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
    parser.add_argument("--quick", action="store_true", help="12 ms in the place of 150")
    options = parser.parse_args()
    row = compared(QUICK if options.quick else STOP)
    if options.json:
        print(json.dumps([asdict(row)], indent=2))
    else:
        print(f"{row.name}: solver {row.ours:.2f} s, with ngspice {row.peer:.2f} s; {row.accuracy}")
    return 0 if row.holds else 1


def compared(stop: float) -> Row:
    """The unit in both engines for so long (s)."""
    silicon = Silicon()
    bench = replace(scaled_testbench(BLOCK, silicon), stop=stop)
    simulate(replace(bench, stop=1e-3), silicon, rtol=SOLVER_RTOL)  # compiles
    start = time.process_time()
    simulate(bench, silicon, rtol=SOLVER_RTOL)
    ours = time.process_time() - start
    start = time.process_time()
    found = compare(bench, silicon)
    peer = time.process_time() - start - ours
    d = found.difference
    accuracy = (
        f"{sum(x.size for x in found.solver.spikes.values())} spikes, {1e6 * d.spike_time:.3g} us apart of"
        f" {1e6 * d.spike_allowance:.3g} allowed, {d.worst_node} {1e3 * d.worst_rms:.3g} mV rms,"
        f" {'converged' if found.converged else 'not converged'}, {'agrees' if found.agrees else 'differs'}"
    )
    return Row(f"latency unit, {stop:g} s", ours, peer, peer / ours, accuracy, holds=found.agrees)


if __name__ == "__main__":
    sys.exit(main())
