"""Claims: Curved Openspace flies at least 400,000 pings/s on one core, and samples 1.8 times faster on two.

One core: whole loop (field of view among 1,400 obstacles, memory, desirability, selection, flight, touch)
with exact ranges, 2 m/s, 5 Hz; samples from seed 1000 on of at most 20,000 pings each, planting and sorting
the forests included, and without it. By CPU time of the thread. With chips under the ideal law: at least
20,000 pings/s with the ranging chip's readings, on the nominal die and on dies with mismatch, and with the
selection chip too; the making of a die's table is measured apart. Under the full law, by which `run forest`
flies, a decision of the selection is integrated: at least 500 pings/s; and with calibrated chips and all
noise, as that command flies, where the ranging chip hears whole pings: at least 300. Peers: the look for
obstacles alone, by cKDTree of scipy and by numpy, microseconds each, beside ours for the whole ping. The
first claim is of the loop: planting a forest takes a millisecond, which counts where samples are short.

Memory: by how much the largest size of the process grows over samples, after as many and more before.

Two threads: elapsed time of the same samples on one thread and on two, of turns that alternate. It is only
measured where nothing else runs: `--alone` says so; the row is left out otherwise.

Returns 1 where a claim is missed.
"""

from __future__ import annotations

import resource
import sys
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from statistics import median

import numpy as np
from scipy.spatial import cKDTree

from _report import Row, parser_of, report
from circuits.silicon.die import NOMINAL, Die
from circuits.silicon.process import AMI_1500, AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from system.forest.run import moving_of
from system.forest.scenario import Scenario
from system.openspace.flight import fly_sample, margin_of, planter
from system.openspace.kernel import fly
from system.openspace.law import Arcs, Bat, arcs_of
from system.openspace.map import OBSTACLES, SIDE, cells_of, plant
from system.openspace.reader import readings
from system.openspace.senses import EXACT, Sensing, senses_of
from system.openspace.senses_kernel import Senses
from system.openspace.state import PINGS, new_flight

FIRST_SEED, MOST = 1000, 20_000
CLAIM, CLAIM_THREADS, CLAIM_CHIPS, CLAIM_WHOLE, CLAIM_HEARD = 400_000.0, 1.8, 20_000.0, 500.0, 300.0
MOST_WHOLE = 1000  # pings of a sample under the full law
LOOKS = 2000


