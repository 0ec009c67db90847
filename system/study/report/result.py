"""A finished study as commands and reports read it: samples by condition, statistics, yield."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from system.study.engine import Outcome
from system.study.manifest import Study
from system.study.specification import Specification, Verdict, judge
from system.study.statistics.confidence_sequence import StopRule, sequence_interval
from system.study.statistics.interval import Estimate, Interval, clopper_pearson
from system.study.statistics.summary import Summary, Yield, summarise, summarise_share, summarise_yield
from system.study.table import Table, select
from system.study.target import Quantity, Target


@dataclass(frozen=True, slots=True)
class Result:
    """A finished study with its specifications, and the rule by which it might have stopped."""

    study: Study
    target: Target
    outcome: Outcome
    specifications: tuple[Specification, ...]
    rule: StopRule | None

    @property
    def table(self) -> Table:
        """The samples of the study."""
        return self.outcome.table

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """The quantities that were measured."""
        return self.target.quantities

    @property
    def interval_kind(self) -> str:
        """The kind of interval that the yield has."""
        return "confidence sequence" if self.rule else "Clopper-Pearson"


def groups(result: Result) -> Iterator[tuple[str, float, Table]]:
    """Give the samples of each corner at each temperature, in the order of the conditions."""
    table = result.table
    corner = np.array(table.corner, dtype=object)
    for condition in dict.fromkeys((c.corner, c.temperature_c) for c in result.study.conditions):
        mask = (corner == condition[0]) & (table.temperature_c == condition[1])
        yield (*condition, select(table, mask.astype(np.bool_)))


def judge_table(table: Table, specifications: Sequence[Specification]) -> Verdict:
    """Judge every sample by the specifications."""
    return judge(specifications, table.outcome, {m: table.column(m) for m in table.metrics})


def summary(result: Result, table: Table, quantity: Quantity) -> Summary:
    """Give the statistics of a metric; the bootstrap's generator is keyed by the study's seed."""
    if quantity.yes_no:
        return summarise_share(table.column(quantity.name), partial(_share_interval, result))
    rng = np.random.Generator(np.random.Philox(key=result.study.plan.seed))
    return summarise(table.column(quantity.name), rng)


def study_yield(result: Result, table: Table) -> Yield | None:
    """Give the yield against the specifications; its interval holds although a study may stop itself."""
    if not result.specifications:
        return None
    found = summarise_yield(judge_table(table, result.specifications))
    interval = _share_interval(result, found.passed, found.samples)
    return Yield(found.samples, found.passed, Estimate(found.estimate.value, interval), found.causes)


def _share_interval(result: Result, passed: int, samples: int) -> Interval:
    """Interval of a proportion that holds although the study may have stopped itself."""
    if result.rule is None or not samples:
        return clopper_pearson(passed, samples)
    return sequence_interval(passed, samples, result.rule.level)


def shares_of(counts: Mapping[str, int], samples: int) -> list[tuple[str, int, str]]:
    """Rows of a table: a word, how many samples it is of, and their share of all."""
    return [(word, n, f"{100.0 * n / samples:.1f} %") for word, n in counts.items()]


def varied(study: Study) -> str:
    """Say what varies from die to die."""
    silicon = study.subject.silicon
    parts = ["mismatch"] if silicon.mismatch else []
    if silicon.process and any(c.corner == "random" for c in study.conditions):
        parts.append("process")
    return " and ".join(parts) or "corners only"
