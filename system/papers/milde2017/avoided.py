"""Share of the Pushbot's runs that avoid their block: they pass its line, and touch nothing."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TypeVar

from matplotlib.figure import Figure

from system.experiment import Report
from system.papers.milde2017.null import Robot, runs_of
from system.pushbot.campaign import Driven, Summary, summaries_of
from system.statement import Statement
from system.study.statistics.share import Share, share_where
from system.verdict.null import nulls_of

Cell = TypeVar("Cell")


def avoided(found: Mapping[Cell, Sequence[Summary]]) -> dict[Cell, Share]:
    """Count the runs of each cell that avoided; one that stands avoids nothing."""
    return {
        cell: share_where(bool(s["crossed"]) and not s["collided"] for s in runs)
        for cell, runs in found.items()
    }


def report_avoided(
    driven: Mapping[Cell, Sequence[Driven]],
    robots: Mapping[str, Robot],
    rows: Callable[[dict[Cell, Share]], tuple[Statement, ...]],
    draw: Callable[[dict[Cell, Share], Figure], None],
    told: Callable[[Cell], str],
) -> Report:
    """Report how often a block was avoided, beside null robots in the place of ours.

    driven : what was driven in each cell. robots : the null robots, by name. rows, draw : make the statements
    and fill the figure, of each cell's share. told : says which cell it is, for the notes.
    """
    found = summaries_of(driven)
    ours = avoided(found)
    nulls = {name: avoided(runs) for name, runs in runs_of(robots, found).items()}
    notes = tuple(f"{told(cell)}: avoided {share}" for cell, share in ours.items())
    return Report(rows(ours), lambda figure: draw(ours, figure), notes, nulls_of(rows, nulls))
