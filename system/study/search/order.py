"""The order in which a study measures its dies: the worst first, as the gradient about the nominal die tells.

What a die is does not change, and neither does the study: chunks are measured in another order, and the table
is the same. So failures are seen first, and a study that is interrupted has them.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from circuits.arrays import F64
from circuits.errors import ParameterError
from system.options.block import read_die
from system.study.engine import dies_of
from system.study.manifest import Study
from system.study.search.slope import Slopes
from system.study.specification import Limits, Specification
from system.study.target import BlockTarget, Target


def worst_first(study: Study, target: Target, specifications: Sequence[Specification]) -> tuple[int, ...]:
    """Numbers of a study's chunks, those with the dies that are nearest to failing first.

    Parameters
    ----------
    study
        The study, whose first condition is looked at.
    target
        What it measures.
    specifications
        Specifications, of which limits of metrics tell how near a die is to failing.

    Raises
    ------
    ParameterError
        The target is a system, no specification limits a metric, or a metric has no gradient.
    """
    if not isinstance(target, BlockTarget):
        raise ParameterError(f"order: worst, {study.subject.target} is a system, whose draws are not listed")
    limits = [each for each in specifications if isinstance(each, Limits)]
    if not limits:
        raise ParameterError("order: worst, of which specification; give `spec` with limits of a metric")
    draws = np.array([target.draws(die) for die in dies_of(study, study.dies)])
    margin = np.min([_margins(study, target, each, draws) for each in limits], axis=0)
    first = study.dies.start
    worst = [float(margin[c.start - first : c.stop - first].min()) for c in study.chunks()]
    return tuple(int(k) for k in np.argsort(worst, kind="stable"))


def _margins(study: Study, target: BlockTarget, limits: Limits, draws: F64) -> F64:
    """How far each die is from a limit in the linear theory, in sigma of the metric, float64[dies]."""
    slopes = Slopes(target, read_die(study.subject.silicon), study.conditions[0], limits.metric)
    nominal = slopes.at(np.zeros(len(slopes.labels)))
    spread = float(np.linalg.norm(nominal.by))
    if not np.isfinite(spread) or spread == 0.0 or not np.isfinite(nominal.value):
        raise ParameterError(
            f"order: worst, {limits.metric} has no gradient here; {nominal.note or 'leave the order out'}"
        )
    columns = [target.labels().index(label) for label in slopes.labels]
    told = nominal.value + draws[:, columns] @ nominal.by
    return np.asarray(np.minimum(limits.high - told, told - limits.low) / spread)
