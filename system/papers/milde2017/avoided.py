"""Share of the Pushbot's runs that avoid their block: they pass its line, and touch nothing."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TypeVar

from system.pushbot.campaign import Summary
from system.study.statistics.share import Share, share_where

Cell = TypeVar("Cell")


def avoided(found: Mapping[Cell, Sequence[Summary]]) -> dict[Cell, Share]:
    """Count the runs of each cell that avoided; one that stands avoids nothing."""
    return {
        cell: share_where(bool(s["crossed"]) and not s["collided"] for s in runs)
        for cell, runs in found.items()
    }
