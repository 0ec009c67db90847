"""What a mission came to so far: of each way its yield, what its failures come from, and which dies fail."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from circuits.arrays import F64, I64, Bools
from system.study.mission.mission import Mission, Way
from system.study.statistics.causes import Cause, causes_of
from system.study.statistics.clustered import ClusteredYield, clustered_yield, mean_of_shares
from system.study.statistics.interval import Estimate
from system.study.table import FAILED, Table, counted
from system.system import SUCCEEDED


@dataclass(frozen=True, eq=False)  # without slots, for what is found once is kept
class Found:
    """A way of a mission with what was measured of it so far.

    way : the way.
    table : its samples.
    dies : numbers of its dies, int64[dies].
    passed : whether each run was a success, bool[dies, worlds, trials].
    undefined : runs that are none since a metric of the user's success is not defined in them.
    """

    way: Way
    table: Table
    dies: I64
    passed: Bools
    undefined: int

    @property
    def shares(self) -> F64:
        """Share of each die's runs that are a success, float64[dies]."""
        return np.asarray(self.passed.reshape(len(self.dies), -1).mean(axis=1))

    @cached_property
    def estimate(self) -> ClusteredYield:
        """The yield with its interval."""
        return clustered_yield(self.shares, self.passed[0].size if len(self.dies) else 1)

    @cached_property
    def causes(self) -> tuple[Cause, ...]:
        """What its failures come from; none where there is nothing to tell."""
        return causes_of(~self.passed, _keyed())

    @property
    def reasons(self) -> Mapping[str, int]:
        """Runs that could not be made, by the reason; each counts as none that succeeds."""
        rows = zip(self.table.outcome, self.table.reason, strict=True)
        return counted(reason for outcome, reason in rows if outcome == FAILED)

    def failing(self) -> tuple[tuple[int, int, int], ...]:
        """Dies with a run that is no success, the worst first.

        Each has its number, how many of its runs are none, and the trial of the first of these.
        """
        fails = ~self.passed.reshape(len(self.dies), -1)
        rows = [(int(die), int(f.sum()), int(f.argmax())) for die, f in zip(self.dies, fails, strict=True)]
        return tuple(sorted((row for row in rows if row[1]), key=lambda row: (-row[1], row[0])))


@dataclass(frozen=True, slots=True)
class Raised:
    """By how much a change raises the yield on the same dies.

    change : what is changed; way, base : the way with the change, and the one without; dies : dies that both
    have; gain : difference of their yields, with its interval.
    """

    change: str
    way: Way
    base: Way
    dies: int
    gain: Estimate


def found_of(mission: Mission, way: Way, table: Table) -> Found:
    """Judge the samples of a way."""
    asked = mission.asked
    values = {name: table.column(name) for name in table.metrics}
    made = np.array([outcome != FAILED for outcome in table.outcome], dtype=np.bool_)
    if mission.wanted is None:
        passed, undefined = values[SUCCEEDED] == 1.0, np.zeros(len(table), np.bool_)
    else:
        passed, undefined = mission.wanted.met(values), mission.wanted.undefined(values)
    shape = (-1, asked.worlds, asked.trials)
    dies = table.die.reshape(-1, asked.worlds * asked.trials)[:, 0]
    succeeded = np.asarray(passed & made).reshape(shape)
    return Found(way, table, dies, succeeded, int((undefined & made).sum()))


def raised(found: Sequence[Found]) -> tuple[Raised, ...]:
    """Give what changes raise the yields by, from each way's yield, the largest gain first."""
    bases = {each.way.base: each for each in found if not each.way.change}
    rows = []
    for each in found:
        base = bases.get(each.way.base)
        if each.way.change and base is not None:
            dies = min(len(each.dies), len(base.dies))
            more = each.shares[:dies] - base.shares[:dies]
            rows.append(Raised(each.way.change, each.way, base.way, dies, _gain(more)))
    return tuple(sorted(rows, key=lambda row: -row.gain.value))


def _gain(more: F64) -> Estimate:
    """Mean of differences of dies, float64[dies]."""
    return Estimate(float(more.mean()) if len(more) else np.nan, mean_of_shares(more, -1.0))


def _keyed() -> np.random.Generator:
    """Generator of bootstraps: the same samples have the same intervals."""
    return np.random.Generator(np.random.Philox(key=0))
