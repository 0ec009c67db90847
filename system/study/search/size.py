"""Sizes of least total area at which a wanted share of a block's dies passes its specifications.

A die's metric is, in the linear theory about the nominal die, a normal number with that die's value and the
length of its gradient by the draws as its spread. So the share of dies that fail is at most

    sum over limits of Phi(-m / sigma),   m: the nominal die's distance to the limit, inside it

which is smooth in the sizes and needs no dies: a size moves m through the nominal circuit and sigma through
Pelgrom's law. The least area under the bound that this share is at most a wanted one is found by COBYQA
(Ragonneau 2022, in scipy), which needs no derivatives by sizes. Tuning dies then tell which share of them
really passes, and the bound is moved by the ratio of both, until the wanted share passes or `ROUNDS` are
over. Conditions on words have no slope: they count among the tuning dies alone.

Area is that of all gates and of the plates of all capacitors; wires, guard rings and junctions add to it.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import minimize
from scipy.special import ndtr

from circuits.arrays import F64
from circuits.circuit import Circuit
from circuits.devices import Capacitor, Transistor
from circuits.errors import CircuitError, ParameterError
from circuits.lowering.flatten import flatten
from circuits.silicon.die import components_of
from circuits.silicon.process import Process
from system.study.search.centre import Bench, Problem
from system.study.search.slope import Slopes
from system.study.specification import Limits
from system.study.target import BlockTarget

OpenBlock = Callable[[F64], BlockTarget]  # what coordinates stand for, as `system.study.search.centre.Open`

ROUNDS = 4  # least areas that are sought, each after the bound was moved; ours
DESIGNS = 40  # sizes whose gradients are taken in one of them, for each size that moves; ours
_LEAST = 1e-12  # share of failing dies below which nothing is told apart
_TIGHTEST = 1e-3  # of the wanted share of failing dies: the bound goes no lower


@dataclass(frozen=True, slots=True)
class Sized:
    """Where a search for sizes ended.

    Attributes
    ----------
    coordinates : array
        Coordinates of the sizes, float64[dimensions], from -1 to 1; all are 0 where nothing was found.
    area_before, area_after : float
        Total area at the start and at `coordinates`, m^2.
    predicted : float
        Share of dies that pass there in the linear theory, at least.
    yield_before, yield_after : float
        Shares of the tuning dies that pass at the start and there.
    met : bool
        Whether the wanted share of the tuning dies passes there.
    rounds : int
        How many least areas were sought.
    designs : int
        Sizes whose gradients were taken.
    impossible : int
        How many of them no circuit can have.
    measurements : int
        Tuning dies that were measured.
    """

    coordinates: F64
    area_before: float
    area_after: float
    predicted: float
    yield_before: float
    yield_after: float
    met: bool
    rounds: int
    designs: int
    impossible: int
    measurements: int


def area_of(circuit: Circuit, process: Process) -> float:
    """Return the area of all gates and of the plates of all capacitors, m^2.

    Raises `ParameterError` where there is a capacitor and the process states no capacitance of an area.
    """
    total = 0.0
    for group in flatten(circuit).groups:
        drawn = group.parameters
        if isinstance(group.device, Transistor):
            total += float((drawn["width"] * drawn["length"] * drawn["multiplicity"]).sum())
        elif isinstance(group.device, Capacitor):
            total += float(drawn["capacitance"].sum()) / components_of(process).capacitance_density
    return total


class _Designs:
    """Area and linear theory of sizes, each taken once."""

    def __init__(self, problem: Problem, open_block: OpenBlock, threads: int | None) -> None:
        self._problem, self._open, self._threads = problem, open_block, threads
        self._known: dict[tuple[float, ...], tuple[float, float]] = {}
        self._limits = [s for s in problem.specifications if isinstance(s, Limits)]
        self.impossible = 0

    @property
    def count(self) -> int:
        """How many sizes were asked for."""
        return len(self._known)

    def area(self, u: F64) -> float:
        """Total area, m^2; infinite where no circuit has these sizes."""
        return self._at(u)[0]

    def failing(self, u: F64) -> float:
        """Share of dies that fail in the linear theory, at most; 1 where a metric is not defined."""
        return self._at(u)[1]

    def _at(self, u: F64) -> tuple[float, float]:
        key = tuple(np.round(u, 9).tolist())
        if key not in self._known:
            try:
                self._known[key] = self._taken(u)
            except CircuitError:
                if not u.any():
                    raise
                self.impossible += 1
                self._known[key] = math.inf, 1.0
        return self._known[key]

    def _taken(self, u: F64) -> tuple[float, float]:
        target = self._open(u)
        area = area_of(target.choice.circuit, target.choice.silicon.process)
        failing = 0.0
        for each in self._limits:
            slopes = Slopes(target, self._problem.die, self._problem.condition, each.metric, self._threads)
            slope = slopes.at(np.zeros(len(slopes.labels)))
            sigma = float(np.linalg.norm(slope.by))
            if not (math.isfinite(slope.value) and math.isfinite(sigma)):
                return area, 1.0
            failing += sum(_missed(m, sigma) for m in (slope.value - each.low, each.high - slope.value))
        return area, min(1.0, failing)


def _missed(margin: float, sigma: float) -> float:
    """Share of dies beyond a limit at a distance from the nominal one."""
    if sigma > 0.0:
        return float(ndtr(-margin / sigma))
    return 0.0 if margin > 0.0 else 1.0


def size(
    problem: Problem,
    open_block: OpenBlock,
    wanted: float,
    bench: Bench,
    tuning: int,
    threads: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> Sized:
    """Search for the sizes of least area.

    Parameters
    ----------
    problem
        Block whose sizes are coordinates, and what its dies must fulfil.
    open_block
        Gives the block at coordinates.
    wanted
        Share of dies that should pass, above 0 and below 1.
    bench
        Its tuning dies.
    tuning
        How many of them are measured.
    threads
        How many measure the dies of a gradient that is no run backwards; all cores unless given.
    progress
        Is called with about the share of the work that is done, from 0 to 1.

    Raises
    ------
    ParameterError
        No size moves, or no specification has a limit.
    """
    if problem.dimensions < 1 or not any(isinstance(s, Limits) for s in problem.specifications):
        raise ParameterError(
            "size: needs a size to move and a metric with a limit; give `move_param`, and `spec` as in"
            ' "t_inh_s in 5ms:8ms"'
        )
    designs, start = _Designs(problem, open_block, threads), problem.start
    allowed, place = 1.0 - wanted, start
    before = share = bench.share(bench.measure(start, tuning, 1.0))
    tried: list[tuple[bool, float, float, F64]] = [_judged(before, wanted, designs.area(start), start)]
    rounds = 0
    for rounds in range(1, ROUNDS + 1):
        previous, place = place, _least_area(designs, place, allowed)
        if rounds > 1 and np.array_equal(place, previous):
            break
        share = bench.share(bench.measure(place, tuning, 1.0))
        tried.append(_judged(share, wanted, designs.area(place), place))
        if progress is not None:
            progress(rounds / ROUNDS)
        moved = _moved(allowed, wanted, share, tuning)
        if moved is None:
            break
        allowed = moved
    met, _, area, place = max(tried, key=_rank)
    after = bench.share(bench.measure(place, tuning, 1.0))
    return Sized(
        place, designs.area(start), area, 1.0 - designs.failing(place), before, after, met,
        rounds, designs.count, designs.impossible, bench.measurements,
    )  # fmt: skip


def _judged(share: float, wanted: float, area: float, place: F64) -> tuple[bool, float, float, F64]:
    return share >= wanted, share, area, place


def _rank(tried: tuple[bool, float, float, F64]) -> tuple[bool, float]:
    """Of those that meet the yield the smallest is best, of the others the one that most dies pass."""
    met, share, area, _ = tried
    return met, -area if met else share


def _moved(allowed: float, wanted: float, share: float, tuning: int) -> float | None:
    """The bound on failing dies for the next round; None where another round is of no use."""
    failing = max(1.0 - share, 0.5 / tuning)  # no failing die among them is half a one
    ratio = (1.0 - wanted) / failing
    if share >= wanted and ratio < 2.0:
        return None
    found = min(max(allowed * ratio, _TIGHTEST * (1.0 - wanted)), 0.5)
    return None if math.isclose(found, allowed, rel_tol=0.05) else found


def _least_area(designs: _Designs, begin: F64, allowed: float) -> F64:
    """Coordinates of least area at which no more dies than allowed fail in the linear theory.

    The search for area begins where few enough fail, since it tells least where nearly all do.
    """
    reference, highest = designs.area(begin), math.log10(allowed)

    def decades(u: F64) -> float:
        """Of the share that fails, which sizes move more evenly than the share."""
        return math.log10(max(designs.failing(u), _LEAST))

    def area(u: F64) -> float:
        found = designs.area(u)
        return math.log(found / reference) if math.isfinite(found) else 10.0

    if decades(begin) > highest:
        begin = _searched(decades, begin, {"f_target": highest})
    room = {"type": "ineq", "fun": lambda u: highest - decades(u)}
    return _searched(area, begin, {}, constraints=room)


def _searched(loss: Callable[[F64], float], begin: F64, until: dict[str, float], **more: Any) -> F64:
    """Coordinates at which a loss is least."""
    options = {"maxfev": DESIGNS * begin.size, "initial_tr_radius": 0.3, "final_tr_radius": 5e-3, **until}
    box = [(-1.0, 1.0)] * begin.size
    done = minimize(loss, begin, method="COBYQA", bounds=box, options=options, **more)
    return np.clip(np.asarray(done.x, dtype=np.float64), -1.0, 1.0)
