"""Claims: the latency chip runs at 100 times real time on one core with mismatch, the same to the bit.

A die with mismatch and process variation, ideal biases, ten pings a second in the scene of Figure
12, the head middle and middle left in turn, a reset after every second ping; maps, bus and motors are in the
time. CPU time of one thread, the median of several turns; compiling and making the die are left out (and
stand in the note). A second chip of the same die must say the same, from another thread too. Beside it, with
no claim: the published network on the same pings (`--network`), and the chip with a unit of transistors.

Returns 1 where a claim is missed.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from statistics import median

import numpy as np

from _report import Row, parser_of, report
from chips.latency.chip import LatencyChip, PingResponse
from chips.latency.model import usual_biases
from chips.latency.unit_level import TransistorUnit
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from system.openspace.law import DIRECTIONS, MIDDLE, Arcs, Bat, arcs_of
from system.spiking_bat.bat import seen_from
from system.spiking_bat.brain import network_brain
from system.spiking_bat.chip_brain import ChipBrain, brain_with, design_of
from system.spiking_bat.numbers import Numbers
from system.spiking_bat.scene import HEADING, OBSTACLES, PING_RATE

CLAIM = 100.0
DIE = Die(number=1003)
PLACE = (16, 5)  # of the unit of transistors


def main() -> int:
    """Measure and print all rows."""
    parser = parser_of(__doc__, "a shorter run, fewer turns")
    parser.add_argument("--network", action="store_true", help="the published network beside it")
    options = parser.parse_args()
    pings, turns = (500, 2) if options.quick else (3000, 5)
    return report(measure(pings, turns, network=options.network), options)


def measure(pings: int, turns: int, *, network: bool) -> Iterator[Row]:
    """Speed, sameness, and what stands beside."""
    arcs, numbers = arcs_of(Bat(ping_rate=PING_RATE)), Numbers()
    run(made(arcs, numbers), arcs, 10)
    start = time.thread_time()
    made(arcs, numbers)
    building = time.thread_time() - start
    found = [run(made(arcs, numbers), arcs, pings) for _ in range(turns)]
    taken, real = median(t for _, t in found), pings / PING_RATE
    note = f"{1e6 * taken / pings:.3g} us of CPU a ping, {pings} pings, {DIE}; the die takes {building:.2g} s"
    yield Row("times real time, with mismatch", taken, real, real / taken, note, least=CLAIM)
    with ThreadPoolExecutor(2) as pool:
        other = pool.submit(run, made(arcs, numbers), arcs, pings).result()[0]
    same = all(equal(found[0][0], said) for said in (found[1][0], other))
    yield Row("the same to the bit, from two threads", 1.0, None, float(same), "times and latencies", 2, 1.0)
    few = 20
    taken = run(made(arcs, numbers, transistors=True), arcs, few)[1]
    note = f"{1e3 * taken / few:.3g} ms of CPU a ping"
    yield Row("times real time, a unit of transistors", taken, few / PING_RATE, few / PING_RATE / taken, note)
    if network:
        brain, at = network_brain(arcs, numbers), scene(arcs)
        start = time.thread_time()
        for k in range(few):
            brain.ping(DIRECTIONS // 2 - k % 2, MIDDLE, at[k % 2])
        taken = time.thread_time() - start
        yield Row("published network, times real time", taken, few / PING_RATE, few / PING_RATE / taken, "-")


def made(arcs: Arcs, numbers: Numbers, *, transistors: bool = False) -> ChipBrain:
    """A chip with maps and motors."""
    design = design_of(arcs, numbers)
    biases, silicon = usual_biases(design, "ideal"), Silicon(AMI_1500_IDEAL, die=DIE)
    units = {PLACE: TransistorUnit(biases, silicon, *PLACE)} if transistors else {}
    return brain_with(LatencyChip(design, biases, silicon, units=units), arcs, numbers)


def scene(arcs: Arcs) -> list[np.ndarray]:
    """What pings ahead and to the middle left show."""
    place = np.array([(-ahead, -left) for ahead, left in OBSTACLES])
    return [seen_from(arcs, place, HEADING, DIRECTIONS // 2 - k) for k in range(2)]


def run(brain: ChipBrain, arcs: Arcs, pings: int) -> tuple[list[PingResponse], float]:
    """What the chip said, and CPU time, s."""
    seen, said = scene(arcs), []
    start = time.thread_time()
    for k in range(pings):
        said.append(brain.answer(DIRECTIONS // 2 - k % 2, MIDDLE, seen[k % 2]).response)
        brain.end(spoken=bool(k % 2))
    return said, time.thread_time() - start


def equal(a: Sequence[PingResponse], b: Sequence[PingResponse]) -> bool:
    """Whether two runs said the same to the bit."""
    return all(
        np.array_equal(getattr(x, name), getattr(y, name))
        for x, y in zip(a, b, strict=True)
        for name in ("times", "paths", "integrating", "memory", "free", "detected")
    )


if __name__ == "__main__":
    sys.exit(main())
