"""The page of blame: verdict, search, devices, and the runs beside each other, in one file."""

from __future__ import annotations

from functools import partial
from typing import Any

from system.study.blame.blame import Blame
from system.study.blame.picture import MOST_BARS, draw_culprits, draw_run, shown
from system.study.blame.story import (
    Told,
    device_lines,
    number_rows,
    opening_lines,
    train_rows,
)
from system.study.report.page import Code, Grid, picture, render


def blame_page(found: Blame, told: Told, command: str) -> str:
    """Return the page as HTML text; command : that runs the mended die."""
    case = found.case
    asked = Grid(
        ("", ""),
        [
            ("system", f"{case.system.name}: {case.system.summary}"),
            ("success", case.definition),
            ("die", str(case.die)),
            ("seeds", f"{found.accused.pairs.seeds[0]} on"),
            ("trials", found.trials),
            ("the mended robot", Code(command)),
        ],
    )
    sections = [_section("Verdict", opening_lines(found, told))]
    if found.steps:
        sections += [_search(found), _devices(found)]
    sections += [_behaviour(found, told)]
    sections += [_way(found, told, name) for name in told.traces]
    return render(
        {
            "title": f"Why {case.system.name} fails on {case.die}",
            "asked": asked,
            "groups": [],
            "breakdowns": sections,
        }
    )


def _section(
    title: str, lines: list[str], tables: tuple[Grid, ...] = (), image: Any = None
) -> dict[str, Any]:
    return {"title": title, "lines": lines, "tables": tables, "picture": image}


def _search(found: Blame) -> dict[str, Any]:
    rows = [(s.level, s.among, len(s.kept), s.trials, ", ".join(s.kept)) for s in found.steps]
    grid = Grid(("level", "parts:", "kept:", "trials:", "the fewest whose healing mends"), rows)
    return _section("Search", [], (grid,))


def _devices(found: Blame) -> dict[str, Any]:
    def draw(figure: Any) -> None:
        figure.set_size_inches(8.0, 2.0 + 0.3 * min(shown(found), MOST_BARS))
        draw_culprits(found, figure.subplots())

    told = any(each.deviations for each in found.culprits)
    return _section(
        "Devices",
        device_lines(found),
        image=picture(draw, "Deviations of the devices to blame") if told else None,
    )


def _behaviour(found: Blame, told: Told) -> dict[str, Any]:
    grids = []
    if trains := train_rows(found, told):
        grids.append(Grid(("spikes of", *(f"{name}:" for name in told.traces)), trains))
    if "the die" in told.traces:
        grids.append(Grid(("number", *(f"{name}:" for name in told.traces)), number_rows(told)))
    return _section(f"What the chip and the robot did, seed {told.seed}", [], tuple(grids))


def _way(found: Blame, told: Told, name: str) -> dict[str, Any]:
    summary = told.summaries[name]
    word = "succeeds" if found.case.success(summary) else "fails"
    return _section(
        f"The robot on {name} {word}", [f"{summary['reason']}."],
        image=picture(partial(draw_run, found, told.traces[name]), f"Run on {name}"),
    )  # fmt: skip