def main() -> int:
    """Measure and print all rows."""
    parser = parser_of(__doc__, "fewer samples")
    parser.add_argument("--alone", action="store_true", help="nothing else runs: measure two threads too")
    options = parser.parse_args()
    samples, turns = (40, 1) if options.quick else (200, 3)
    arcs = arcs_of(Bat())
    fly_sample(arcs, planter(), (0, 0), 10)  # compiled, or loaded
    rows = [*one_core(arcs, samples, turns), growth(arcs, samples), *with_chips(arcs, samples // 4), *peers()]
    if options.alone:
        rows.append(two_threads(arcs, samples, turns))
    return report(rows, options)


def figure(name: str, value: float, unit: str, claim: float, note: str, cores: int = 1) -> Row:
    """A figure without a peer; claim: the least, or 0 where there is none."""
    return Row(f"{name}, {unit}", value, None, value, note, cores, claim)


def one_core(arcs: Arcs, samples: int, turns: int) -> Iterator[Row]:
    """Pings a second of CPU, with and without the planting of forests."""
    whole = [_whole(arcs, samples) for _ in range(turns)]
    pings = whole[0][0]
    rate = pings / median(taken for _, taken in whole)
    yield figure("whole loop, forests planted too", rate, "pings/s", 0.0, f"{samples} samples, {pings} pings")
    alone = median(_loop(arcs, samples) for _ in range(turns))
    yield figure("whole loop, forests given", alone, "pings/s", CLAIM, f"{1e6 / alone:.3g} us a ping")


def growth(arcs: Arcs, samples: int) -> Row:
    """What more samples add to the largest size of the process."""
    sizes = []
    for first in (FIRST_SEED + samples, FIRST_SEED + 2 * samples):
        for seed in range(first, first + samples):
            fly_sample(arcs, planter(), (seed, 0), MOST)
        sizes.append(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024)
    note = f"{samples} samples more; the process has {sizes[1]:.0f} MiB"
    return figure("growth of memory", sizes[1] - sizes[0], "MiB", 0.0, note)


def with_chips(arcs: Arcs, samples: int) -> Iterator[Row]:
    """Pings a second of CPU with chips in the loop, and what a die's table takes."""
    cases = {
        "ranging chip": Sensing("chip"),
        "selection chip": Sensing(selection="chip"),
        "both chips": Sensing("chip", "chip"),
    }
    for name, sensing in cases.items():
        for die in (NOMINAL, Die(number=FIRST_SEED, process=False)):
            senses = senses_of(sensing, Bat(), Silicon(AMI_1500_IDEAL, die=die))
            fly_sample(arcs, planter(), (0, 0), 10, senses=senses)
            pings, taken = _whole(arcs, samples, senses)
            yield figure(
                f"whole loop, {name}, {die}", pings / taken, "pings/s", CLAIM_CHIPS, f"{pings} pings"
            )
    for name, sensing in cases.items():
        silicon = Silicon(AMI_1500, die=Die(number=FIRST_SEED))
        senses = senses_of(sensing, Bat(), silicon, bias_kind="generator")
        fly_sample(arcs, planter(), (0, 0), 10, senses=senses)
        pings, taken = _whole(arcs, min(samples, 10), senses, MOST_WHOLE)
        claim = CLAIM_CHIPS if sensing.selection == "ideal" else CLAIM_WHOLE
        yield figure(f"whole loop, {name}, full law", pings / taken, "pings/s", claim, f"{pings} pings")
    flown = Scenario(die=Die(number=FIRST_SEED), sensing=Sensing("chip", "chip", silicon_noise="all"))
    senses = moving_of(flown).at(0.0)
    fly_sample(arcs, planter(), (0, 0), 10, senses=senses)
    pings, taken = _whole(arcs, min(samples, 10), senses, MOST_WHOLE)
    note = f"{pings} pings, full law, all noise"
    yield figure("whole loop, both chips, whole pings", pings / taken, "pings/s", CLAIM_HEARD, note)
    start, dies = time.thread_time(), 10
    for number in range(FIRST_SEED, FIRST_SEED + dies):
        readings(Silicon(AMI_1500_IDEAL, die=Die(number=number, process=False)), "calibrated")
    yield figure("table of a die, calibrated", (time.thread_time() - start) / dies, "s", 0.0, f"{dies} dies")


def two_threads(arcs: Arcs, samples: int, turns: int) -> Row:
    """How much faster two threads are, by elapsed time."""
    pairs = [tuple(_elapsed(arcs, samples, threads) for threads in (1, 2)) for _ in range(turns)]
    ratio = median(one / two for one, two in pairs)
    note = f"{median(p[0] for p in pairs):.3g} s and {median(p[1] for p in pairs):.3g} s"
    return figure("two threads over samples", ratio, "times", CLAIM_THREADS, note, 2)


def peers() -> Iterator[Row]:
    """The look for obstacles alone, by others."""
    place = plant(OBSTACLES, np.random.default_rng(FIRST_SEED)).place
    tree = cKDTree(place, boxsize=SIDE)
    at = SIDE * np.random.default_rng(1).random((LOOKS, 2))

    def with_numpy(point: np.ndarray) -> None:
        apart = place - point
        apart -= SIDE * np.round(apart / SIDE)
        np.flatnonzero((apart**2).sum(axis=1) < 25.0)

    for name, look in (("numpy", with_numpy), ("cKDTree", lambda point: tree.query_ball_point(point, 5.0))):
        start = time.process_time()
        for point in at:
            look(point)
        taken = (time.process_time() - start) / LOOKS
        yield figure(
            f"peer, obstacles within 5 m, {name}", 1e6 * taken, "us", 0.0, "no field of view, no loop"
        )


def _whole(arcs: Arcs, samples: int, senses: Senses = EXACT, most: int = MOST) -> tuple[int, float]:
    start, pings = time.thread_time(), 0
    for seed in range(FIRST_SEED, FIRST_SEED + samples):
        pings += fly_sample(arcs, planter(), (seed, 0), most, senses=senses)[0].pings
    return pings, time.thread_time() - start


def _loop(arcs: Arcs, samples: int) -> float:
    pings, taken = 0, 0.0
    for seed in range(FIRST_SEED, FIRST_SEED + samples):
        cells = cells_of(plant(OBSTACLES, np.random.default_rng(seed)), margin_of(arcs))
        flight = new_flight(25.0, 25.0, -np.pi, 5, OBSTACLES, 0)
        start = time.thread_time()
        fly(arcs, EXACT, cells, flight, MOST)
        taken += time.thread_time() - start
        pings += int(flight.counts[PINGS])
    return pings / taken


def _elapsed(arcs: Arcs, samples: int, threads: int) -> float:
    start = time.perf_counter()
    with ThreadPoolExecutor(threads) as pool:
        for _ in pool.map(
            lambda seed: fly_sample(arcs, planter(), (seed, 0), MOST), range(FIRST_SEED, FIRST_SEED + samples)
        ):
            pass
    return time.perf_counter() - start


if __name__ == "__main__":
    sys.exit(main())
