"""Claim: a mission's 95 % interval covers at least 94 %, at most 1.15 times as wide as Clopper-Pearson's.

Synthetic studies with yields of 0.5 to 0.95 and correlations of 0.02 to 0.6 of two trials of a die, 1,000
of each kind, of a fixed number of dies, and ended by the interval's own half-width (`--until`), looked at
after every eight dies. Three kinds of dies: chances of a beta distribution; dies that never pass among dies
that all have one chance; and beta dies whose trials are in two worlds, which differ too.
Coverage: `ours` is the share of the intervals that hold the true yield, `peer` 0.95; of the fewer studies of
`--quick` nothing is claimed. Width: `ours` is the mean width, `peer` that of Clopper and Pearson's interval
for the true yield and the effective number of trials that follows from the true correlation,
D m / (1 + (m - 1) rho), and `ratio` is ours over peer.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator

import numpy as np
from scipy import stats

from _report import Row, parser_of, report
from circuits.arrays import F64
from system.study.statistics.clustered import ClusteredYield, clustered_yield, narrow
from tests.system.study.statistics.alike import studies

FIRST = 1000  # seed; the method was tuned on smaller ones
KINDS = ("beta", "dead", "worlds")
FIXED = ((40, 4), (100, 4), (300, 8))  # dies, trials
UNTIL = ((0.05, 4), (0.03, 4), (0.04, 8))  # half-width, trials
STEP, MOST = 8, 4000  # dies
LEAST, WIDEST = 0.94, 1.15
CLAIMED = 1000  # studies of a kind, of which something is claimed


def main() -> int:
    """Measure and print all rows."""
    options = parser_of(__doc__, "200 studies of each kind").parse_args()
    seeds = range(FIRST, FIRST + (200 if options.quick else 1000))
    rows = [row for kind in KINDS for row in (*fixed(kind, seeds), *until(kind, seeds))]
    return report(rows, options, lambda row: f"{row.ours:7.4f}, peer {row.peer:7.4f}")


def fixed(kind: str, seeds: range) -> Iterator[Row]:
    """Studies of a number of dies."""
    for dies, trials in FIXED:
        found = [
            (p, clustered_yield(shares, trials), rho) for p, shares, rho in studies(seeds, kind, dies, trials)
        ]
        yield from _rows(f"{kind}, {dies} dies, {trials} trials", found)


def until(kind: str, seeds: range) -> Iterator[Row]:
    """Studies that end themselves."""
    for half_width, trials in UNTIL:
        found = [
            (p, _ended(shares, trials, half_width), rho)
            for p, shares, rho in studies(seeds, kind, MOST, trials)
        ]
        yield from _rows(f"{kind}, until {100 * half_width:g} %, {trials} trials", found)


def _ended(shares: F64, trials: int, half_width: float) -> ClusteredYield:
    """What a study comes to whose interval is looked at after each chunk."""
    found = clustered_yield(shares[:STEP], trials)
    for dies in range(2 * STEP, len(shares) + 1, STEP):
        if narrow(found, half_width):
            break
        found = clustered_yield(shares[:dies], trials)
    return found


def _rows(name: str, found: list[tuple[float, ClusteredYield, float]]) -> Iterator[Row]:
    held = float(np.mean([p in each.interval for p, each, _ in found]))
    ours = float(np.mean([2.0 * each.interval.half_width for _, each, _ in found]))
    peer = float(np.mean([_exact(p, each, rho) for p, each, rho in found]))
    dies = float(np.mean([each.dies for _, each, _ in found]))
    note = f"{len(found)} studies, {dies:.0f} dies on average"
    yield Row(
        f"coverage, {name}",
        held,
        0.95,
        held / 0.95,
        note,
        least=LEAST / 0.95 if len(found) >= CLAIMED else 0.0,
    )
    yield Row(f"width, {name}", ours, peer, ours / peer, note, most=WIDEST)


def _exact(p: float, found: ClusteredYield, rho: float) -> float:
    """Width of Clopper and Pearson's interval at the true yield, for the true effective number."""
    n = found.dies * found.trials / (1.0 + (found.trials - 1.0) * rho)
    ends = stats.beta.isf(0.025, p * n + 1.0, n - p * n), stats.beta.ppf(0.025, p * n, n - p * n + 1.0)
    return float(ends[0] - ends[1])


if __name__ == "__main__":
    sys.exit(main())
