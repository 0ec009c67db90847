"""The search for the fewest parts of a die whose healing mends a robot, from circuits down to parameters.

At each level the parts that were found are taken apart, and the fewest of theirs that still mend are kept:
Junker's QuickXplain, which divides and conquers, and keeps what is preferred, here what deviates most over
its own standard deviation. That k of n are enough takes some 2 k log2(n / k) tests. What is kept is minimal:
without any one of it the rest does not mend. Where deviations work against each other, so that more healing
is worse, it is checked for that at the end, and parts that turn out to be of no use are left out.

Whether healing mends is a sequential test (Wald 1945) between the share of trials that succeed on the healed
die and that on the die, or one that is `PART` below the healed die's. Each begins at another seed, so that no
parts are chosen for luck at one. What a level kept is confirmed by more trials of that test, else the fewest
others that it needs beside are added. Of devices the parameters are first tried one alone of all.

What is left at the end is held against a share that is `LESS` below the healed die's, on seeds that no other
test takes. Where it does not stand, the seeds on which it fails and the healed die succeeds speak against it:
the fewest of what was left out on the way with which these succeed are added, those of the same devices
first, and all is narrowed down again by tests which ask these seeds too. Sources: Junker, "QuickXplain:
preferred explanations and relaxations for over-constrained problems", AAAI (2004), algorithm 1; Misherghi &
Su, "HDD: hierarchical delta debugging", ICSE (2006); Wald, Annals of Mathematical Statistics 16, 117 (1945),
equation (3:5).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from circuits.silicon.die import Die
from circuits.silicon.edit import DEVIATIONS
from system.study.blame.part import LEVELS, Part, Parts
from system.study.blame.trial import ALL, SpentError, Trials

WRONG, MISSED = 0.2, 0.125  # of tests: what does not mend passes, what mends fails; ours
STRICT, CONFIRMED, LAST = 0.05, 0.02, 0.1  # of tests of a level again, that confirm one, the last; ours
PART, LESS = 0.5, 0.1  # of a share, by which what mends in part is worse: on the way, last; ours
MOST_TRIALS, HELD = 12, 24  # of a test, and of the last: then what is more likely decides; ours
AGAINST = 4  # trials that speak against what was found, at most, which the next must stand; ours
NEAR, NEARER = 0.02, 0.01  # of a share to 0 and 1, and in the last test; ours

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
    """Shares of trials that succeed on the die and on the healed die.

    die, healed : the shares.
    seeds : seeds of these trials, those first on which the die fails and the healed one succeeds.
    telling : how many these are.
    """

    die: float
    healed: float
    seeds: tuple[int, ...]
    telling: int

    def less(self, share: float) -> Rates:
        """Return the same with a die that succeeds so much less often than the healed one at most."""
        return replace(self, die=max(self.die, self.healed - share))


Test = Callable[[Die], bool]  # whether trials on an edited die succeed as on the healed one


def judged_by(trials: Trials, rates: Rates, wrong: float = WRONG) -> Test:
    """Return the sequential test whether a die is as good as the healed one, rather than as the die.

    wrong : probability that one as bad as the die passes.
    """
    more = _following(rates.seeds)[:MOST_TRIALS]

    def passes(die: Die) -> bool:
        told, others = rates.seeds[: rates.telling], rates.seeds[rates.telling :]
        turn = trials.made % max(len(told), 1)  # not the same seeds each time, by which parts were chosen
        seeds = (*told[turn:], *told[:turn], *others, *more)
        known = [seed for seed in seeds if trials.known(die, seed)]
        order = [*known, *(seed for seed in seeds if seed not in known)]
        return _sequential(trials, rates, wrong, die, order[:MOST_TRIALS])

    return passes


def _sequential(
    trials: Trials, rates: Rates, wrong: float, die: Die, seeds: Sequence[int], near: float = NEAR
) -> bool:
    """Wald's test between the two shares."""
    bad, good = (min(max(x, near), 1.0 - near) for x in (rates.die, rates.healed))
    up, down = math.log(good / bad), math.log((1.0 - good) / (1.0 - bad))
    accepted, rejected = math.log((1.0 - MISSED) / wrong), math.log(MISSED / (1.0 - wrong))
    evidence = 0.0
    for seed in seeds:
        evidence += up if trials.succeeds(die, seed) else down
        if not rejected < evidence < accepted:
            break
    return evidence > 0.0


