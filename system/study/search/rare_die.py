"""Probability that a die of a block fails its specifications, by the methods for rare failures.

A row of standard normals is a die: the draws of all the block's devices, and of the process where no corner
sets it. A die fails that does not pass every specification; one that cannot be measured, or whose metric is
not defined, fails.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType

import numpy as np

from circuits.arrays import F64, Bools
from system.options.block import read_die
from system.study.manifest import Study
from system.study.search.sensitivity import measure_rows, varying_labels
from system.study.specification import Specification, judge
from system.study.statistics.mean_shift import mean_shift
from system.study.statistics.rare import Fails, RareFailure
from system.study.statistics.scaled_sigma import scaled_sigma
from system.study.target import open_target

Method = Callable[[Fails, int, int, np.random.Generator], RareFailure]

METHODS: Mapping[str, Method] = MappingProxyType({"scaled-sigma": scaled_sigma, "mean-shift": mean_shift})


def rare_failure(
    study: Study,
    specifications: Sequence[Specification],
    method: str,
    threads: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> RareFailure:
    """Estimate the probability that a die of a block fails.

    Parameters
    ----------
    study
        What is measured, at its first condition, and which variation is on; its plan gives the number
        of dies in all, and the seed that keys their draws.
    specifications
        Conditions that a die must fulfil, all of them, or it fails.
    method
        Name of the method, one of `METHODS`.
    threads
        Number of threads that measure dies, all cores unless given.
    progress
        Function that is called with the share of the samples that is done, from 0 to 1.

    Raises
    ------
    ParameterError
        The target is a system, or the method refuses the number of samples or of draws.
    SolverError
        The method came to no estimate, as where its effective sample size is too small.
    """
    target, die, condition = open_target(study.subject), read_die(study.subject.silicon), study.conditions[0]
    labels = varying_labels(target, condition.corner)
    done = itertools.count(1)

    def count() -> None:
        share = next(done) / study.plan.count
        if progress is not None:
            progress(min(1.0, share))

    def fails(rows: F64) -> Bools:
        found = measure_rows(target, die, condition, labels, rows, threads, count)
        values = np.array([m.values for m in found]).reshape(len(rows), len(target.quantities))
        columns = {q.name: values[:, k] for k, q in enumerate(target.quantities)}
        return ~judge(specifications, [m.outcome for m in found], columns).passed

    rng = np.random.Generator(np.random.Philox(key=study.plan.seed))
    return METHODS[method](fails, len(labels), study.plan.count, rng)
