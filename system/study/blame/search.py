"""The search for the fewest parts of a die whose healing mends a robot, from circuits down to parameters.

At each level the parts that were found are taken apart, and the fewest of theirs that still mend are kept:
Junker's QuickXplain, which divides and conquers, and keeps what is preferred, here what deviates most over
its own standard deviation. That k of n are enough takes some 2 k log2(n / k) tests. What is kept is minimal:
without any one of it the rest does not mend. Where deviations work against each other, so that more healing
is worse, it is checked for that at the end, and parts that turn out to be of no use are left out.

What a level kept is confirmed by a test with few errors, else it is searched with that again. Whether healing
mends is a sequential test (Wald 1945) between the share of trials that succeed on the healed die and that on
the die, over the same seeds. What mends in part passes that, so what is left at the end is held against a
share that is `LESS` below the healed die's. Where it does not stand, the fewest of what was left out on the
way are added to it, and all is narrowed down again by tests against that. Sources: Junker, "QuickXplain:
preferred explanations and relaxations for over-constrained problems", AAAI (2004), algorithm 1; Misherghi &
Su, "HDD: hierarchical delta debugging", ICSE (2006); Wald, Annals of Mathematical Statistics 16, 117 (1945),
equation (3:5).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from circuits.silicon.die import Die
from system.study.blame.part import LEVELS, Part, Parts
from system.study.blame.trial import SpentError, Trials

WRONG, CONFIRMED = 0.1, 0.005  # errors of tests either way, and of that which confirms a level; ours
MOST_TRIALS = 12  # of a test, which is then decided by what is more likely; ours
LESS = 0.3  # of a share, by which what mends in part succeeds less often than the healed die; ours
NEAR = 0.02  # of a share to 0 and 1

Mends = Callable[[Sequence[Part]], bool]


@dataclass(frozen=True, slots=True)
class Step:
    """A level of the search.

    level : what its parts are, one of `LEVELS`.
    among : parts that were there.
    kept : paths of the fewest that mend.
    trials : trials made until then.
    """

    level: str
    among: int
    kept: tuple[str, ...]
    trials: int


@dataclass(frozen=True, slots=True)
class Rates:
    """Shares of trials that succeed on the die and on the healed die, and their seeds."""

    die: float
    healed: float
    seeds: tuple[int, ...]


Test = Callable[[Die], bool]  # whether trials on an edited die succeed as on the healed one


def judged_by(trials: Trials, rates: Rates, wrong: float = WRONG) -> Test:
    """Return the sequential test whether a die is as good as the healed one, rather than as the die.

    wrong : probability of an error either way.
    """
    bad, good = (min(max(x, NEAR), 1.0 - NEAR) for x in (rates.die, rates.healed))
    up, down = math.log(good / bad), math.log((1.0 - good) / (1.0 - bad))
    edge = math.log((1.0 - wrong) / wrong)

    def passes(die: Die) -> bool:
        evidence = 0.0
        for k, seed in enumerate((*rates.seeds, *_following(rates.seeds))):
            evidence += up if trials.succeeds(die, seed) else down
            if abs(evidence) >= edge or k + 1 == MOST_TRIALS:
                break
        return evidence > 0.0

    return passes


def _following(known: Sequence[int]) -> range:
    """Seeds of a test that wants more than are known."""
    return range(max(known) + 1, max(known) + 1 + MOST_TRIALS)


def fresh(known: Sequence[int]) -> int:
    """Return the first of the seeds that no test of a search takes."""
    return _following(known).stop


def narrow(parts: Parts, trials: Trials, rates: Rates) -> tuple[list[Part], list[Step], bool]:
    """Narrow all parts down; returns what is left, the levels, and whether it ended before its trials did."""
    asked = found = parts.circuits()
    steps: list[Step] = []
    left: list[Part] = []  # out on the way
    try:
        while True:
            level = min(parts.level(part) for part in asked)
            found = _confirmed(_ordered(parts, asked), trials, rates)
            left += [part for part in asked if part not in found]
            steps.append(Step(LEVELS[level], len(asked), tuple(p.path for p in found), trials.made))
            opened = [parts.below(part) if parts.level(part) == level else [part] for part in found]
            asked = [one for own, part in zip(opened, found, strict=True) for one in own or [part]]
            if asked == found:
                rates = replace(rates, die=max(rates.die, rates.healed - LESS))
                mends = _on_parts(trials, judged_by(trials, rates, CONFIRMED))
                if not left or mends(found):
                    return found, steps, True
                added = _explained(found, _ordered(parts, left), mends, known=True)
                asked, left = [*found, *added], [part for part in left if part not in added]
    except SpentError:
        return found, steps, False


def _ordered(parts: Parts, some: Sequence[Part]) -> list[Part]:
    return sorted(some, key=lambda part: preference(parts, part))


def _confirmed(ordered: Sequence[Part], trials: Trials, rates: Rates) -> list[Part]:
    """The fewest parts that mend, which a test with few errors confirms; all of them where none are."""
    sure = _on_parts(trials, judged_by(trials, rates, CONFIRMED))
    for wrong in (WRONG, CONFIRMED):
        found = fewest(ordered, _on_parts(trials, judged_by(trials, rates, wrong)))
        if sure(found):
            return found
    return list(ordered)


def _on_parts(trials: Trials, passes: Test) -> Mends:
    return lambda healed: passes(trials.case.healed([part.path for part in healed]))


def preference(parts: Parts, part: Part) -> tuple[float, float]:
    """Order in which parts are preferred: few devices, and of as many those that deviate most."""
    return float(parts.devices(part)), -parts.weight(part)


def fewest(ordered: Sequence[Part], mends: Mends) -> list[Part]:
    """Return the fewest parts that mend, which all together do; those that come first are preferred."""
    found = _explained([], ordered, mends, known=False)
    for part in reversed(found):  # where healing is not monotonic, one may be of no use
        rest = [one for one in found if one != part]
        if len(found) > 1 and mends(rest):
            found = rest
    return found


def _explained(held: Sequence[Part], parts: Sequence[Part], mends: Mends, *, known: bool) -> list[Part]:
    """The fewest of some parts that mend together with those held; known: that those held alone do not."""
    if not known and held and mends(held):
        return []
    if len(parts) == 1:
        return list(parts)
    first, second = parts[: len(parts) // 2], parts[len(parts) // 2 :]
    later = _explained([*held, *first], second, mends, known=False)
    earlier = _explained([*held, *later], first, mends, known=not later)
    return [*earlier, *later]
