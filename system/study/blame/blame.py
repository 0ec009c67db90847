"""Why a robot fails on a die: the fewest devices whose healing mends it, how sure that is, what else does.

1. `verdict.accuse` asks whether the die is to blame: the healed die succeeds where the die fails.
2. `search.narrow` takes the die apart, to the fewest devices whose healing mends.
3. `verdict.verify` holds what was found against the healed die on trials that the search has not used.
4. As many devices at random, of the same circuit and with the same spread, show whether any would do.
5. The area that the devices would need, and codes of a calibration, are tried as other remedies.

Codes are those of the unhealed die: healing a device leaves what a calibration did about it. The robot on the
mended die with codes of its own stands beside. Codes that took out what the die deviates are wrong for the
healed die, which may fail with them. Where it does, but succeeds once calibrated itself, every edited die is
calibrated anew throughout, and the mended die with the codes of the unhealed one stands beside.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from circuits.errors import ParameterError
from circuits.silicon.die import Die
from circuits.silicon.edit import DEVIATIONS, Edit
from circuits.silicon.process import Process
from system.options.codes import CALIBRATED
from system.study.blame.part import Part, Parts, shared_by_all
from system.study.blame.search import Rates, Step, Test, fresh, judged_by, narrow
from system.study.blame.trial import ALL, Case, SpentError, Trials
from system.study.blame.verdict import FEWEST, Accused, HealedNotMadeError, Verified, accuse, verify
from system.study.statistics.power import LIMIT
from system.study.statistics.share import Share, share_where

BUDGET = 300  # trials of one die
AREAS = (2.0, 4.0, 8.0, 16.0, 32.0, 64.0)  # times the devices', of which the least that mends is found; ours
RANDOM = 5  # sets of devices at random; ours
OTHERS = 20 + 2 * FEWEST  # trials that a search leaves over


@dataclass(frozen=True, slots=True)
class Culprit:
    """A device, or what devices share, that is to blame.

    path : its path, with its parameter where one alone is to blame.
    block : path of the block that it is in, of all cells.
    deviations : deviation and its standard deviation by parameter, V of V_T0, else relative; of a gradient a
        metre, by axis and parameter.
    slopes : what gradients across the die add to that of a device, by parameter.
    """

    path: str
    block: str
    deviations: dict[str, tuple[float, float]]
    slopes: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Remedy:
    """Something else that might mend the robot.

    name : what is changed, in words.
    share : trials of the first ones with which it succeeds; None where it was not tried.
    """

    name: str
    share: Share | None


@dataclass(frozen=True, slots=True)
class Blame:
    """What is to blame for a robot that fails on a die.

    case : the robot on the die, with its first trial, and whether edited dies are calibrated anew.
    accused : whether the die is to blame; without that the rest is empty.
    held : the same with codes of the die on the healed one, where these are not what it was accused by; None
        too where it cannot be run with them.
    steps : levels of the search.
    culprits : the fewest that were found.
    finished : whether the search ended before its trials did.
    verified : whether healing them mends.
    random : sets of as many devices at random that mend.
    area : area over theirs with which they mend; None where none that was tried does.
    remedies : codes that might mend.
    trials : trials that were made.
    counts : devices of each culprit.
    processes : process of each circuit, by the name at which its paths begin.
    """

    case: Case
    accused: Accused
    steps: tuple[Step, ...] = ()
    culprits: tuple[Culprit, ...] = ()
    finished: bool = True
    verified: Verified | None = None
    random: Share | None = None
    area: float | None = None
    remedies: tuple[Remedy, ...] = ()
    trials: int = 0
    counts: Mapping[str, int] = field(default_factory=dict)
    processes: Mapping[str, Process] = field(default_factory=dict)
    held: Accused | None = None

    @property
    def mended(self) -> Die:
        """The die with the culprits healed."""
        return self.case.healed([each.path for each in self.culprits])


def blame(case: Case, most: int = BUDGET, progress: Callable[[float], None] = lambda _: None) -> Blame:
    """Say what is to blame for a robot that fails on a die.

    Parameters
    ----------
    case
        The robot on the die.
    most
        Trials that may be made.
    progress
        Told the share of them that was.

    Raises
    ------
    ParameterError
        None of the first trials fails, the healed die cannot be run, or nothing on the die deviates.
    """
    trials = Trials(case, most, told=lambda made: progress(made / most))
    accused, held = _accused(trials)
    case = trials.case
    if not accused.guilty:
        return Blame(case, accused, trials=trials.made, held=held)
    parts = Parts(case.die, case.drawn())
    if not parts.circuits():
        raise ParameterError(f"{case.system.name}: nothing deviates on {case.die}, must be a drawn die")
    rates = rates_of(accused)
    trials.most = most - OTHERS
    found, steps, finished = narrow(parts, trials, rates)
    trials.most = most
    begun = Blame(
        case, accused, tuple(steps), tuple(_culprit(parts, part) for part in found), finished,
        counts={part.path: parts.devices(part) for part in found}, processes=parts.processes, held=held,
    )  # fmt: skip
    return _judged(begun, trials, parts, found, rates)


def _accused(trials: Trials) -> tuple[Accused, Accused | None]:
    """Accuse the die, and give what codes of the die gave before, where edited dies are calibrated anew."""
    case, seed = trials.case, trials.case.scenario.seed
    if not case.calibrated:
        return accuse(trials, seed), None
    try:
        held = accuse(trials, seed, LIMIT / 2.0)
    except HealedNotMadeError:
        held = None
    if held is not None and held.guilty:
        return held, None
    trials.case = replace(case, recalibrated=True)
    return accuse(trials, seed, LIMIT / 2.0), held


def rates_of(accused: Accused) -> Rates:
    """Shares of trials that succeed, half a trial either way added, and their seeds, telling ones first."""
    pairs, count = accused.pairs, len(accused.pairs.seeds) + 1.0
    die, healed = (sum(each) + 0.5 for each in (pairs.first, pairs.second))
    told = [b and not a for a, b in zip(pairs.first, pairs.second, strict=True)]
    order = sorted(range(len(pairs.seeds)), key=lambda k: not told[k])
    return Rates(die / count, healed / count, tuple(pairs.seeds[k] for k in order), sum(told))


def _culprit(parts: Parts, part: Part) -> Culprit:
    single = parts.level(part) >= 3
    deviations, slopes = (parts.deviations(part), parts.slopes(part)) if single else ({}, {})
    return Culprit(part.path, parts.block(part), deviations, slopes)


def _judged(begun: Blame, trials: Trials, parts: Parts, found: Sequence[Part], rates: Rates) -> Blame:
    """Verify what was found, and try what else would mend."""
    passes = judged_by(trials, rates)
    trials.most -= 2 * FEWEST
    tried = replace(
        begun, random=_at_random(trials, parts, found, passes), area=_area(trials, begun.culprits, passes),
        remedies=_remedies(begun, trials),
    )  # fmt: skip
    trials.most += 2 * FEWEST
    verified = verify(trials, begun.mended, fresh(rates.seeds))
    return replace(tried, verified=verified, trials=trials.made)


def _at_random(trials: Trials, parts: Parts, found: Sequence[Part], passes: Test) -> Share | None:
    """Sets of as many devices at random, of the same circuits and spreads, that mend; None without any."""
    if any(parts.level(part) < 3 or shared_by_all(part.path) for part in found):
        return None
    alike = [parts.alike(part) for part in found]
    if not all(alike):
        return None
    rng = np.random.default_rng((trials.case.die.number or 0, len(found)))
    own = {replace(part, parameter="").path for part in found}
    sets = []
    for _ in range(RANDOM):
        drawn = {each[int(rng.integers(len(each)))].path for each in alike}
        sets.append(sorted(drawn - own))
    try:
        return share_where(passes(trials.case.healed(paths)) for paths in sets if paths)
    except SpentError:
        return None


def _area(trials: Trials, culprits: Sequence[Culprit], passes: Test) -> float | None:
    """The least area over theirs with which the culprits mend; None where none does, or none can be tried."""
    if not all(each.deviations for each in culprits) or all(shared_by_all(each.path) for each in culprits):
        return None
    try:
        return next((x for x in AREAS if passes(enlarged(trials.case.die, culprits, x))), None)
    except SpentError:
        return None


def enlarged(die: Die, culprits: Sequence[Culprit], area: float) -> Die:
    """Return a die on which devices are some times as large, so that they deviate by 1 / sqrt(area) as much.

    What devices share stays, gradients across the die too.
    """
    edits = []
    for each in culprits:
        for name, (value, _) in each.deviations.items() if not shared_by_all(each.path) else ():
            if name in DEVIATIONS:
                path, slope = each.path.removesuffix(f".{name}"), each.slopes.get(name, 0.0)
                edits.append(Edit("set", (path,), name, value / math.sqrt(area) + slope))
    return replace(die, edits=(*die.edits, *edits))


def _remedies(begun: Blame, trials: Trials) -> tuple[Remedy, ...]:
    """Codes that might mend: of a calibration of the die, and of the mended and the healed die."""
    case, seeds = begun.case, begun.accused.pairs.seeds[:6]
    if not case.coded or case.scenario.bias_kind == "gate":  # fixed gates have no codes
        return ()
    own: dict[str, Any] = {"own_codes": True, "codes": CALIBRATED}
    asked = {
        "the die at codes of its own calibration": (case.die, own),
        "the mended die at codes of its own calibration": (begun.mended, own),
        "the healed die at codes of its own calibration": (case.healed(ALL), own),
    }
    if case.recalibrated:
        asked = {"the mended die at the codes of the die": (begun.mended, {"own_codes": False})}
    found = []
    for name, (die, codes) in asked.items():
        try:
            share = share_where(trials.succeeds(die, s, **codes) for s in seeds)
        except (SpentError, ParameterError):
            found.append(Remedy(name, None))
        else:
            found.append(Remedy(name, share))
    return tuple(found)
