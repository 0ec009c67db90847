"""Claim: contributions to the delay t_inh of the rebound neuron agree with one device varied at a time.

Mismatch only, the facts' biases, 27 degC. Ours: shares of the devices in the variance of ln t_inh from its
gradients about the nominal die, scaled by the R^2 of a study of dies on which everything varies. Peer: each
device alone varied, with the draws that it has on the same dies; its share is the variance of ln t_inh that
it makes, over the sum of these. Within 2 points of a share for every device. Besides, at the block's own
biases.
The last row of a set of biases holds that sum against the variance with everything varied: apart from
interactions, and from chance correlation of devices on so many dies, it is 1.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator

import numpy as np

from _report import Row, parser_of, report
from circuits.silicon.die import Die
from system.options.silicon import SiliconChoice
from system.study.engine import dies_of, on_threads, run_study
from system.study.manifest import Study
from system.study.plan import Plan
from system.study.search.breakdown import Breakdown, breakdowns
from system.study.search.sensitivity import measure_rows
from system.study.statistics.contribution import device, grouped
from system.study.table import Condition, Table
from system.study.target import Subject, Target, open_target

TARGET, METRIC = "rebound-neuron", "t_inh"
CONDITION = Condition("random", 27.0, 0)
FIRST, CLAIM = 1000, 0.02
SHOWN = 5
CORES = os.cpu_count() or 1


def main() -> int:
    """Measure and print all rows."""
    options = parser_of(__doc__, "20 dies instead of 200, the facts' biases only").parse_args()
    quick: bool = options.quick
    rows = [row for biases in ("facts", None)[: 2 - quick] for row in compare(biases, 20 if quick else 200)]
    return report(rows, options, lambda row: f"{row.ours:8.4f}, peer {row.peer:8.4f}")


def compare(biases: str | None, dies: int) -> Iterator[Row]:
    """Rows of one set of biases: the largest devices, the worst difference, and the sum of variances."""
    subject = Subject(TARGET, (METRIC,), bias_set=biases, silicon=SiliconChoice(process_variation=False))
    study = Study(subject, Plan("random", 0, FIRST, dies), (CONDITION,), 10)
    target = open_target(subject)
    table, ours = whole(study, target)
    alone, defined = one_at_a_time(study, target)
    total = sum(alone.values())
    shares = {share.name: share.value for share in grouped(ours.found, device)}
    difference = {name: shares[name] - value / total for name, value in alone.items()}
    worst = max(difference, key=lambda name: abs(difference[name]))
    named = biases or "own"
    note = f"{len(alone)} devices, {dies} dies each, {defined:.1%} defined, R^2 {ours.found.r2:.4f}"
    for name in sorted(alone, key=lambda name: -alone[name])[:SHOWN]:
        mine, other = shares[name], alone[name] / total
        yield Row(f"{named} biases, share of {name}", mine, other, mine / other, note, CORES)
    points = 100.0 * abs(difference[worst])
    told = f"worst of all devices: {worst}; {note}"
    name = f"{named} biases, worst difference (points)"
    yield Row(name, points, 0.0, points, told, CORES, most=100.0 * CLAIM)
    y = table.column(METRIC)
    everything = float(np.log(y[np.isfinite(y)]).var(ddof=1))
    yield Row(
        f"{named} biases, variance alone summed, and of all",
        total,
        everything,
        total / everything,
        note,
        CORES,
    )


def whole(study: Study, target: Target) -> tuple[Table, Breakdown]:
    """Samples with everything varied, and their contributions."""
    with on_threads() as workers:
        table = run_study(study, workers=workers).table
    (found,), refused = breakdowns(study, target, table, METRIC)
    if refused or not found.logarithm:
        raise SystemExit(f"not as described above: {refused}")
    return table, found


def one_at_a_time(study: Study, target: Target) -> tuple[dict[str, float], float]:
    """Variance of ln t_inh with only one device varied, by device; and the share of dies that define it."""
    labels = target.labels()
    draws = np.array([target.draws(die) for die in dies_of(study, study.dies)])
    owner = np.array([device(label) for label in labels])
    variance, defined = {}, []
    for name in dict.fromkeys(owner.tolist()):
        rows = np.where(owner == name, draws, 0.0)
        found = measure_rows(target, Die(process=False), CONDITION, labels, rows)
        y = np.array([m.values[0] for m in found])
        defined.append(float(np.isfinite(y).mean()))
        variance[name] = float(np.log(y[np.isfinite(y)]).var(ddof=1))
    return variance, float(np.mean(defined))


if __name__ == "__main__":
    sys.exit(main())