def _against(trials: Trials, rates: Rates, found: Sequence[Part]) -> list[int]:
    """Seeds on which what was found fails and the healed die does not, where the last test does not pass it.

    They are trials that no other test takes.
    """
    count = len(rates.seeds)
    healed = (rates.healed * (count + 1.0) - 0.5) / count
    die, seeds = _healed(trials, found), _following(rates.seeds)[MOST_TRIALS:]
    if _sequential(trials, replace(rates, healed=healed).less(LESS), LAST, die, seeds, NEARER):
        return []
    return [
        s
        for s in seeds
        if trials.known(die, s)
        and not trials.succeeds(die, s)
        and trials.succeeds(trials.case.healed(ALL), s)
    ][:AGAINST]


def _following(known: Sequence[int]) -> range:
    """Seeds of tests that want more than are known."""
    return range(max(known) + 1, max(known) + 1 + MOST_TRIALS + HELD)


def fresh(known: Sequence[int]) -> int:
    """Return the first of the seeds that no test of a search takes."""
    return _following(known).stop


def narrow(parts: Parts, trials: Trials, rates: Rates) -> tuple[list[Part], list[Step], bool]:
    """Narrow all parts down; returns what is left, the levels, and whether it ended before its trials did."""
    asked = found = parts.circuits()
    steps: list[Step] = []
    left: list[Part] = []  # out on the way
    against: list[int] = []
    on_way = rates.less(PART)
    try:
        while True:
            level = min(parts.level(part) for part in asked)
            found = _confirmed(_ordered(parts, asked), trials, on_way, against)
            left += [part for part in asked if part not in found]
            steps.append(Step(LEVELS[level], len(asked), tuple(p.path for p in found), trials.made))
            opened = [parts.below(part) if parts.level(part) == level else [part] for part in found]
            asked = [one for own, part in zip(opened, found, strict=True) for one in own or [part]]
            if asked == found:
                told = _against(trials, rates, found) if left else []
                against += told
                if not told or len(against) > AGAINST:
                    return found, steps, True
                added = _explained(found, _near(parts, left, found), _standing(trials, against), known=True)
                asked, left = [*found, *added], [part for part in left if part not in added]
    except SpentError:
        return found, steps, False


def _ordered(parts: Parts, some: Sequence[Part]) -> list[Part]:
    return sorted(some, key=lambda part: preference(parts, part))


def _near(parts: Parts, some: Sequence[Part], found: Sequence[Part]) -> list[Part]:
    """In the order in which they are preferred, those of devices that were found first."""
    devices = {part.steps for part in found}
    return sorted(some, key=lambda part: (part.steps not in devices, *preference(parts, part)))


def _confirmed(ordered: Sequence[Part], trials: Trials, rates: Rates, against: Sequence[int]) -> list[Part]:
    """The fewest parts that mend, which a test with few errors confirms; all of them where none are.

    against : seeds on which they must too.
    """
    stands = _standing(trials, against)

    def mends(wrong: float) -> Mends:
        passes = judged_by(trials, rates, wrong)
        return lambda some: stands(some) and passes(_healed(trials, some))

    sure = mends(CONFIRMED)
    first = _of_one_parameter(ordered) or [fewest(ordered, mends(WRONG))]
    for found in first:
        if sure(found):
            return needed(found, mends(WRONG))
    found = first[0]
    rest = [part for part in ordered if part not in found]
    found = needed(
        [*found, *(_explained(found, rest, mends(STRICT), known=True) if rest else [])], mends(STRICT)
    )
    return found if sure(found) else list(ordered)


def _of_one_parameter(some: Sequence[Part]) -> list[list[Part]]:
    """Parts of one parameter, each that several are of, with those of none; V_T0, which moves most, first."""
    names = sorted({part.parameter for part in some} & {*DEVIATIONS}, key=list(DEVIATIONS).index)
    told = [[part for part in some if part.parameter in {"", name}] for name in names]
    return [each for each in told if 1 < len(each) < len(some)]


def _standing(trials: Trials, seeds: Sequence[int]) -> Mends:
    """Whether all of some trials succeed with parts healed."""
    return lambda some: all(trials.succeeds(_healed(trials, some), seed) for seed in seeds)


def _healed(trials: Trials, some: Sequence[Part]) -> Die:
    return trials.case.healed([part.path for part in some])


def preference(parts: Parts, part: Part) -> tuple[float, float]:
    """Order in which parts are preferred: few devices, and of as many those that deviate most."""
    return float(parts.devices(part)), -parts.weight(part)


def fewest(ordered: Sequence[Part], mends: Mends) -> list[Part]:
    """Return the fewest parts that mend, which all together do; those that come first are preferred."""
    return needed(_explained([], ordered, mends, known=False), mends)


def needed(found: Sequence[Part], mends: Mends) -> list[Part]:
    """Return parts without those of no use, as there may be where healing is not monotonic."""
    kept = list(found)
    for part in reversed(found):
        rest = [one for one in kept if one != part]
        if rest and mends(rest):
            kept = rest
    return kept


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
