"""The page of a mission, which grows while the mission runs and depends on nothing but its samples."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

from system.files.writing import write_text_atomic
from system.registry import load_system
from system.study.mission.blamed import Blamed, block_shares
from system.study.mission.folder import REPORT
from system.study.mission.found import Found, Raised, raised
from system.study.mission.mission import Mission
from system.study.mission.picture import draw_mission
from system.study.report.again import AGAIN_SAID, Replay, again_with_page
from system.study.report.growing import Going
from system.study.report.page import Code, Grid, picture, render
from system.study.report.result import of_one_lot
from system.study.report.worst import replay_options
from system.study.statistics.clustered import ClusteredYield
from system.study.statistics.interval import Interval
from system.study.statistics.share import percent

TEMPLATE = "mission.html"
LISTED = 50  # dies of a way that the page lists
YIELD_HEADS = ("temperature", "bias kind", "change", "dies:", "runs:", "yield:", "95 % interval:",
               "independent runs:", "not run:", "not defined:")  # fmt: skip
CAUSE_HEADS = ("temperature", "bias kind", "cause", "of failures:", "95 % interval:")
GAIN_HEADS = ("change", "temperature", "bias kind", "dies:", "gain, points:", "95 % interval:", "verdict")
_YIELD_SAID = (
    "Dies are the sample: the interval is that of Clopper and Pearson for as many independent runs as tell as"
    " much as these dies do (Korn and Graubard 1998). A run that could not be made, and one in which a metric"
    " of the success is not defined, is no success."
)
_CAUSES_SAID = (
    "The variance of failing is a sum of what dies, worlds on one die, and runs in one world differ in. After"
    " a failure at a rate q, another world on the same die fails with the chance q + (1 - q) times the die's"
    " share; any other die with q."
)
SHARE_HEADS = ("block", "dies:", "of the dies blamed:", "95 % interval:")
BLAMED_HEADS = ("die:", "seed:", "to blame", "with their area times:", "runs:")
_BLAMED_SAID = (
    "The first failing dies by their numbers. Each counts once, divided evenly among the devices whose"
    " healing was shown to mend it. The intervals are of Clopper and Pearson for as many dies."
)
_FROM_HERE = "The commands are for the folder that this page is in."
_RAISED_SAID = (
    "Each change was run on the same dies in the same worlds; the gain is of the dies' differences."
)


def write_page(
    folder: Path, mission: Mission, found: Sequence[Found], command: Sequence[str], replay: Replay,
    blamed: Sequence[Blamed] = (), going: Going | None = None,
) -> Path:  # fmt: skip
    """Write the page of what was found so far into a mission's folder, whole or not at all."""
    path = folder / REPORT
    write_text_atomic(path, page(mission, found, command, replay, blamed, going))
    return path


def page(
    mission: Mission, found: Sequence[Found], command: Sequence[str], replay: Replay,
    blamed: Sequence[Blamed] = (), going: Going | None = None,
) -> str:  # fmt: skip
    """Give the page as the text of an HTML document.

    Parameters
    ----------
    mission
        The mission.
    found
        What was found of its ways so far.
    command
        Words of the command.
    replay
        Gives the command that measures a sample again, from a study's folder and the options that name it.
        Its folders are those beside the page, so that the page is the same wherever it stands.
    blamed
        What blame says of failing dies, if it was asked.
    going
        Of a mission that is still run, or was interrupted.
    """
    runs = sum(len(each.table) for each in found)
    filmed = load_system(mission.asked.system).film is not None
    return render(
        {
            "title": f"Mission of {mission.asked.system}",
            "refresh": going.refresh if going else 0,
            "state": f"{_not_finished(mission, runs)} {going.said}" if going else state(mission, runs, found),
            "asked": _asked(mission, command),
            "yield_said": _YIELD_SAID,
            "yields": Grid(YIELD_HEADS, [yield_row(each) for each in found]),
            "picture": picture(partial(draw_mission, found), "Yields, and causes of failures"),
            "causes_said": _CAUSES_SAID,
            "causes": Grid(CAUSE_HEADS, [row for each in found for row in cause_rows(each)]),
            "raised_said": _RAISED_SAID,
            "raised": Grid(GAIN_HEADS, [gain_row(row) for row in raised(found)]),
            "blamed_said": _BLAMED_SAID,
            "blamed": [
                _blamed(way.name, [each for each in blamed if each.way == way.name]) for way in mission.ways
            ],
            "failing": [_failing(each, replay, filmed=filmed) for each in found if each.failing()],
        },
        TEMPLATE,
    )  # fmt: skip


def state(mission: Mission, runs: int, found: Sequence[Found]) -> str:
    """Say how far a mission is."""
    asked = f"{runs} of {mission.runs} runs"
    if len(found) == len(mission.ways) and (mission.asked.until is not None or runs == mission.runs):
        early = ", ended where the yield was known well enough" if runs < mission.runs else ""
        return f"Finished: {asked}{early}."
    return _not_finished(mission, runs)


def _not_finished(mission: Mission, runs: int) -> str:
    most = "at most " if mission.asked.until is not None else ""
    return f"Not finished yet: {runs} of {most}{mission.runs} runs."


