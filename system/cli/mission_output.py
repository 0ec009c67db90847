"""Output of a mission: a JSON document, and tables for a reader."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from system.cli.exit_status import DONE, NO
from system.cli.output import print_line, print_table
from system.cli.study_output import options_said
from system.notice import say
from system.options.block import describe_dies
from system.study.mission.blamed import Blamed, block_shares
from system.study.mission.found import Found, Raised, raised
from system.study.mission.mission import Mission
from system.study.mission.page import (
    BLAMED_HEADS,
    CAUSE_HEADS,
    GAIN_HEADS,
    SHARE_HEADS,
    YIELD_HEADS,
    again,
    blamed_row,
    cause_rows,
    gain_row,
    share_rows,
    shared_by,
    state,
    verdict,
    yield_row,
)
from system.study.report.again import Replay

SHOWN = 10  # failing dies of each way that the reader sees


def document(mission: Mission, found: Sequence[Found], folder: Path | None, replay: Replay) -> dict[str, Any]:
    """Give a mission as members of a JSON document.

    folder: of the mission, without which there are no commands; replay: gives such a command.
    """
    a = mission.asked
    silicon = a.silicon
    return {
        "system": a.system,
        "success": mission.definition,
        **describe_dies(silicon),
        "law": silicon.law,
        "options": options_said(a.options),
        "first_die": a.first,
        "dies": a.dies,
        "worlds": a.worlds,
        "trials": a.trials,
        "until": a.until,
        "runs": sum(len(each.table) for each in found),
        "wanted": mission.runs,
        "shared": shared_by(mission),
        "ways": [_way(each, folder, replay) for each in found],
        "changes": [_change(row) for row in raised(found)],
    }


def _way(found: Found, folder: Path | None, replay: Replay) -> dict[str, Any]:
    e, way = found.estimate, found.way
    return {
        "name": way.name,
        "temperature_C": way.temperature_c,
        "bias_kind": way.bias_kind or None,
        "change": way.change or None,
        "dies": e.dies,
        "runs": len(found.table),
        "yield": e.value,
        "interval": asdict(e.interval),
        "effective_runs": e.effective,
        "correlation": e.correlation,
        "not_run": dict(found.reasons),
        "undefined": found.undefined,
        "causes": [asdict(cause) for cause in found.causes],
        "failing": [
            {
                "die": die,
                "fails": count,
                "trial": trial,
                "again": None if folder is None else again(folder, found, (die, trial), replay),
            }
            for die, count, trial in found.failing()
        ],
    }


def blame_document(blamed: Sequence[Blamed] | None) -> dict[str, Any]:
    """Give what blame says of failing dies as a member of a JSON document; null where it was not asked."""
    if blamed is None:
        return {"blame": None}
    ways = dict.fromkeys(each.way for each in blamed)
    return {"blame": [_blame(way, [each for each in blamed if each.way == way]) for way in ways]}


def _blame(way: str, blamed: Sequence[Blamed]) -> dict[str, Any]:
    shares = [
        {
            "block": row.block,
            "dies": row.dies,
            "share": row.share.value,
            "interval": asdict(row.share.interval),
        }
        for row in block_shares(blamed)
    ]
    dies = [
        {name: value for name, value in asdict(each).items() if name not in {"way", "blocks"}}
        for each in blamed
    ]
    return {"way": way, "shares": shares, "dies": dies}


def _change(row: Raised) -> dict[str, Any]:
    return {
        "change": row.change,
        "temperature_C": row.base.temperature_c,
        "bias_kind": row.base.bias_kind or None,
        "dies": row.dies,
        "gain": row.gain.value,
        "interval": asdict(row.gain.interval),
        "verdict": verdict(row),
    }


def print_mission(mission: Mission, found: Sequence[Found], folder: Path | None, replay: Replay) -> None:
    """Print a mission for a reader, with commands that run its failing trials again where it has a folder."""
    runs = sum(len(each.table) for each in found)
    print_line(f"mission of {mission.asked.system}: {mission.definition}")
    print_line(f"{state(mission, runs, found)}\n")
    if shared := shared_by(mission):
        print_line(f"{shared}\n")
    print_table("yield", YIELD_HEADS, map(yield_row, found))
    print_table("what failures come from", CAUSE_HEADS, [row for each in found for row in cause_rows(each)])
    gains = [gain_row(row) for row in raised(found)]
    if gains:
        print_table("what raises the yield, on the same dies", GAIN_HEADS, gains)
    for each in found:
        _print_failing(each, folder, replay)


def print_blame(blamed: Sequence[Blamed]) -> None:
    """Print what blame says of failing dies."""
    for way in dict.fromkeys(each.way for each in blamed):
        own = [each for each in blamed if each.way == way]
        print_table(f"what blame puts failing dies on, {way}", SHARE_HEADS, share_rows(own))
        print_table(f"dies that were blamed, {way}", BLAMED_HEADS, map(blamed_row, own))


def _print_failing(found: Found, folder: Path | None, replay: Replay) -> None:
    for reason, count in found.reasons.items():
        print_line(f"{found.way.name}: {count} runs could not be made: {reason}")
    rows = found.failing()
    if not rows:
        print_line(f"{found.way.name}: no run failed")
    for die, count, trial in rows[:SHOWN]:
        line = "" if folder is None else f": {again(folder, found, (die, trial), replay)}"
        print_line(f"{found.way.name}, die {die} fails {count} of {found.passed[0].size}{line}")
    if len(rows) > SHOWN:
        print_line(f"{found.way.name}: and {len(rows) - SHOWN} dies more; --json has them all")


def status_of(verb: str, found: Sequence[Found]) -> int:
    """Say where no run could be made; returns the exit status, `NO` where that is so."""
    silent = [each for each in found if sum(each.reasons.values()) == len(each.table)]
    for each in silent:
        say(f"{verb}: no run of {each.way.name} could be made, the first: {next(iter(each.reasons))}")
    return NO if silent else DONE
