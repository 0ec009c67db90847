"""Experiments: a published figure or table made again, each statement beside the paper's.

How much the rows show, nulls say: what a robot that knows nothing scores by the same rules
(`system.verdict.null`). An experiment names them, and where ours is not above one its first note says so.

A statement (`system.statement`) gives its rule in the code before it is run, and whether its value was fitted
or predicted. That a fitted one agrees proves nothing, but one that does not is a disagreement like any other.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeVar

from system.statement import Statement
from system.verdict.null import Null, Score, scores, warning

if TYPE_CHECKING:
    from matplotlib.figure import Figure

T = TypeVar("T")
Progress = Callable[[float], None]


def with_progress(items: Collection[T], progress: Progress) -> Iterator[T]:
    """Items in their order; `progress` takes the share that is done after what is made of each."""
    for done, item in enumerate(items, 1):
        yield item
        progress(done / len(items))


def part(progress: Progress, begin: float, end: float) -> Progress:
    """Progress of a part of an experiment, which is the experiment's own from `begin` to `end`, 0 to 1."""
    return lambda done: progress(begin + (end - begin) * done)


@dataclass(frozen=True, slots=True)
class Report:
    """What an experiment found.

    Attributes
    ----------
    rows : tuple of Statement
        Its statements.
    draw : callable
        Fills an empty figure.
    notes : tuple of str
        Sentences for the reader.
    nulls : tuple of Null
        Rows of null robots or null data, made by what makes `rows`.
    paper : tuple of Statement
        Rows made of the paper's own values by what makes `rows`, where it gives them in this form.
    """

    rows: tuple[Statement, ...]
    draw: Callable[[Figure], None]
    notes: tuple[str, ...] = ()
    nulls: tuple[Null, ...] = ()
    paper: tuple[Statement, ...] = ()

    @property
    def scores(self) -> tuple[Score, ...]:
        """How many rows hold: for ours, for each null, for the paper's own values."""
        return scores(self.rows, self.nulls, self.paper)

    @property
    def said(self) -> tuple[str, ...]:
        """The notes; before them, where ours is not above every null, that it is not."""
        first = warning(self.scores)
        return (first, *self.notes) if first else self.notes

    @property
    def agrees(self) -> bool:
        """Whether no row disagrees, predicted or fitted; a report without rows agrees with nothing."""
        return bool(self.rows) and not self.disagreeing

    @property
    def disagreeing(self) -> tuple[str, ...]:
        """Names of the rows that do not agree; a row without a verdict is none of them."""
        return tuple(row.name for row in self.rows if row.agrees is False)


@dataclass(frozen=True, slots=True)
class Experiment:
    """A figure or table of a paper that is made again.

    Attributes
    ----------
    name : str
        Name on the command line, by which `load_experiment` finds it.
    summary : str
        What it makes again, in a line.
    run : callable
        Makes the report; `run(progress)` tells `progress` the share that is done, 0 to 1, as it goes.
    counts : mapping of str to int or None
        Whole numbers by name, with what they are unless given, where it is a campaign of many long runs; None
        where it is none. `run` takes them by these names, and after `progress` it then takes `execution`, a
        `system.study.campaign.Execution`.
    nulls : tuple of str
        Names of the nulls that its report has rows of; none where it needs none, as a closed form does.
    """

    name: str
    summary: str
    run: Callable[..., Report]
    counts: Mapping[str, int] | None = None
    nulls: tuple[str, ...] = ()
