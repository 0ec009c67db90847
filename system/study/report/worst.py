"""The samples of a study that deserve a look first, and the options that measure each again.

Failed ones come first, then those with a metric that is not defined, then those of a class that the
specifications exclude or without success, then those farthest out: beyond the limits of a metric, or where it
has none from its median, in standard deviations of the samples at the same condition.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np

from circuits.arrays import F64
from system.options.code import code_of
from system.study.manifest import Study
from system.study.metrics.metric import is_own
from system.study.report.result import judge_table
from system.study.specification import Limits, Specification
from system.study.table import FAILED, Table

_FAR = 3  # rank of samples that have nothing but their distance


@dataclass(frozen=True, slots=True)
class Worst:
    """Sample that deserves a look first.

    row : row of the sample in the table.
    why : reason in words: that it failed, that it is not defined, its cause, or how far out it is.
    """

    row: int
    why: str


def worst(
    table: Table, specifications: Sequence[Specification], most: int, words: Collection[str] = ()
) -> tuple[Worst, ...]:
    """Give the worst samples of one condition, the worst first.

    Parameters
    ----------
    table : samples of the condition.
    specifications : conditions that a sample must fulfil to pass.
    most : how many samples of each of the four kinds are given at most.
    words : names of metrics that say yes or no, by which no sample is far out.
    """
    causes = judge_table(table, specifications).causes
    rank = _rank(table, specifications)
    distance, metric = _distance(table, specifications, words)
    order = sorted(range(len(table)), key=lambda k: (rank[k], -distance[k], k))
    chosen = [k for kind in range(_FAR + 1) for k in [k for k in order if rank[k] == kind][:most]]
    return tuple(Worst(k, _why(table, k, rank[k], causes[k], distance[k], metric[k])) for k in chosen)


def replay_options(study: Study, table: Table, row: int) -> list[tuple[str, str]]:
    """Give the options of a replay that name the sample in a row of the table, as pairs of name and text.

    Corner, temperature and trial are given where the study has several. Metrics that are functions of the
    user's own are given too, for no file of the study loads them.
    """
    where = study.conditions
    found = [("die", str(int(table.die[row])))]
    if len({c.corner for c in where}) > 1:
        found += [("corner", table.corner[row])]
    if len({c.temperature_c for c in where}) > 1:
        found += [("temperature", repr(float(table.temperature_c[row])))]
    if len({c.trial for c in where}) > 1:
        found += [("trial", str(int(table.trial[row])))]
    code = [("code", study.subject.target)] if code_of(study.subject.target) else []
    return found + code + [("metric", name) for name in filter(is_own, study.subject.metrics)]


def _rank(table: Table, specifications: Sequence[Specification]) -> list[int]:
    excluded = ~judge_table(table, [e for e in specifications if not isinstance(e, Limits)]).passed
    undefined = np.isnan(table.values).sum(axis=1)
    ranks = []
    for k, outcome in enumerate(table.outcome):
        found = (outcome == FAILED, undefined[k] > 0, excluded[k], True)
        ranks.append(found.index(True))
    return ranks


def _distance(
    table: Table, specifications: Sequence[Specification], words: Collection[str]
) -> tuple[F64, list[str]]:
    """How far out each sample is, in sigma, and by which metric; minus infinity where none tells."""
    distances = np.full((len(table.metrics), len(table)), -math.inf)
    limited = {each.metric for each in specifications if isinstance(each, Limits)}
    for j, metric in enumerate(table.metrics):
        x = table.column(metric)
        finite = x[np.isfinite(x)]
        sigma = float(finite.std()) if finite.size else 0.0
        if sigma == 0.0 or metric in words or (limited and metric not in limited):
            continue
        limits = [e for e in specifications if isinstance(e, Limits) and e.metric == metric]
        sides = [np.maximum(e.low - x, x - e.high) for e in limits] or [np.abs(x - np.median(finite))]
        distances[j] = np.nan_to_num(np.max(sides, axis=0) / sigma, nan=-math.inf, posinf=math.inf)
    names = [table.metrics[j] for j in distances.argmax(axis=0)] if len(table.metrics) else [""] * len(table)
    return distances.max(axis=0, initial=-math.inf), names


def _why(table: Table, row: int, rank: int, cause: str, distance: float, metric: str) -> str:
    if table.outcome[row] == FAILED:
        return f"failed: {table.reason[row]}"
    if cause:
        return cause
    if rank < _FAR:
        missing = [m for m, x in zip(table.metrics, table.values[row], strict=True) if math.isnan(x)]
        return table.reason[row] or f"{', '.join(missing)} not defined"
    if not math.isfinite(distance):
        return ""
    side = "inside the limits" if distance < 0.0 else "from the median"
    return f"{metric} {abs(distance):.2f} sigma {side}"