def _asked(mission: Mission, command: Sequence[str]) -> Grid:
    a = mission.asked
    until = "" if a.until is None else f", at most; until +- {100.0 * a.until:g} %"
    rows: list[tuple[str, object]] = [
        ("command", Code(shlex.join(command))),
        ("success", mission.definition),
        ("dies", f"{a.silicon.lot}/{a.first} to {a.first + a.dies - 1}{until}"),
        ("worlds a die", a.worlds),
        ("runs in a world", a.trials),
    ]
    if shared := shared_by(mission):
        rows.append(("shared", shared))
    return Grid(("", ""), rows)


def shared_by(mission: Mission) -> str:
    """Say of which lot and wafers the dies are, where they share these draws; else nothing."""
    a = mission.asked
    return of_one_lot(a.silicon, range(a.first, a.first + a.dies))


def _place(found: Found) -> tuple[str, str]:
    return f"{found.way.temperature_c:g} degC", found.way.bias_kind


def yield_row(found: Found) -> tuple[object, ...]:
    """Cells of a way's yield under `YIELD_HEADS`."""
    e = found.estimate
    counts = (sum(found.reasons.values()), found.undefined)
    return (
        *_place(found), found.way.change, e.dies, len(found.table), _value(e), percent(e.interval),
        f"{e.effective:.0f}", *counts,
    )  # fmt: skip


def _value(estimate: ClusteredYield) -> str:
    return f"{100.0 * estimate.value:.1f} %" if estimate.dies else ""


def cause_rows(found: Found) -> list[tuple[object, ...]]:
    """Rows of what a way's failures come from under `CAUSE_HEADS`; none for a change."""
    if found.way.change:
        return []
    rows: list[tuple[object, ...]] = [
        (*_place(found), c.name, f"{100.0 * c.share:.0f} %", percent(c.interval)) for c in found.causes
    ]
    return rows or [(*_place(found), nothing_to_split(found), "", "")]


def nothing_to_split(found: Found) -> str:
    """Why the failures of a way cannot be split."""
    if not found.passed.size or found.passed.all():
        return "no run failed, so there is nothing to split"
    if not found.passed.any():
        return "every run failed, so there is nothing to split"
    return "one die, or one run of each, cannot be split"


def gain_row(row: Raised) -> tuple[object, ...]:
    """Cells of what a change raises under `GAIN_HEADS`."""
    low, high = 100.0 * row.gain.interval.low, 100.0 * row.gain.interval.high
    points = f"{100.0 * row.gain.value:+.1f}"
    celsius, kind = row.base.temperature_c, row.base.bias_kind
    return row.change, f"{celsius:g} degC", kind, row.dies, points, f"{low:+.1f} to {high:+.1f}", verdict(row)


def verdict(row: Raised) -> str:
    """Say whether a change raises the yield, as far as its interval tells."""
    ends: Interval = row.gain.interval
    if ends.low > 0.0:
        return "raises it"
    return "lowers it" if ends.high < 0.0 else "no difference is shown"


def _blamed(way: str, blamed: Sequence[Blamed]) -> dict[str, Any]:
    return {
        "way": way,
        "shares": Grid(SHARE_HEADS, share_rows(blamed)),
        "dies": Grid(BLAMED_HEADS, [blamed_row(each) for each in blamed]),
    }


def share_rows(blamed: Sequence[Blamed]) -> list[tuple[object, ...]]:
    """Rows of what blame puts failing dies on under `SHARE_HEADS`."""
    return [
        (row.block, row.dies, f"{100.0 * row.share.value:.0f} %", percent(row.share.interval))
        for row in block_shares(blamed)
    ]


def blamed_row(each: Blamed) -> tuple[object, ...]:
    """Cells of what blame says of a die under `BLAMED_HEADS`."""
    told = ", ".join(each.named) if each.mends else next(iter(each.shares))
    area = "" if each.area is None else f"mends, {each.area:g}"
    return each.die, each.seed, told, area, each.trials


def _failing(found: Found, replay: Replay, *, filmed: bool) -> dict[str, Any]:
    rows, runs, folder = found.failing(), found.passed[0].size, Path(found.way.name)
    more = f" The first {LISTED} are listed." if len(rows) > LISTED else ""
    change = f", {found.way.change}" if found.way.change else ""
    dies = []
    for die, count, trial in rows[:LISTED]:
        number, command = again_with_page(
            folder, folder, replay, _options(found, (die, trial)), filmed=filmed
        )
        dies.append((number, count, command))
    return {
        "place": f"{found.way.place}{change}",
        "said": f"{len(rows)} of {len(found.dies)} dies have a run that is no success.{more} {_FROM_HERE}"
        f" Of the first such run {AGAIN_SAID[filmed]}.",
        "reasons": Grid(("runs that could not be made", "runs:"), list(found.reasons.items())),
        "dies": Grid(("die:", f"fails, of {runs}:", "the first again"), dies),
    }


def again(folder: Path, found: Found, sample: tuple[int, int], replay: Replay) -> str:
    """Give the command that runs a trial again.

    sample: number of the die, and the trial.
    """
    return replay(str(folder / found.way.name), _options(found, sample))


def _options(found: Found, sample: tuple[int, int]) -> list[tuple[str, str]]:
    """Options that name a trial of a die."""
    (row,) = [k for k in range(len(found.table)) if (found.table.die[k], found.table.trial[k]) == sample]
    return replay_options(found.way.study, found.table, row)
