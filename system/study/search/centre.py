"""Search for the biases at which most dies of a block pass its specifications (design centring).

The yield of a few hundred dies is a bad objective: a staircase in the biases, and near 100 % it is flat. So
the standard normals of the tuning dies, of mismatch and of process, are multiplied by a scale s >= 1 at which
no more than half of them (in the last stage three quarters) pass at the best biases so far. A failing
half-space at distance b, the worst-case distance in sigma, has the probability Phi(-b / s): what raises the
share that passes at s moves failures away, also those that no die shows at s = 1. The score of a die is 0
where a word is not met, else

    prod over limits of Phi(m / 0.25),   m = min(x - low, high - x) / (spread of x at the start, s = 1)

nearly 1 inside the limits and 0 outside, but smooth; 0 where the metric is not defined. Maximised is the mean

    score + 0.02 m_least / (1 + |m_least|),   m_least: the least of the die's margins m

whose second term, the margins of a C_pk, points the way where all dies pass, or none. All candidates meet the
same dies. Words alone have no margin: then the share at s decides, and a start at which no die passes leaves
the search blind.

Search: coordinates in [-1, 1]; differential evolution (Storn and Price 1997) on the first dies from a cloud
around the start, then the simplex of Nelder and Mead (1965) from its best candidates on all tuning dies, each
stage at a scale of its own. The last stage's best is kept if it beats the start there and is not worse at
s = 1.
Source of the worst-case distance: Antreich, Graeb, Wieser, "Circuit analysis and optimization driven by
worst-case distances", IEEE Trans. CAD 13, 57 (1994).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, final

import numpy as np

from circuits.arrays import F64
from circuits.catalogue import later
from circuits.errors import CircuitError, ParameterError
from circuits.silicon.die import Die
from circuits.silicon.sampling import Sampling
from system.study.campaign import thread_count
from system.study.specification import Limits, Specification, judge
from system.study.table import FAILED, Condition
from system.study.target import Measurement, Target, measure_safely

if TYPE_CHECKING:
    from scipy.optimize import OptimizeResult

optimise, special = later("scipy.optimize"), later("scipy.special")

Open = Callable[[F64], Target]  # what coordinates stand for; raises `CircuitError` where they cannot be

SCALES = (1.0, 1.5, 2.0, 3.0, 4.0)  # s; beyond, what fails is too far from any die to matter
TESTING = 0.5  # share that passes above which a scale tells the first stage too little
TESTING_LAST = 0.75  # the same of the last: nearer to s = 1, where the yield counts
SOFT = 0.25  # width of a limit, in spreads
MARGIN = 0.02  # weight of the margins
CLOUD = 0.35  # sigma of the first candidates around the start
ENOUGH = 0.995  # score at which a stage ends


@dataclass(frozen=True, slots=True)
class Problem:
    """Circuit whose biases are searched, and what its dies must fulfil.

    Attributes
    ----------
    open_at : gives the target at coordinates, float64[dimensions] from -1 to 1, where zeros are the start;
        the target is ready for threads to share.
    dimensions : number of coordinates.
    specifications : conditions that a die must fulfil to pass.
    die : gives the lot, and which variation is on.
    condition : corner and temperature at which dies are measured.
    """

    open_at: Open
    dimensions: int
    specifications: Sequence[Specification]
    die: Die
    condition: Condition

    @property
    def start(self) -> F64:
        """Coordinates at which the search begins, float64[dimensions]; all are zero."""
        return np.zeros(self.dimensions)


@dataclass(frozen=True, slots=True)
class Budget:
    """Number of dies and of candidates that a search measures.

    tuning : number of dies that the search is made on, which are numbered from 0.
    screening : how many of them, from the first on, serve the first stage.
    population : number of candidates in a generation of the first stage.
    generations : number of generations of the first stage.
    refinements : number of candidates of the second stage beyond its first simplex.
    """

    tuning: int = 200
    screening: int = 40
    population: int = 18
    generations: int = 10
    refinements: int = 24

    @property
    def measurements(self) -> int:
        """About how many dies are measured in all, for a progress bar."""
        first = self.screening * (self.population * (self.generations + 1) + 2 * len(SCALES))
        return first + self.tuning * (self.refinements + 12)


@dataclass(frozen=True, slots=True)
class Centred:
    """Where a search ended, and how it went.

    coordinates : float64[dimensions], from -1 to 1; all are 0 where nothing beat the start.
    scale : scale s of the variation in the last stage.
    share_before : share of the tuning dies that pass at the start, at that scale.
    share_after : share of the tuning dies that pass at `coordinates`, at that scale.
    yield_before : share of the tuning dies that pass at the start, at s = 1.
    yield_after : share of the tuning dies that pass at `coordinates`, at s = 1.
    best : float64[n], best objective of the first stage so far, after each of its candidates.
    candidates : how often a set of biases was measured.
    impossible : how many of these sets no circuit can have.
    measurements : number of dies that were measured in all.
    """

    coordinates: F64
    scale: float
    share_before: float
    share_after: float
    yield_before: float
    yield_after: float
    best: F64
    candidates: int
    impossible: int
    measurements: int


@final
class Bench:
    """The tuning dies of a search at any scale of their variation, with counts of the measurements."""

    def __init__(
        self, problem: Problem, dies: int, executor: ThreadPoolExecutor, progress: Callable[[int], None]
    ) -> None:
        """Draw the tuning dies.

        Parameters
        ----------
        problem : circuit that is searched.
        dies : number of tuning dies.
        executor : threads that measure the dies.
        progress : is called with the number of dies measured so far.
        """
        self._problem, self._executor, self._progress = problem, executor, progress
        self.measurements = self.candidates = self.impossible = 0
        start = problem.open_at(problem.start)
        self.metrics = tuple(q.name for q in start.quantities)
        self._columns = {label: k for k, label in enumerate(start.labels())}
        self._dies = [replace(problem.die, number=k) for k in range(dies)]
        self._normals = np.array([start.draws(d) for d in self._dies])
        self.spread: dict[str, float] = {}

    def measure(self, coordinates: F64, dies: int, scale: float) -> list[Measurement]:
        """Measure the first `dies` tuning dies at coordinates, with their variation scaled by `scale`.

        Every measurement is a failed one where no circuit can have these coordinates.
        """
        sampling = Sampling(f"scaled/{scale:g}", 0, self._columns, scale * self._normals)
        chosen = [replace(d, sampling=sampling) for d in self._dies[:dies]]
        self.candidates += 1
        try:
            target = self._problem.open_at(coordinates)
        except CircuitError as error:
            self.impossible += 1
            return [Measurement(FAILED, (np.nan,) * len(self.metrics), str(error))] * dies
        self.measurements += dies
        self._progress(self.measurements)
        run = partial(measure_safely, target, condition=self._problem.condition)
        return list(self._executor.map(run, chosen))

    def share(self, found: Sequence[Measurement]) -> float:
        """Give the share of the measurements that pass the specifications, from 0 to 1."""
        verdict = judge(self._problem.specifications, [m.outcome for m in found], self._values(found))
        return float(verdict.passed.mean())

    def objective(self, found: Sequence[Measurement]) -> float:
        """Give the mean of score and margins over the measurements; the module's text has the formula."""
        outcomes = [m.outcome for m in found]
        return objective(self._problem.specifications, outcomes, self._values(found), self.spread)

    def set_spread(self, found: Sequence[Measurement]) -> None:
        """Keep the spread of each metric over these measurements, in which margins are counted."""
        values = self._values(found)
        limits = [s for s in self._problem.specifications if isinstance(s, Limits)]
        self.spread = {s.metric: _spread(values[s.metric], s) for s in limits}

    def _values(self, found: Sequence[Measurement]) -> dict[str, F64]:
        return {name: np.array([m.values[k] for m in found]) for k, name in enumerate(self.metrics)}


