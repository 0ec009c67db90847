"""What `noctule run` says of a run as a table, where no JSON is asked for."""

from __future__ import annotations

import shlex
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.system.conftest import Run

TABLES = {
    "bug --map bug-sealed --agent bug1": (
        "no way leads from the start to the goal",
        "unreachable after",
    ),
    "car --pings 5 --ranges exact": ("car, corridor, ranges exact", "failed: all 5 pings made"),
    "forest --pings 20": ("forest, 1400 obstacles, 2 m/s, 5 Hz", "avoided", "all 20 pings flown"),
    "head --duration 1s --distance 6m --swing 0 --motion step": (
        "head, step, lso",
        "pings without an answer: 10 faint",
    ),
    "rover --learn 0.5 --trips 2 --planner dijkstra": (
        "planned on map1-road-obstacles: 2,10 ",
        "frechet_m",
        "map error",
    ),
}


def test_another_die_is_drawn_beside(run: Run, refused: Callable[..., str], tmp_path: Path) -> None:
    asked = ("run", "approach", "--level", "behavioural", "--duration", "0.5s", "--beside", "nominal")
    picture = tmp_path / "beside.svg"
    status, out, _ = run(*asked, "--plot", str(picture))
    assert status == 0
    assert "die 1000" in out
    assert "--beside: nominal, no picture is drawn" in refused(*asked)
    rover = ("run", "rover", "--beside", "nominal", "--plot", str(picture))
    assert "no picture of rover has room" in refused(*rover)


@pytest.mark.parametrize(("options", "lines"), TABLES.items())
def test_the_table(run: Run, options: str, lines: tuple[str, ...]) -> None:
    status, out, err = run("run", *shlex.split(options))
    assert (status, err) == (0, "")
    assert [line for line in lines if line not in out] == []


def test_help_has_the_defaults_of_a_run_on_chips(run: Run) -> None:
    told = " ".join(run("run", "bug", "--help")[1].split())
    assert "A program, or neurons: ideal, or chip; chip." in told
    assert "Of Bug 2's neurons: published or improved; improved." in told
