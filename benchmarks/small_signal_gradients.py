"""Claim: gradients of a transfer by all devices take at most 1.5 analyses of small signals.

Of each block that has a transfer the two that vary most in dB over dies, from two sources: a row of both in
dB and their phases at 10 kHz, and one of their bandwidths, which are searches over the frequency; on the
nominal die and dies 1000 to 1002. `ours` is the CPU time of these gradients, their operating point included,
`peer` that of the operating point and of one source's transfers at 121 frequencies, best of three. The
accuracy is the largest difference to a central difference, times the sigma of what is moved, in the measure's
sigma over dies: of the two devices that move each measure most, of three others, and of all that the process
shares.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from _report import Row, best_of, parser_of, report
from circuits.blocks.block import Block
from circuits.errors import SolverError
from circuits.gradient.gradient import Gradients
from circuits.gradient.small_signal.small_signal import small_signal_gradients
from circuits.gradient.small_signal.transfer import Corner, SmallSignal, Transfer
from circuits.lowering.kernel import to_kernel
from circuits.registry import block_names, load_block
from circuits.silicon.die import Die
from circuits.silicon.silicon import Silicon
from circuits.solver.operating_point import OperatingPoint, operating_point
from circuits.solver.small_signal import ac, frequency_grid

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from tests.circuits.gradient.differences import by_small_signals

DIES = (None, 1000, 1001, 1002)
STEP = 0.002  # sigma, of a central difference
LEAST = {"V/V": 1e-4, "V/A": 1e2}  # transfers below which nothing is said to come from a source
GRID = frequency_grid(1.0, 1e6, 20)
MOST = 1.5


def main() -> int:
    """Measure and print a row a block and die."""
    options = parser_of(__doc__, "two blocks on the nominal die").parse_args()
    names = ("photoreceptor", "envelope-detector") if options.quick else block_names()
    return report(rows(names, DIES[:1] if options.quick else DIES), options)


def rows(names: Sequence[str], dies: Sequence[int | None]) -> Iterator[Row]:
    """A row a block and die."""
    for name in names:
        block = load_block(name)
        for number in dies:
            machine = to_kernel(block.bench(), Silicon(block.process, 27.0, Die(number=number)))
            try:
                point = operating_point(machine)
            except SolverError:
                continue
            pairs = transfers_of(block, point)
            if not pairs:
                continue
            peer = best_of(lambda m=machine, of=pairs[0][1]: ac(operating_point(m), of, GRID))
            told = ", ".join(f"{node} from {source}" for node, source in pairs)
            of_die = f"{name}, die {'nominal' if number is None else number}, {told}"
            for what, most, measures in measures_of(pairs):
                found = small_signal_gradients(machine, measures)
                ours = best_of(lambda m=machine, of=measures: small_signal_gradients(m, of))
                words = accuracy(point, measures, found)
                yield Row(f"{of_die}: {what}", ours, peer, ours / peer, words, most=most)


def transfers_of(block: Block, point: OperatingPoint) -> list[tuple[str, str]]:
    """Nodes and sources of the two transfers that vary most over dies, of two sources."""
    machine, pairs = point.machine, []
    free = [n for n in machine.names[1:] if machine.column_of(n) < machine.kernel.unknowns]
    nodes = [n for n in block.plotted if n in free] or free
    for source in machine.source_names:
        response = ac(point, source, np.array([100.0]), nodes)
        sizes = np.abs(response.transfer[0])
        pairs += [(n, source) for n, size in zip(nodes, sizes, strict=True) if size > LEAST[response.unit]]
    if not pairs:
        return []
    spread = small_signal_gradients(machine, [Transfer("db", *pair, 100.0) for pair in pairs]).spread
    first = [pairs[k] for k in np.argsort(-spread)]
    best = dict.fromkeys(source for _, source in first)
    return [next(pair for pair in first if pair[1] == source) for source in list(best)[:2]]


def measures_of(pairs: Sequence[tuple[str, str]]) -> Iterator[tuple[str, float, list[SmallSignal]]]:
    """What is measured of transfers, in words, with what is claimed of its cost."""
    yield "10 kHz", MOST, [Transfer(kind, *pair, 1e4) for pair in pairs for kind in ("db", "phase")]
    yield "bandwidths", float("inf"), [Corner(*pair) for pair in pairs]


def accuracy(point: OperatingPoint, measures: Sequence[SmallSignal], found: Gradients) -> str:
    """The largest difference to a central difference, in words."""
    moved, chosen = np.nan_to_num(np.abs(found.by * found.sigma)), set()
    for own in moved:
        order = [int(k) for k in np.argsort(-own) if own[k] > 0.0]
        chosen |= {*order[:2], *(order[len(order) * q // 4] for q in (1, 2, 3) if order)}
    chosen |= {
        k for k, label in enumerate(found.labels) if label.startswith("process.") and found.sigma[k] > 0.0
    }
    worst, where = 0.0, "nothing"
    for k in sorted(chosen):
        label, sigma = found.labels[k], float(found.sigma[k])
        other = by_small_signals(point.machine, measures, label, STEP * sigma, point.voltage)
        with np.errstate(divide="ignore", invalid="ignore"):  # of what nothing moves
            off = np.abs(other - found.by[:, k]) * sigma / found.spread
        for m in np.flatnonzero(np.isfinite(off)):
            if not off[m] < worst:
                worst, where = float(off[m]), f"{measures[m].name} by {label}"
    if not worst > 0.0:
        return found.notes[0] or "nothing of it varies over dies"
    noted = "; ".join(dict.fromkeys(filter(None, found.notes))) or "smooth"
    return f"off by {100.0 * worst:.2g} % of the measure's sigma at most, {where}; {noted}"


if __name__ == "__main__":
    sys.exit(main())
