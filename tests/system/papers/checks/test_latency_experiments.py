"""The experiments of the latency chip, made small: rows, notes and pictures."""

from collections.abc import Callable
from pathlib import Path

import pytest

from chips.latency.model import BLOCKS
from system.experiment import Report
from system.papers.checks import (
    latency_agreement,
    latency_dies,
    latency_forests,
    latency_loops,
    latency_recall,
)
from system.papers.wen2022 import equations as latency_equations
from system.papers.wen2022 import fig12_chip as wen2022_fig12_chip
from system.plot import save_picture
from system.spiking_bat.campaign import Crossed


def drawn(report: Report, path: Path) -> int:
    save_picture(str(path), report.draw)
    return path.stat().st_size


def silent(_: float) -> None:
    pass


def test_the_equations_hold_within_2_percent(tmp_path: Path) -> None:
    report = latency_equations.reproduce(silent, 3)
    assert [row.name for row in report.rows if not row.agrees] == []
    assert len(report.rows) == 4
    assert drawn(report, tmp_path / "equations.png") > 10_000


def test_few_pings_do_not_show_agreement(tmp_path: Path) -> None:
    report = latency_agreement.reproduce(silent, pings=6, flight=6)
    found = {row.name: row for row in report.rows}
    assert found["pings"].shown == 6.0
    assert not found["pings"].agrees
    assert not found["kappa_lower_limit"].agrees  # no interval of one block
    assert drawn(report, tmp_path / "agreement.png") > 10_000


def test_what_is_recalled_is_near_what_was_heard(tmp_path: Path) -> None:
    report = latency_recall.reproduce(silent, 1)
    assert report.rows[0].agrees
    assert len(report.notes) <= len(latency_recall.BUILDS)
    assert drawn(report, tmp_path / "recall.png") > 10_000


def test_figure_12_goes_on_the_chip_as_on_the_network(tmp_path: Path) -> None:
    report = wen2022_fig12_chip.reproduce(silent)
    assert [row.name for row in report.rows if not row.agrees] == []
    assert drawn(report, tmp_path / "figure.png") > 30_000


@pytest.fixture
def flights() -> Callable[[int], list[Crossed]]:
    """Flights that are made up: collided after so many crossings, and one stopped at 8."""
    return lambda laps: (
        [Crossed(1006 + k, laps, True, 500) for k in range(4)] + [Crossed(1010, 8, False, 6000)]
    )


def test_forests_state_the_papers_flight_and_the_pairs(
    flights: Callable[[int], list[Crossed]], tmp_path: Path
) -> None:
    found = {"analog": flights(5), "chip": flights(4), "network": flights(4)}
    rows = latency_forests.rows(found)
    assert [row.agrees for row in rows] == [True, True, True]
    assert "four crossings 1.00" in latency_forests.notes(found)[1]
    report = Report(rows, lambda figure: latency_forests.draw_survival(found, figure))
    assert drawn(report, tmp_path / "forests.png") > 10_000


def test_dies_state_their_rules(flights: Callable[[int], list[Crossed]]) -> None:
    found = {name: flights(k) for k, name in enumerate(reversed(latency_dies.BUILDS))}
    agrees = [row.agrees for row in latency_dies.rows(found)]
    # in reversed order: calibrated 4, gate 5, area 6, generator 7 crossings
    assert agrees == [False, False, True]
    assert len(latency_dies.notes(found)) == len(latency_dies.BUILDS)
    assert len(BLOCKS) == 7


def test_loops_are_repeated_from_where_they_began(tmp_path: Path) -> None:
    report = latency_loops.reproduce(silent, loops=1, first=253, pings=12)
    assert any(note.startswith("chip: repeats 1 of 1") for note in report.notes)
    assert not report.rows[0].agrees  # one loop shows nothing
    assert drawn(report, tmp_path / "loops.png") > 10_000
