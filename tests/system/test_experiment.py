"""A user's own experiment, registered by entry point, makes its statements as the project's own do."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from system.cli import command_line

SOURCE = """
from system.experiment import Experiment, Report
from system.rule import at_most, unjudged, within_share
from system.statement import Statement


def run(progress):
    progress(1.0)
    rows = (
        Statement("gain", 2.0, 2.1, within_share(0.1)),
        Statement("offset_V", None, 3e-3, at_most(1e-3, "at most {milli:g} mV"), fitted=True),
        Statement("charge_C", None, 1e-12, unjudged()),
    )
    return Report(rows, lambda figure: None)


EXPERIMENT = Experiment("own-figure", "a figure of one's own", run)
"""
ENTRY_POINTS = "[noctule.experiments]\nown-figure = own_figure:EXPERIMENT\n"


@pytest.fixture
def own_figure(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "own_figure.py").write_text(SOURCE)
    metadata = tmp_path / "own_figure-1.0.dist-info"
    metadata.mkdir()
    (metadata / "METADATA").write_text("Metadata-Version: 2.1\nName: own-figure\nVersion: 1.0\n")
    (metadata / "entry_points.txt").write_text(ENTRY_POINTS)
    monkeypatch.syspath_prepend(str(tmp_path))


@pytest.mark.usefixtures("own_figure")
def test_ones_own_statements_are_rows_with_the_verdict_of_their_rule(
    capsys: pytest.CaptureFixture[str],
) -> None:
    status = command_line.main(["reproduce", "own-figure", "--json"])
    found = capsys.readouterr()
    rows = json.loads(found.out)["rows"]
    assert [(row["name"], row["rule"], row["tolerance"], row["agrees"]) for row in rows] == [
        ("gain", "within 10 %", 0.1, True),
        ("offset_V", "at most 1 mV", 1e-3, False),
        ("charge_C", "no rule", None, None),
    ]
    assert (status, found.err) == (1, "noctule: own-figure: 1 of 3 rows disagree: offset_V\n")
    assert command_line.main(["reproduce", "own-figure"]) == 1
    table = capsys.readouterr().out
    assert "NO" in table
    assert "own-figure: a figure of one's own" in table