def objective(
    specifications: Sequence[Specification],
    outcomes: Sequence[str],
    values: dict[str, F64],
    spread: dict[str, float],
) -> float:
    """Give the objective that a search maximises, a mean over n dies; the module's text has the formula.

    Parameters
    ----------
    specifications : conditions that a die must fulfil to pass.
    outcomes : word for the outcome of each die.
    values : float64[n] by metric, in SI units.
    spread : spread of each metric that has limits, in SI units.
    """
    score = np.array([outcome != FAILED for outcome in outcomes], dtype=np.float64)
    least = np.full(len(outcomes), np.inf)
    for each in specifications:
        if not isinstance(each, Limits):
            score *= judge([each], outcomes, values).passed
            continue
        x = values[each.metric]
        m = np.minimum(x - each.low, each.high - x) / spread[each.metric]
        defined = np.isfinite(m)
        score *= np.where(defined, special.ndtr(m / SOFT), 0.0)
        least = np.minimum(least, np.where(defined, m, -np.inf))
    margin = np.divide(least, 1.0 + np.abs(least), out=np.sign(least), where=np.isfinite(least))
    limited = any(isinstance(each, Limits) for each in specifications)
    return float(np.mean(score + MARGIN * margin * limited))


def centre(
    problem: Problem,
    *,
    budget: Budget = Budget(),
    seed: int = 0,
    workers: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> Centred:
    """Search for the coordinates at which most dies pass.

    Parameters
    ----------
    problem : circuit that is searched.
    budget : number of dies and candidates that are measured.
    seed : of the optimiser; the dies have keys of their own.
    workers : number of threads, all cores unless given; the result does not depend on it.
    progress : is called with about the share of the work that is done, from 0 to 1.

    Raises
    ------
    ParameterError
        There is nothing to move, or nothing to fulfil.
    """
    if problem.dimensions < 1 or not problem.specifications:
        raise ParameterError("centre: needs a bias to move and a specification; give `move` and `spec`")

    def report(done: int) -> None:
        if progress is not None:
            progress(min(1.0, done / budget.measurements))

    with ThreadPoolExecutor(thread_count(workers)) as executor:
        return _search(Bench(problem, budget.tuning, executor, report), problem, budget, seed)


def _search(bench: Bench, problem: Problem, budget: Budget, seed: int) -> Centred:
    start = problem.start
    found = bench.measure(start, budget.tuning, 1.0)
    before = after = bench.share(found)
    bench.set_spread(found)
    few = min(budget.screening, budget.tuning)
    scale = _scale(bench, start, few, TESTING)
    evolved, best = _evolve(bench, few, budget, scale, start.size, seed)
    scale = _scale(bench, evolved[0], few, TESTING_LAST)
    found = bench.measure(start, budget.tuning, scale)
    reached, share = bench.objective(found), bench.share(found)
    place, improved = start, share
    trial, value = _refine(bench, evolved[: start.size + 1], budget, scale)
    if value > reached:
        share_there = bench.share(bench.measure(trial, budget.tuning, scale))
        there = bench.share(bench.measure(trial, budget.tuning, 1.0))
        if there >= before:
            place, improved, after = trial, share_there, there
    return Centred(
        place, scale, share, improved, before, after, best,
        bench.candidates, bench.impossible, bench.measurements,
    )  # fmt: skip


def _scale(bench: Bench, coordinates: F64, dies: int, most: float) -> float:
    """The least scale at which no larger share than `most` passes, else the largest."""
    for scale in SCALES:
        if bench.share(bench.measure(coordinates, dies, scale)) <= most:
            return scale
    return SCALES[-1]


def _evolve(
    bench: Bench, dies: int, budget: Budget, scale: float, dimensions: int, seed: int
) -> tuple[F64, F64]:
    """Last population, the best first, and the best objective after each candidate."""
    values: list[float] = []

    def loss(coordinates: F64) -> float:
        values.append(bench.objective(bench.measure(coordinates, dies, scale)))
        return -values[-1]

    def enough(intermediate_result: OptimizeResult) -> bool:
        return bool(-intermediate_result.fun >= ENOUGH)

    rng = np.random.Generator(np.random.Philox(key=seed))
    cloud = CLOUD * rng.standard_normal((max(budget.population, dimensions + 2, 5), dimensions))
    cloud[0] = 0.0
    done = optimise.differential_evolution(
        loss, [(-1.0, 1.0)] * dimensions, init=np.clip(cloud, -1.0, 1.0), maxiter=budget.generations,
        tol=0.0, mutation=(0.4, 0.9), polish=False, rng=rng, callback=enough,
    )  # fmt: skip
    order = np.argsort(done.population_energies, kind="stable")
    return np.asarray(done.population)[order], np.maximum.accumulate(values)


def _refine(bench: Bench, simplex: F64, budget: Budget, scale: float) -> tuple[F64, float]:
    """Best coordinates and their objective on all dies."""

    def loss(coordinates: F64) -> float:
        return -bench.objective(bench.measure(coordinates, budget.tuning, scale))

    done = optimise.minimize(
        loss, simplex[0], method="Nelder-Mead", bounds=[(-1.0, 1.0)] * simplex.shape[1],
        options={"initial_simplex": simplex, "maxfev": len(simplex) + budget.refinements, "fatol": 1e-9},
    )  # fmt: skip
    return np.asarray(done.x), -float(done.fun)


def _spread(x: F64, limits: Limits) -> float:
    """Standard deviation of the defined values, else a quarter of the allowed range, else of the limit."""
    finite = x[np.isfinite(x)]
    if finite.size > 2 and np.ptp(finite) > 0.0:
        return float(finite.std(ddof=1))
    width = limits.high - limits.low
    if np.isfinite(width) and width > 0.0:
        return 0.25 * width
    ends = [abs(v) for v in (limits.low, limits.high) if np.isfinite(v) and v != 0.0]
    return 0.25 * ends[0] if ends else 1.0
