"""A finished study as commands and reports read it: its samples by condition, statistics and yield."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from system.study.engine import Outcome
from system.study.in_ngspice import named_statistics
from system.study.manifest import Study
from system.study.specification import Specification, Verdict, judge
from system.study.statistics.confidence_sequence import StopRule, sequence_interval
from system.study.statistics.interval import Estimate, Interval, clopper_pearson
from system.study.statistics.summary import Summary, Yield, summarise, summarise_share, summarise_yield
from system.study.table import Table, select
from system.study.target import Quantity, Target


@dataclass(frozen=True, slots=True)
class Result:
    """A finished study with the specifications that its samples are judged by.

    Attributes
    ----------
    study : what was measured, on which dies and under which conditions.
    target : the block, chip or system that was measured.
    outcome : the samples, and how the work on them went.
    specifications : conditions that a sample must fulfil to pass.
    rule : rule by which the study might have stopped itself; None for a fixed number of samples.
    """

    study: Study
    target: Target
    outcome: Outcome
    specifications: tuple[Specification, ...]
    rule: StopRule | None

    @property
    def table(self) -> Table:
        """The table of the samples of the study."""
        return self.outcome.table

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """The quantities that were measured, in the order of the columns of the table."""
        return self.target.quantities

    @property
    def interval_kind(self) -> str:
        """The name of the kind of interval that shares and yields have in this study."""
        return "confidence sequence" if self.rule else "Clopper-Pearson"


def groups(result: Result) -> Iterator[tuple[str, float, Table]]:
    """Yield the corner, the temperature (degC) and the samples of each condition.

    They come in the order of the study's conditions. Trials at the same corner and temperature come together.
    """
    table = result.table
    corner = np.array(table.corner, dtype=object)
    for condition in dict.fromkeys((c.corner, c.temperature_c) for c in result.study.conditions):
        mask = (corner == condition[0]) & (table.temperature_c == condition[1])
        yield (*condition, select(table, mask.astype(np.bool_)))


def judge_table(table: Table, specifications: Sequence[Specification]) -> Verdict:
    """Judge every sample of a table by the specifications."""
    return judge(specifications, table.outcome, {m: table.column(m) for m in table.metrics})


def summary(result: Result, table: Table, quantity: Quantity) -> Summary:
    """Give the statistics of a quantity over the samples of `table`.

    The generator of the bootstrap is keyed by the seed of the study, so that the same study has the same
    intervals.
    """
    if quantity.yes_no:
        return summarise_share(table.column(quantity.name), partial(_share_interval, result))
    rng = np.random.Generator(np.random.Philox(key=result.study.plan.seed))
    return summarise(table.column(quantity.name), rng)


def study_yield(result: Result, table: Table) -> Yield | None:
    """Give the yield of the samples of `table`; None where there are no specifications.

    Its interval holds although the study may have stopped itself.
    """
    if not result.specifications:
        return None
    found = summarise_yield(judge_table(table, result.specifications))
    interval = _share_interval(result, found.passed, found.samples)
    return replace(found, estimate=Estimate(found.estimate.value, interval))


def _share_interval(result: Result, passed: int, samples: int) -> Interval:
    """Interval of a proportion that holds although the study may have stopped itself."""
    if result.rule is None or not samples:
        return clopper_pearson(passed, samples)
    return sequence_interval(passed, samples, result.rule.level)


def shares_of(counts: Mapping[str, int], samples: int) -> list[tuple[str, int, str]]:
    """Give the rows of a table from counts: a word, its number of samples, and its share of all `samples`."""
    return [(word, n, f"{100.0 * n / samples:.1f} %") for word, n in counts.items()]


def varied(study: Study) -> str:
    """Say in words what varies from die to die of a study."""
    silicon = study.subject.silicon
    parts = ["mismatch"] if silicon.mismatch else []
    if silicon.process_variation and any(c.corner == "random" for c in study.conditions):
        parts.append("process")
    told = " and ".join(parts) or "corners only"
    return f"{told}{named_statistics(silicon.process, study.subject.engine)}"
