"""Figure 12 is made; the analog model agrees with its scene; Figure 13 is flown for a few pings."""

from pathlib import Path

import numpy as np
import pytest

from system.experiment import Report
from system.papers.wen2022 import fig5 as wen2022_fig5
from system.papers.wen2022 import fig12 as wen2022_fig12
from system.papers.wen2022 import fig13 as wen2022_fig13
from system.plot import save_picture
from system.spiking_bat.scene import OBSTACLES


@pytest.fixture(scope="module")
def figure_12() -> Report:
    return wen2022_fig12.reproduce(lambda _: None)


def test_all_rows_of_figure_12_agree(figure_12: Report) -> None:
    assert [row.name for row in figure_12.rows if not row.agrees] == []


def test_figure_12_is_drawn(figure_12: Report, tmp_path: Path) -> None:
    save_picture(str(tmp_path / "figure.png"), figure_12.draw)
    assert (tmp_path / "figure.png").stat().st_size > 50_000


def test_the_scene_does_for_the_analog_model() -> None:
    report = wen2022_fig5.reproduce(lambda _: None, OBSTACLES)
    assert [row.name for row in report.rows if not row.agrees] == []


def test_groups_end_where_latencies_jump_or_arcs_are_missing() -> None:
    late = np.full(33, np.nan)
    late[[2, 3, 4, 7, 8]] = 0.020, 0.021, 0.025, 0.025, 0.0225
    assert wen2022_fig12.groups(late) == [[2, 3], [4], [7, 8]]


def test_a_short_flight_says_that_it_did_not_cross(tmp_path: Path) -> None:
    done: list[float] = []
    report = wen2022_fig13.reproduce(done.append, forests=1, first=1000, pings=4)
    assert done[-1] == 1.0
    assert done == sorted(done)
    assert not report.rows[0].agrees
    assert "0 crossings" in report.notes[0]
    save_picture(str(tmp_path / "flight.png"), report.draw)
    assert (tmp_path / "flight.png").stat().st_size > 20_000
