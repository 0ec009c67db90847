"""Verdicts of blame: whether the die is to blame, and whether healing some of its devices mends the robot.

Both compare the same trials on two dies, paired by seed. The die is to blame where the healed one succeeds
more often: the score interval of the difference (Tango 1998) lies above 0 after 6, 12 or 24 pairs, each at
a third of 5 %. It is not where the healed die has won no more than it has lost of 12 pairs: of dies that cost
30 points that passes over 1 to 9 in 100. Healing mends where, on trials that no search has used, success is
less than 10 points below that of the healed die, at a one-sided 5 %. As many pairs are made as find that in
80 % of cases if both are equal, by the share of pairs that differ, and pass what is 10 points worse in 4.8 %:
both summed over all outcomes, since counts are few. They are 40 at least. How many differ is told by the
first 40, which does not tell in whose favour (a pilot of the trial itself: Wittes & Brittain, Statistics in
Medicine 9, 65, 1990); one that is 10 points worse then passes in 5.2 % at most, as with 40 that were fixed.
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass
from functools import cache

from circuits.errors import ParameterError
from circuits.silicon.die import Die
from system.options.die.edited import check_drawn
from system.study.blame.trial import ALL, SpentError, Trials
from system.study.statistics.comparison import chance_above, paired_interval
from system.study.statistics.interval import Interval
from system.study.statistics.power import LIMIT, POWER
from system.study.statistics.share import Share

LOOKS = (6, 12, 24)  # pairs after which it is asked whether the die is to blame; ours
ENOUGH = 12  # pairs after which a die that costs nothing so far is not asked further; ours
MARGIN = 0.1  # of a share that succeeds, by which a mended die may be worse than the healed one
FEWEST, MOST = 40, 120  # pairs of a verification; the larger one is ours
LEVEL = 1.0 - 2.0 * LIMIT  # of the interval whose lower end is one-sided
ALONE = 0.048  # of pairs of any number, of an error: with the choice of the number 5.2 % in all; ours
GAINS = (0.0, 0.02, 0.05)  # shares of pairs that a die gains which is worse in all; ours


@dataclass(frozen=True, slots=True)
class Pairs:
    """The same trials on two dies.

    seeds : their seeds.
    first, second : whether each succeeded.
    """

    seeds: tuple[int, ...]
    first: tuple[bool, ...]
    second: tuple[bool, ...]

    @property
    def first_share(self) -> Share:
        """Trials that succeed on the first die."""
        return Share(sum(self.first), len(self.first))

    @property
    def second_share(self) -> Share:
        """Trials that succeed on the second die."""
        return Share(sum(self.second), len(self.second))

    @property
    def gained(self) -> int:
        """Trials that succeed on the second die alone."""
        return sum(b and not a for a, b in zip(self.first, self.second, strict=True))

    @property
    def lost(self) -> int:
        """Trials that succeed on the first die alone."""
        return sum(a and not b for a, b in zip(self.first, self.second, strict=True))

    def difference(self, level: float) -> Interval:
        """Return the score interval of the second share minus the first."""
        return paired_interval(self.gained, self.lost, len(self.seeds), level)


@dataclass(frozen=True, slots=True)
class Accused:
    """Whether a die is to blame.

    pairs : trials on the die, and on the healed one.
    interval : of the difference of their shares.
    """

    pairs: Pairs
    interval: Interval

    @property
    def guilty(self) -> bool:
        """Whether the healed die succeeds more often."""
        return self.interval.low > 0.0


class NothingFailsError(ParameterError):
    """None of the first trials fails, so that there is nothing to blame a die for."""


class HealedNotMadeError(ParameterError):
    """No trial of the healed die can be made, which tells nothing of the die."""


def accuse(trials: Trials, first: int, limit: float = LIMIT) -> Accused:
    """Say whether the die is to blame, over trials from a seed on.

    limit : probability at most of a die that is accused and not to blame.

    Raises `NothingFailsError` where none of the first trials fails, `UnknownNameError` for an edit of the
    die that means no device, and `HealedNotMadeError` where the healed die cannot be run at all.
    """
    *some, most = LOOKS
    level = 1.0 - limit / len(LOOKS)
    for count in some:
        found = _look(trials, first, count, level)
        if found.guilty or (count >= ENOUGH and found.pairs.gained <= found.pairs.lost):
            return found
    return _look(trials, first, most, level)


def _look(trials: Trials, first: int, count: int, level: float) -> Accused:
    """Ask after so many pairs."""
    case = trials.case
    healed = case.healed(ALL)
    pairs = paired(trials, case.die, healed, range(first, first + count))
    check_drawn(case.die)
    unmade = [trials.failure(healed, seed) for seed in pairs.seeds]
    if all(pairs.first):
        raise NothingFailsError(
            f"{case.system.name}: on {case.die} all trials of seeds {first} to {first + count - 1} succeed,"
            " must fail in one; take another die or seed"
        )
    if all(unmade):
        raise HealedNotMadeError(f"{case.system.name}: no trial of the healed die can be made: {unmade[0]}")
    return Accused(pairs, pairs.difference(level))


def paired(trials: Trials, first: Die, second: Die, seeds: range) -> Pairs:
    """Make the same trials on two dies."""
    both = [(trials.succeeds(first, seed), trials.succeeds(second, seed)) for seed in seeds]
    return Pairs(tuple(seeds), tuple(a for a, _ in both), tuple(b for _, b in both))


@dataclass(frozen=True, slots=True)
class Verified:
    """Whether healing mends, on trials that no search has used.

    pairs : trials on the healed die, and on the mended one.
    wanted : pairs that the power asks for; fewer are there where no more trials were allowed.
    """

    pairs: Pairs
    wanted: int

    @property
    def interval(self) -> Interval:
        """Of the difference of their shares, whose lower end is a one-sided 95 %."""
        return self.pairs.difference(LEVEL)

    @property
    def mends(self) -> bool:
        """Whether the mended die is less than 10 points worse than the healed one."""
        return len(self.pairs.seeds) >= FEWEST and self.interval.low > -MARGIN


def verify(trials: Trials, mended: Die, first: int) -> Verified:
    """Compare a mended die with the healed one on trials from a seed on."""
    healed, seeds = trials.case.healed(ALL), range(first, first + MOST)
    made: list[tuple[int, bool, bool]] = []
    wanted = FEWEST
    with suppress(SpentError):
        while len(made) < wanted:
            made.extend(
                (seed, trials.succeeds(healed, seed), trials.succeeds(mended, seed))
                for seed in seeds[len(made) : wanted]
            )
            if len(made) == FEWEST:
                differ = sum(a != b for _, a, b in made)
                wanted = pairs_for((differ + 0.5) / (FEWEST + 1.0))
    pairs = Pairs(tuple(s for s, _, _ in made), tuple(a for _, a, _ in made), tuple(b for _, _, b in made))
    return Verified(pairs, wanted)


@cache
def pairs_for(differ: float) -> int:
    """Return how many pairs find equal shares to be so with `POWER`, where a share of the pairs differs."""
    for pairs in (FEWEST, *_exact()):
        if chance_above(0.5 * differ, 0.5 * differ, pairs, MARGIN, LEVEL) >= POWER:
            return pairs
    return MOST


@cache
def _exact() -> tuple[int, ...]:
    """Numbers of pairs that pass a die which is worse by the margin in `ALONE` of cases at most."""

    def passes(pairs: int) -> float:
        return max(chance_above(gain, MARGIN + gain, pairs, MARGIN, LEVEL) for gain in GAINS)

    return tuple(pairs for pairs in range(FEWEST + 1, MOST + 1) if passes(pairs) <= ALONE)
