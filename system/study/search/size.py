"""Sizes of least total area at which a wanted share of a block's dies passes its specifications.

The least area under the bound that no more than a wanted share of dies fails in the linear theory
(`system.study.search.linear`) is found without dies. Tuning dies then tell which share of them really passes,
and the bound is moved by the ratio of both, until the wanted share passes or `ROUNDS` are over. Conditions on
words have no slope: they count among the tuning dies alone.

Area is that of all gates and of the plates of all capacitors; wires, guard rings and junctions add to it.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from circuits.arrays import F64
from circuits.circuit import Circuit
from circuits.devices import Capacitor, Transistor
from circuits.lowering.flatten import flatten
from circuits.silicon.die import components_of
from circuits.silicon.process import Process
from system.study.search.centre import Bench, Problem
from system.study.search.linear import LinearTheory, OpenBlock, least

ROUNDS = 4  # least areas that are sought, each after the bound was moved; ours
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
    designs, start = LinearTheory(problem, open_block, threads), problem.start
    allowed, place = 1.0 - wanted, start
    before = share = bench.share(bench.measure(start, tuning, 1.0))
    tried: list[tuple[bool, float, float, F64]] = [_judged(before, wanted, _area(designs, start), start)]
    rounds = 0
    for rounds in range(1, ROUNDS + 1):
        previous, place = place, _least_area(designs, place, allowed)
        if rounds > 1 and np.array_equal(place, previous):
            break
        share = bench.share(bench.measure(place, tuning, 1.0))
        tried.append(_judged(share, wanted, _area(designs, place), place))
        if progress is not None:
            progress(rounds / ROUNDS)
        moved = _moved(allowed, wanted, share, tuning)
        if moved is None:
            break
        allowed = moved
    met, after, area, place = max(tried, key=_rank)
    return Sized(
        place, _area(designs, start), area, 1.0 - designs.failing(place), before, after, met,
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


def _area(designs: LinearTheory, u: F64) -> float:
    """Total area at coordinates, m^2; infinite where no circuit has these sizes."""
    block = designs.block(u)
    return math.inf if block is None else area_of(block.choice.circuit, block.choice.silicon.process)


def _least_area(designs: LinearTheory, begin: F64, allowed: float) -> F64:
    """Coordinates of least area at which no more dies than allowed fail in the linear theory.

    The search for area begins where few enough fail, since it tells least where nearly all do.
    """
    reference, highest = _area(designs, begin), math.log10(allowed)

    def area(u: F64) -> float:
        found = _area(designs, u)
        return math.log(found / reference) if math.isfinite(found) else 10.0

    if designs.decades(begin) > highest:
        begin = least(designs.decades, begin, {"f_target": highest})
    room = {"type": "ineq", "fun": lambda u: highest - designs.decades(u)}
    return least(area, begin, {}, constraints=room)
