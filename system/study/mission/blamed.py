"""What blame says of a mission's failing dies, and which share of them it puts on each block.

The first failing dies of a way by their numbers are a sample of all that fail there. Each of them is blamed
(`system.study.blame.blame`) from the world of its first run that is no success on, and counts once, however
many of its runs fail. Where healing the devices that blame names is shown to mend it, it is divided evenly
among these, and so among their blocks. Else it counts as `NOT_THE_DIE` or as `NOT_SHOWN`. The interval of a
share is that of Clopper and Pearson for as many dies, at counts that need not be whole: what is at most 1 of
a die varies at most as what is 1 or 0.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import cast

import numpy as np

from system.codes.find import quietly
from system.registry import load_system
from system.study.blame.blame import BUDGET, blame
from system.study.blame.trial import Case
from system.study.blame.verdict import NothingFailsError
from system.study.campaign import Campaign, Execution, Numbered, Workers, here
from system.study.engine import dies_of
from system.study.manifest import describe, study_key
from system.study.mission.found import Found
from system.study.mission.mission import Asked, Mission, Way, mission_of
from system.study.statistics.clustered import beta_interval
from system.study.statistics.interval import LEVEL, Estimate
from system.study.target import SystemTarget, open_target

FILE = "blame.jsonl"  # in the folder of a mission
NOT_THE_DIE, NOT_SHOWN = "not the die", "the die, but no devices were shown to mend it"


@dataclass(frozen=True, slots=True)
class Blamed:
    """What blame says of a failing die.

    way : name of the way that it fails in.
    die : its number.
    seed : of the world of its first run that is no success.
    guilty : whether the die is to blame.
    named : paths of what was named.
    blocks : block of each of them.
    mends : whether healing them mends, on trials of their own.
    area : area over theirs with which they mend; None where none that was tried does.
    trials : runs that were made.
    """

    way: str
    die: int
    seed: int
    guilty: bool = False
    named: tuple[str, ...] = ()
    blocks: tuple[str, ...] = ()
    mends: bool = False
    area: float | None = None
    trials: int = 0

    @property
    def shares(self) -> Mapping[str, float]:
        """What the die counts for, by block; together 1."""
        if not self.guilty:
            return {NOT_THE_DIE: 1.0}
        if not self.mends:
            return {NOT_SHOWN: 1.0}
        return {name: count / len(self.blocks) for name, count in Counter(self.blocks).items()}


@dataclass(frozen=True, slots=True)
class BlockShare:
    """What is put on a block.

    block : path of the block, of all cells; `NOT_THE_DIE` or `NOT_SHOWN` for none.
    dies : dies on which it was named.
    share : of the dies that were blamed, with its interval.
    """

    block: str
    dies: int
    share: Estimate


@dataclass(frozen=True, slots=True)
class _One:
    """Blames a die of a mission, by the name of its way and its number, from a trial on."""

    asked: Asked
    trials: Mapping[Numbered, int]

    def __call__(self, key: Numbered) -> Blamed:
        mission = mission_of(self.asked)
        (way,) = [way for way in mission.ways if way.name == key.condition]
        case = _case(mission, way, key.number, self.trials[key])
        begun = Blamed(way.name, key.number, case.scenario.seed)
        try:
            with quietly():
                found = blame(case)
        except NothingFailsError:  # with noise of blame's own no trial fails
            return begun
        verified = found.verified
        return Blamed(
            begun.way, begun.die, begun.seed, found.accused.guilty,
            tuple(each.path for each in found.culprits), tuple(each.block for each in found.culprits),
            verified is not None and verified.mends, found.area, found.trials,
        )  # fmt: skip


def _case(mission: Mission, way: Way, number: int, trial: int) -> Case:
    """The robot in a world of a die; the noise is that of the world's seed."""
    (die,), target = dies_of(way.study, range(number, number + 1)), open_target(way.study.subject)
    own = cast("SystemTarget", target)
    seed = {"seed": own.seeds(die, trial)["seed"]}
    scenario = own.scenario(die, way.study.conditions[trial], seed)
    return Case(load_system(mission.asked.system), scenario, mission.wanted)


def to_blame(found: Sequence[Found], count: int) -> dict[Numbered, int]:
    """Give the first failing dies of each way without a change, with the trial that fails first.

    count : of each way, at most.
    """
    return {
        Numbered(each.way.name, die): trial
        for each in found
        if not each.way.change
        for die, _, trial in sorted(each.failing())[:count]
    }


def blame_failing(
    mission: Mission, failing: Mapping[Numbered, int], folder: Path | None = None, *,
    workers: Callable[[], AbstractContextManager[Workers]] = here,
    progress: Callable[[float], object] = lambda _: None,
) -> tuple[Blamed, ...]:  # fmt: skip
    """Blame failing dies of a mission, each with `system.study.blame.blame.BUDGET` runs at most.

    Parameters
    ----------
    mission
        The mission.
    failing
        Trial that fails first, by way and die, as of `to_blame`.
    folder
        Folder of the mission, whose `FILE` keeps what was found, and is gone on with; nothing is kept where
        it is None.
    workers
        Who blames, one die at a time each.
    progress
        Told the share of the dies that is done, 0 to 1.
    """
    file = None if folder is None else folder / FILE
    campaign = Campaign(
        "mission-blame", _One(mission.asked, failing), Numbered, Blamed, _depends_on(mission, file)
    )
    execution = Execution(file, resume=file is not None and file.exists(), workers=workers)
    rows = execution.by_condition(campaign, list(failing), progress)
    return tuple(each for row in rows.values() for each in row)


def _depends_on(mission: Mission, file: Path | None) -> tuple[object, ...]:
    """What blame depends on besides its die, where a file keeps it."""
    ways = () if file is None else tuple(way.study for way in mission.ways if not way.change)
    return version("noctule"), BUDGET, mission.definition, *(study_key(describe(study)) for study in ways)


def block_shares(blamed: Sequence[Blamed]) -> tuple[BlockShare, ...]:
    """Give the share of dies that blame puts on each block, the largest first, what is no block last."""
    names = dict.fromkeys(name for each in blamed for name in each.shares)
    rows = []
    for name in names:
        own = np.array([each.shares.get(name, 0.0) for each in blamed])
        share = float(own.mean())
        known = Estimate(share, beta_interval(share, len(own), LEVEL))
        rows.append(BlockShare(name, int((own > 0.0).sum()), known))
    no_block = (NOT_THE_DIE, NOT_SHOWN)
    return tuple(sorted(rows, key=lambda row: (row.block in no_block, -row.share.value, row.block)))
