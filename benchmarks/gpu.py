"""Claims: 100,000 dies on a graphics processor in a twentieth of the time that one core's lanes take.

The rebound neuron's run of 16 ms (a call at 1 ms, an echo 6.4 ms later), mismatch and process, rtol 2e-6:
draws, rest states, their stability, runs, and those that are left to the processor, all included; wall time
of the second call, so that nothing is compiled in it. The peer is the same in lanes of one core, on the first
of these dies and scaled. Of these dies each must have a spike where its lanes have one, and none elsewhere.
With the ideal law, and with the process's own. Without a graphics processor nothing is measured, and the row
says so.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from functools import partial

import numpy as np

from _report import Row, parser_of, report
from circuits.arrays import F64
from circuits.blocks.sonar import rebound_neuron
from circuits.lowering.kernel import Machine, to_kernel
from circuits.programs import gpu
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500, AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.batch import map_dies
from circuits.solver.many import spikes_on_gpu
from circuits.solver.transient import simulate

RTOL = 2e-6
COMPARED = 500
PORT = "spike"


def main() -> int:
    """Measure and print all rows."""
    options = parser_of(__doc__, "10,000 dies").parse_args()
    count = 10_000 if options.quick else 100_000
    return report(rows(count), options, figures)


def rows(count: int) -> Iterator[Row]:
    """Two rows a law; one that says so without a graphics processor."""
    if not gpu.there_is_one():
        yield Row("nothing measured", 0.0, None, None, "CUDA knows no graphics processor here")
        return
    for name, process in (("ideal law", AMI_1500_IDEAL), ("the process's law", AMI_1500)):
        yield from beside_lanes(to_kernel(rebound_neuron.BLOCK.bench(), Silicon(process)), name, count)


def beside_lanes(machine: Machine, law: str, count: int) -> Iterator[Row]:
    """All dies there, beside some of them on one core: the time, and how many have the same class."""
    dies = [Die(number=k) for k in range(1000, 1000 + count)]
    run = partial(spikes_on_gpu, machine, rtol=RTOL)
    run(dies[:COMPARED])
    run(dies)
    start = time.perf_counter()
    found = run(dies)
    ours = time.perf_counter() - start
    work = partial(map_dies, partial(simulate, rtol=RTOL, record=()), machine, dies[:COMPARED], 1)
    work()
    start = time.process_time()
    samples = work()
    peer = (time.process_time() - start) * count / COMPARED
    lanes = np.array([np.nan if s.value is None else first(s.value.spikes[PORT]) for s in samples])
    there = found.first(PORT)[:COMPARED]
    same = int((np.isnan(lanes) == np.isnan(there)).sum())
    apart = 1e6 * float(np.nanmax(np.abs(there - lanes)))
    told = (
        f"{count / ours:.0f} dies/s on {gpu.name()}; {found.again.size} left to the processor, "
        f"{len(found.failed)} failed"
    )
    yield Row(f"{count} dies, {law}, lanes of one core", ours, peer, peer / ours, told, least=20.0)
    told = f"first spikes at most {apart:.2g} us apart"
    share = same / COMPARED
    yield Row(f"of {COMPARED} dies, {law}, the same class", same, COMPARED, share, told, least=1.0)


def first(times: F64) -> float:
    """The first of some times, s; NaN where there is none."""
    return float(times[0]) if times.size else float("nan")


def figures(row: Row) -> str:
    """Both times and their ratio."""
    if row.peer is None or row.ratio is None:
        return "-"
    unit = " s" if row.name.endswith("core") else ""
    return f"{row.ours:.4g}{unit}, peer {row.peer:.4g}{unit}, {row.ratio:.3g} times"


if __name__ == "__main__":
    sys.exit(main())
