"""A finished study as commands and reports read it: its samples by condition, statistics and yield."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from circuits.arrays import F64
from circuits.silicon.components import DIES_A_WAFER
from system.options.silicon import SiliconChoice
from system.study.engine import Outcome
from system.study.in_ngspice import named_statistics
from system.study.manifest import Study
from system.study.specification import Specification, Verdict, judge
from system.study.statistics.clustered import clustered_yield
from system.study.statistics.confidence_sequence import StopRule, sequence_interval
from system.study.statistics.interval import Estimate, Interval, clopper_pearson
from system.study.statistics.summary import (
    Summary,
    Yield,
    means_of_dies,
    summarise,
    summarise_share,
    summarise_yield,
)
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
    def shared(self) -> str:
        """Which lot and wafers the dies share draws of, in words; empty where they share none."""
        study = self.study
        return of_one_lot(
            study.subject.silicon, self.table.die.tolist(), {c.corner for c in study.conditions}
        )

    def interval_kind(self, table: Table) -> str:
        """Give the name of the kind of interval that shares and yields of the samples of `table` have."""
        if self.rule:
            return "confidence sequence"
        return "Korn-Graubard" if alike(table) else "Clopper-Pearson"


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
    intervals. Dies are the sample where they have several samples each.
    """
    values = table.column(quantity.name)
    if quantity.yes_no:
        return summarise_share(values, lambda *_: _share_interval(result, table, values))
    rng = np.random.Generator(np.random.Philox(key=result.study.plan.seed))
    return summarise(values, rng, dies=table.die if alike(table) else None)


def alike(table: Table) -> bool:
    """Tell whether dies of a table have several samples each, in trials, or at corners and temperatures."""
    return len(np.unique(table.die)) < len(table)


def study_yield(result: Result, table: Table) -> Yield | None:
    """Give the yield of the samples of `table`; None where there are no specifications.

    Its interval holds although the study may have stopped itself.
    """
    if not result.specifications:
        return None
    verdict = judge_table(table, result.specifications)
    found = summarise_yield(verdict)
    interval = _share_interval(result, table, verdict.passed.astype(np.float64))
    return replace(found, estimate=Estimate(found.estimate.value, interval))


def _share_interval(result: Result, table: Table, said: F64) -> Interval:
    """Interval of the share of ones, float64[n], NaN where not defined, of the samples of a table.

    It holds although the study may have stopped itself, and where dies have several samples each.
    """
    defined = np.isfinite(said)
    samples = int(defined.sum())
    if result.rule is not None and samples:
        return _sequence(table, said, result.rule.level)
    if not alike(table):
        return clopper_pearson(int((said == 1.0).sum()), samples)
    shares = means_of_dies(said[defined], table.die[defined])
    return clustered_yield(shares, -(-samples // max(len(shares), 1)) or 1).interval


def _sequence(table: Table, said: F64, level: float) -> Interval:
    """Confidence sequence of a share: the mean of those at each place, which hold together."""
    places: dict[tuple[str, float], list[float]] = {}
    for corner, celsius, one in zip(table.corner, table.temperature_c.tolist(), said.tolist(), strict=True):
        if np.isfinite(one):
            places.setdefault((corner, celsius), []).append(one)
    each = [
        sequence_interval(v.count(1.0), len(v), 1.0 - (1.0 - level) / len(places)) for v in places.values()
    ]
    weight = [len(v) for v in places.values()]
    low, high = (
        float(np.average([getattr(e, end) for e in each], weights=weight)) for end in ("low", "high")
    )
    return Interval(low, high)


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
    more = "" if silicon.variation == "plain" or not parts else f", variation {silicon.variation}"
    return f"{told}{more}{named_statistics(silicon.process, study.subject.engine)}"


def of_one_lot(silicon: SiliconChoice, dies: Iterable[int], corners: Collection[str] = ("random",)) -> str:
    """Say of which lot and how many wafers dies are that share these draws; empty where none are shared.

    corners: at which they are; all but `random` leave nothing to draw.
    """
    if silicon.variation == "plain" or not silicon.process_variation or "random" not in corners:
        return ""
    wafers = len({die // DIES_A_WAFER for die in dies})
    return (
        f"The dies are of lot {silicon.lot} and {wafers} wafer{'s' if wafers > 1 else ''} of it, whose draws "
        "they share: spreads, intervals and yields are of that lot, and take its dies as independent."
    )
