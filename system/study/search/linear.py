"""Share of a block's dies that fail, by the linear theory about its nominal die, where biases or sizes move.

A die's metric is, in the linear theory about the nominal die, a normal number with that die's value and the
length of its gradient by the draws as its spread. So the share of dies that fail is at most

    sum over limits of Phi(-m / sigma),   m: the nominal die's distance to the limit, inside it

which is smooth in what moves and needs no dies: a bias or a size moves m through the nominal circuit, and
sigma through its gradient and Pelgrom's law. Conditions on words have no slope and are left out.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np

from circuits.arrays import F64
from circuits.catalogue import later
from circuits.errors import CircuitError, ParameterError
from system.study.campaign import thread_count
from system.study.search.centre import Bench, Centred, Problem
from system.study.search.slope import Slopes
from system.study.specification import Limits
from system.study.target import BlockTarget

optimise, special = later("scipy.optimize"), later("scipy.special")

OpenBlock = Callable[[F64], BlockTarget]  # what coordinates stand for, as `system.study.search.centre.Open`

DESIGNS = 40  # places whose gradients are taken in one search, for each coordinate; ours
LEAST = 1e-12  # share of failing dies below which nothing is told apart
STAY = 0.05  # decades, by which what moves to the end of its range must lessen that share, at least; ours
FEW = 1e-6  # share of failing dies below which a search for yield ends; ours


class LinearTheory:
    """The linear theory at coordinates, taken once at each.

    Attributes
    ----------
    impossible : int
        Coordinates that no circuit can have.
    runs : int
        Runs of the testbench that were made, as `system.study.search.slope.Slopes` counts them.
    """

    def __init__(self, problem: Problem, open_block: OpenBlock, threads: int | None) -> None:
        """Keep what is searched.

        Parameters
        ----------
        problem : block that is searched, and what its dies must fulfil.
        open_block : gives the block at coordinates.
        threads : how many measure the dies of a gradient that is no run backwards; all cores if None.

        Raises
        ------
        ParameterError
            Nothing moves, or no specification has a limit.
        """
        self._limits = [s for s in problem.specifications if isinstance(s, Limits)]
        if problem.dimensions < 1 or not self._limits:
            raise ParameterError(
                "search: needs something to move and a metric with a limit; write `spec` as in"
                ' "t_inh_s in 5ms:8ms"'
            )
        self._problem, self._open, self._threads = problem, open_block, threads
        self._known: dict[tuple[float, ...], tuple[BlockTarget | None, float]] = {}
        self.impossible = self.runs = 0

    @property
    def count(self) -> int:
        """How many coordinates were asked for."""
        return len(self._known)

    @property
    def course(self) -> F64:
        """The largest share of dies that pass so far, after each of the coordinates, float64[count]."""
        return 1.0 - np.minimum.accumulate([failing for _, failing in self._known.values()])

    def block(self, u: F64) -> BlockTarget | None:
        """Give the block at coordinates; None where no circuit has them."""
        return self._at(u)[0]

    def failing(self, u: F64) -> float:
        """Give the share of dies that fail, at most; 1 where a metric is not defined."""
        return self._at(u)[1]

    def decades(self, u: F64) -> float:
        """Give the logarithm of that share to base 10, which what moves moves more evenly."""
        return math.log10(max(self.failing(u), LEAST))

    def _at(self, u: F64) -> tuple[BlockTarget | None, float]:
        key = tuple(np.round(u, 9).tolist())
        if key not in self._known:
            try:
                self._known[key] = self._taken(u)
            except CircuitError:
                if not u.any():
                    raise
                self.impossible += 1
                self._known[key] = None, 1.0
        return self._known[key]

    def _taken(self, u: F64) -> tuple[BlockTarget, float]:
        target, failing = self._open(u), 0.0
        for each in self._limits:
            slopes = Slopes(target, self._problem.die, self._problem.condition, each.metric, self._threads)
            slope = slopes.at(np.zeros(len(slopes.labels)))
            self.runs += slopes.runs
            sigma = float(np.linalg.norm(slope.by))
            if not (math.isfinite(slope.value) and math.isfinite(sigma)):
                return target, 1.0
            failing += sum(_missed(m, sigma) for m in (slope.value - each.low, each.high - slope.value))
        return target, min(1.0, failing)


def _missed(margin: float, sigma: float) -> float:
    """Share of dies beyond a limit at a distance from the nominal one."""
    if sigma > 0.0:
        return float(special.ndtr(-margin / sigma))
    return 0.0 if margin > 0.0 else 1.0


def least(loss: Callable[[F64], float], begin: F64, until: dict[str, float], **more: Any) -> F64:
    """Return coordinates, from -1 to 1, at which a loss is least, by COBYQA (Ragonneau 2022, in scipy).

    It needs no derivatives by what moves.

    Parameters
    ----------
    loss
        What is made small, of coordinates.
    begin
        Where the search begins, float64[dimensions].
    until
        Options that end it, as `f_target`.
    more
        Other arguments of scipy's `minimize`, as `constraints`.
    """
    options = {"maxfev": DESIGNS * begin.size, "initial_tr_radius": 0.3, "final_tr_radius": 5e-3, **until}
    box = [(-1.0, 1.0)] * begin.size
    done = optimise.minimize(loss, begin, method="COBYQA", bounds=box, options=options, **more)
    return np.clip(np.asarray(done.x, dtype=np.float64), -1.0, 1.0)


def centre_by_gradient(
    problem: Problem,
    open_block: OpenBlock,
    dies: int,
    workers: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> Centred:
    """Search for the coordinates at which most dies pass, by the linear theory.

    Tuning dies are measured at the start and at the end alone, as a check: the start is kept where no more of
    them pass at the end. `measurements` counts them, and the runs behind gradients.

    Parameters
    ----------
    problem
        Block that is searched, and what its dies must fulfil.
    open_block
        Gives the block at coordinates.
    dies
        Tuning dies of the check.
    workers
        Threads, all cores unless given; the result does not depend on it.
    progress
        Is called with about the share of the work that is done, from 0 to 1.

    Raises
    ------
    ParameterError
        Nothing moves, or no specification has a limit.
    """
    theory, most = LinearTheory(problem, open_block, workers), DESIGNS * problem.dimensions

    def loss(u: F64) -> float:
        if progress is not None:
            progress(min(1.0, theory.count / most))
        return theory.decades(u) + STAY * float(u @ u)

    found = least(loss, problem.start, {"f_target": math.log10(FEW)})
    with ThreadPoolExecutor(thread_count(workers)) as executor:
        bench = Bench(problem, dies, executor, lambda _: None)
        before, after = (bench.share(bench.measure(u, dies, 1.0)) for u in (problem.start, found))
    if after <= before:
        found, after = problem.start, before
    return Centred(
        found, 1.0, before, after, before, after, theory.course, theory.count, theory.impossible,
        bench.measurements + theory.runs,
    )  # fmt: skip
