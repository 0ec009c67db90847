"""Claims: a wave over ideal cells is 7 times faster than scipy's Dijkstra, over mismatched ones 3 times.

Ideal: costs 1 to 10 drawn for each cell of a grid of eight neighbours, from a corner to all cells, at 20 x
20, 200 x 200 and 2000 x 2000. Mismatched: the same costs times lognormal factors of sigma 0.1, one a cell,
as on a die, whose inputs all delay alike. One an axon is the general form, which reads eight delays a cell;
of it twice scipy's speed is claimed (ours). Building the graph counts for neither side; pointers, which
scipy is spared, count for ours. networkx's A* (claim: 100 times at 200 x 200) has the best admissible
heuristic of a grid, the lowest cost times the larger of both distances; there both stop at the goal, the
far corner, and both give the path.

1,000 dies of a plan on 20 x 20, stopped at the far corner, take at most 0.05 ms each with delays given, and
1 ms each with the axons' draws and delays. A plan on 4,000 x 4,000 takes at most 100 bytes a cell, map and
answer included, by the growth of the process's largest resident size. Peer of these three is the claim.

Times are process CPU time on one thread, medians of turns that alternate. Returns 1 where a claim is missed.
"""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from statistics import median

import networkx as nx
import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from _report import Row, parser_of, report
from chips.wavefront.axon_graph import AxonGraph, grid_graph
from chips.wavefront.kernel import Waves, graph_wave, graph_waves, integer_wave, real_wave
from chips.wavefront.model import chip_model, dies_delays
from chips.wavefront.readout import pointer_path
from circuits.arrays import F64, I64
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon

SIZES = (20, 200, 2000)
HIGHEST, SIGMA = 10, 0.1
DIES, FIRST_DIE = 1000, 1000
LARGE = 4000
SHORTEST = 20e-3  # s of CPU that a turn takes at least, by repetition


def main() -> int:
    """Measure and print all rows."""
    parser = parser_of(__doc__, "fewer turns")
    parser.add_argument("--large", action="store_true", help="only the large plan; prints its bytes a cell")
    options = parser.parse_args()
    if options.large:
        print(large_plan())
        return 0
    turns = 1 if options.quick else 5
    rows = [memory(), *grids(turns), star(1 if options.quick else 3), *dies(turns)]
    return report(rows, options, figures)


def figures(row: Row) -> str:
    """Both figures, in s of CPU or bytes a cell, and their ratio."""
    return f"{row.ours:10.4g}, peer {row.peer:10.4g}: {row.ratio:6.3g} times"


def grids(turns: int) -> Iterator[Row]:
    """Ideal and mismatched grids of all sizes against scipy."""
    for n in SIZES:
        draw = np.random.default_rng(n)
        graph, costs = grid_graph(n, n), draw.integers(1, HIGHEST + 1, (n, n))
        cells = costs * np.exp(SIGMA * draw.standard_normal((n, n)))
        sources = graph.sources()
        axons = costs.ravel()[sources] * np.exp(SIGMA * draw.standard_normal(graph.edges))
        few = min(turns, 3) if n == max(SIZES) else turns
        here = f"{n} x {n}"
        yield against_scipy(
            f"ideal, {here}", lambda c=costs: integer_wave(c, (0, 0)).arrivals, graph,
            costs.ravel()[sources] * 1.0, few, 7.0,
        )  # fmt: skip
        yield against_scipy(
            f"a delay a cell, {here}", lambda c=cells: real_wave(c, (0, 0)).arrivals, graph,
            cells.ravel()[sources], few, 3.0,
        )  # fmt: skip
        yield against_scipy(
            f"a delay an axon, {here}", lambda g=graph, a=axons: graph_wave(g, a, 0).arrivals, graph,
            axons, few, 2.0,
        )  # fmt: skip


def against_scipy(
    name: str, ours: Callable[[], F64], graph: AxonGraph, delays: F64, turns: int, claim: float
) -> Row:
    """One grid."""
    matrix = csr_array((delays, graph.targets, graph.offsets), shape=(graph.cells, graph.cells))

    answer, truth = ours().ravel(), np.empty(0)

    def peer() -> None:
        nonlocal truth
        truth = dijkstra(matrix, indices=0)

    row = compare(name, ours, peer, "", turns, claim)
    return replace(row, accuracy=f"arrivals equal at {int((answer == truth).sum())} of {graph.cells} cells")


