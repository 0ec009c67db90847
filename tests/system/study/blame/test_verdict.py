"""Verdicts of blame: how many pairs a verification takes, and how often it passes what is worse."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from itertools import product
from math import comb

import pytest

from circuits.silicon.die import Die
from system.study.blame.trial import ALL, Case, Trials
from system.study.blame.verdict import FEWEST, MARGIN, Pairs, Verified, pairs_for, verify
from tests.system.study.blame.robot import SYSTEM, Scenario, Trace

DIE = Die(number=1003)
MENDED = DIE.healed("toy_chip")


@dataclass(frozen=True)
class _Failing:
    """A robot that fails on the mended die at some seeds, on the healed one at none."""

    seeds: frozenset[int]

    def __call__(self, scenario: Scenario, progress: object = None) -> Trace:
        healed = scenario.die == DIE.healed(*ALL)
        return Trace(scenario, 1.0 if scenario.seed in self.seeds and not healed else 0.0)


def verified(*seeds: int, most: int = 300) -> Verified:
    system = replace(SYSTEM, run=_Failing(frozenset(seeds)))
    return verify(Trials(Case(system, system.scenario(die=DIE)), most), MENDED, 0)


def test_pairs_that_agree_are_forty() -> None:
    found = verified()
    assert (len(found.pairs.seeds), found.wanted, found.mends) == (FEWEST, FEWEST, True)


def test_pairs_that_differ_ask_for_more() -> None:
    found = verified(3, 4, 5)
    assert found.wanted == len(found.pairs.seeds) == pairs_for(3.5 / (FEWEST + 1.0)) > FEWEST
    assert found.pairs.gained == 0
    assert found.pairs.lost == 3


def test_trials_that_are_over_leave_fewer_than_are_wanted() -> None:
    found = verified(3, 4, 5, most=90)
    assert len(found.pairs.seeds) == 45 < found.wanted


NEGLIGIBLE = 1e-8  # of what is summed 30,000 times


@cache
def passes(wanted: int, won: int, lost: int) -> bool:
    return Verified(apart(wanted, won, lost), wanted).mends


@pytest.mark.parametrize("gain", [0.0, 0.02, 0.05])
def test_what_is_ten_points_worse_passes_in_one_of_twenty(gain: float) -> None:
    """Summed over all that may come of pairs that differ independently."""
    loss = MARGIN + gain
    total = 0.0
    for won in range(12):
        for lost in range(20):
            wanted = pairs_for((won + lost + 0.5) / (FEWEST + 1.0))
            first = chance(won, lost, FEWEST, gain, loss)
            rest = wanted - FEWEST
            for a, b in product(range(min(rest, 12) + 1), range(min(rest, 9) + 1)):
                weight = first * chance(a, b, rest, gain, loss) if a + b <= rest else 0.0
                if weight > NEGLIGIBLE:
                    total += weight * passes(wanted, won + a, lost + b)
    assert 0.01 < total < 0.0525


@pytest.mark.parametrize("differing", range(7))
def test_equal_shares_are_found_in_four_of_five(differing: int) -> None:
    differ = (differing + 0.5) / (FEWEST + 1.0)
    pairs = pairs_for(differ)
    power = sum(
        chance(won, lost, pairs, 0.5 * differ, 0.5 * differ)
        for won in range(20)
        for lost in range(20)
        if passes(pairs, won, lost)
    )
    assert 0.8 <= power < 0.9


def apart(pairs: int, won: int, lost: int) -> Pairs:
    """Pairs of which so many are won and lost, and the others pass on both dies."""
    first = tuple(k >= won for k in range(pairs))
    return Pairs(tuple(range(pairs)), first, tuple(not won <= k < won + lost for k in range(pairs)))


@cache
def chance(won: int, lost: int, of: int, gain: float, loss: float) -> float:
    """Of so many pairs, as many won and lost."""
    ways = comb(of, won) * comb(of - won, lost)
    return float(ways * gain**won * loss**lost * (1.0 - gain - loss) ** (of - won - lost))
