"""Claim: at the solver's default rtol 99 % of the rebound neuron's spikes are within 1 us of converged ones.

The run of 16 ms with a call and an echo, on 1,000 dies with mismatch and process (1000 to 1999) under fixed
gate voltages: every spike of a run beside the same spike at rtol 1e-8, which rtol 1e-9 moves by at most a
twentieth of what is claimed. Told for each rtol: the 99 % quantile, the largest error and the median over all
spikes, dies whose number of spikes differs, and the user CPU time of the runs from the operating point on,
the tolerances taking turns die by die, in multiples of that at 2e-5.
"""

from __future__ import annotations

import resource
import sys
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from _report import Row, parser_of, report
from circuits.arrays import F64
from circuits.blocks.sonar import rebound_neuron
from circuits.lowering.kernel import on_die, to_kernel
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.operating_point import OperatingPoint, operating_point
from circuits.solver.transient import DEFAULT_RTOL, simulate

WITHIN = 1e-6  # s, of the reference
REFERENCE, FINEST = 1e-8, 1e-9
RTOLS = (2e-5, 1e-5, 5e-6, 2e-6, 1e-6, 5e-7)
DIES = range(1000, 2000)


@dataclass(slots=True)
class Found:
    """Of one tolerance: errors of all spikes (s), dies with another number of spikes, and user CPU, s."""

    errors: list[float] = field(default_factory=list)
    other_count: int = 0
    cpu: float = 0.0


def main() -> int:
    """Measure and print a row a tolerance."""
    options = parser_of(__doc__, "20 dies").parse_args()
    return report(rows(DIES[:20] if options.quick else DIES), options)


def rows(dies: range) -> Iterator[Row]:
    """A row a tolerance: the 99 % quantile of the errors in us, claimed for the default."""
    found = measure(dies, (*RTOLS, FINEST))
    first = found[RTOLS[0]].cpu
    for rtol, each in found.items():
        errors = 1e6 * np.array(each.errors)
        largest, share, middle = errors.max(), *np.quantile(errors, (0.99, 0.5))
        told = (
            f"largest {largest:.3g} us, median {middle:.3g} us, {errors.size} spikes of {len(dies)} dies,"
            f" {each.other_count} dies with another count, {each.cpu / first:.2f} times the CPU"
        )
        claimed = {DEFAULT_RTOL: 1e6 * WITHIN, FINEST: 0.05e6 * WITHIN}
        name, most = f"99 % of errors at rtol {rtol:g}, us", claimed.get(rtol, np.inf)
        yield Row(name, share, None, share, told, most=most)


def measure(dies: range, rtols: tuple[float, ...]) -> dict[float, Found]:
    """Spike times of every die at each tolerance beside the reference."""
    block = rebound_neuron.BLOCK
    circuit = block.build()
    bench = block.testbench(circuit, block.defaults, Silicon(AMI_1500_IDEAL).process.v_dd)
    nominal = to_kernel(bench, Silicon(AMI_1500_IDEAL))
    found = {rtol: Found() for rtol in rtols}
    for number in dies:
        machine = on_die(nominal, Die(number=number))
        point = operating_point(machine)
        reference, _ = spikes(point, REFERENCE)
        for rtol, each in found.items():
            times, cpu = spikes(point, rtol)
            each.cpu += cpu
            if times.size == reference.size:
                each.errors += np.abs(times - reference).tolist()
            else:
                each.other_count += 1
    return found


def spikes(point: OperatingPoint, rtol: float) -> tuple[F64, float]:
    """Times of one run's spikes, and its user CPU, s."""
    before = resource.getrusage(resource.RUSAGE_SELF).ru_utime
    times = simulate(point.machine, rtol=rtol, record=("spike",), point=point).spikes["spike"]
    return times, resource.getrusage(resource.RUSAGE_SELF).ru_utime - before


if __name__ == "__main__":
    sys.exit(main())