def star(turns: int) -> Row:
    """A* of networkx at 200 x 200."""
    n = 200
    costs = np.random.default_rng(n).integers(1, HIGHEST + 1, (n, n))
    graph, flat = grid_graph(n, n), costs.ravel()
    places = nx.DiGraph()
    pairs = zip(graph.sources().tolist(), graph.targets.tolist(), strict=True)
    places.add_weighted_edges_from((a, b, int(flat[a])) for a, b in pairs)
    lowest, last = int(costs.min()), n * n - 1

    def far(a: int, b: int) -> int:
        return lowest * max(abs(a // n - b // n), abs(a % n - b % n))

    def ours() -> I64:
        goal = (n - 1, n - 1)
        return pointer_path(integer_wave(costs, (0, 0), goal).pointers, (0, 0), goal) @ np.array([n, 1])

    def peer() -> I64:
        return np.array(nx.astar_path(places, 0, last, heuristic=far, weight="weight"))

    found, best = (int(flat[path[:-1]].sum()) for path in (ours(), peer()))
    note = f"cost {found} against {best}"
    return compare("ideal, 200 x 200, networkx A*", ours, peer, note, turns, 100.0)


def dies(turns: int) -> Iterator[Row]:
    """Plans of 1,000 dies at 20 x 20, with delays given and with the draws."""
    n, goal = 20, 399
    graph = grid_graph(n, n)
    codes = np.random.default_rng(1).integers(1, HIGHEST + 1, n * n)
    model, silicon, sources = chip_model((n, n)), Silicon(AMI_1500_IDEAL), graph.sources()
    chosen = [Die(number=FIRST_DIE + k, process=False) for k in range(DIES)]

    def whole() -> Waves:
        return planned(dies_delays(model, silicon, codes, chosen)[:, sources])

    def planned(delays: F64) -> Waves:
        return graph_waves(graph, delays, 0, goal, threads=1)

    delays = dies_delays(model, silicon, codes, chosen)[:, sources]
    matrices = [csr_array((d, graph.targets, graph.offsets), shape=(n * n, n * n)) for d in delays]
    found = planned(delays).arrivals[:, goal]
    same = sum(dijkstra(m, indices=0)[goal] == t for m, t in zip(matrices, found, strict=True))
    note = f"arrival at the goal equal on {same} of {DIES} dies"
    here, peer = "a plan of a die, 20 x 20", [lambda m=m: dijkstra(m, indices=0) for m in matrices[:100]]
    given, drawn = (
        median(timed(work) for _ in range(turns)) / DIES for work in (lambda: planned(delays), whole)
    )
    scipys = timed(lambda: [each() for each in peer]) / len(peer)
    note = f"{note}; scipy {scipys:.3g}, {scipys / given:.3g} times"
    yield Row(f"{here}, delays given", given, 0.05e-3, 0.05e-3 / given, note, 1, 1.0)
    note = "draws and delays of 400 axons included"
    yield Row(f"{here}, with its draws", drawn, 1e-3, 1e-3 / drawn, note, 1, 1.0)


def memory() -> Row:
    """Bytes a cell of the large plan, in a process of its own."""
    command = [sys.executable, str(Path(__file__).resolve()), "--large"]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    ours = float(done.stdout)
    note = "map, arrivals and pointers included"
    return Row(f"bytes a cell, ideal, {LARGE} x {LARGE}", ours, 100.0, 100.0 / ours, note, 1, 1.0)


def large_plan() -> float:
    """Growth of the largest resident size by a map and its plan, bytes a cell."""
    integer_wave(np.ones((20, 20), dtype=np.int64), (0, 0))  # compiled, or loaded
    before = largest_resident()
    costs = np.random.default_rng(2).integers(1, HIGHEST + 1, (LARGE, LARGE))
    integer_wave(costs, (LARGE // 2, LARGE // 2))
    return 1024.0 * (largest_resident() - before) / costs.size


def largest_resident() -> int:
    """Largest resident size of this process so far, kB; getrusage's would begin with the parent's (Linux)."""
    status = Path("/proc/self/status").read_text(encoding="utf-8")
    return int(status.split("VmHWM:")[1].split()[0])


def compare(
    name: str, ours: Callable[[], object], peer: Callable[[], object], note: str, turns: int, claim: float
) -> Row:
    """Time both in turns that alternate."""
    pairs = [(timed(ours), timed(peer)) for _ in range(turns)]
    a, b = (median(each) for each in zip(*pairs, strict=True))
    return Row(name, a, b, b / a, note, 1, claim)


def timed(work: Callable[[], object]) -> float:
    """CPU time of a call, s, repeated until it can be measured."""
    calls, taken = 1, 0.0
    while taken < SHORTEST:
        start = time.process_time()
        for _ in range(calls):
            work()
        taken = time.process_time() - start
        calls *= 2
    return 2.0 * taken / calls


if __name__ == "__main__":
    sys.exit(main())
