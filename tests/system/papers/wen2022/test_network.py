"""Figure 12 of Wen & Horiuchi 2022: its groups of memories, and its scene with the analog model."""

import numpy as np

from system.papers.wen2022 import fig5 as wen2022_fig5
from system.papers.wen2022 import fig12 as wen2022_fig12
from system.spiking_bat.scene import OBSTACLES


def test_the_scene_does_for_the_analog_model() -> None:
    report = wen2022_fig5.reproduce(lambda _: None, OBSTACLES)
    assert [row.name for row in report.rows if not row.agrees] == []


def test_groups_end_where_latencies_jump_or_arcs_are_missing() -> None:
    late = np.full(33, np.nan)
    late[[2, 3, 4, 7, 8]] = 0.020, 0.021, 0.025, 0.025, 0.0225
    assert wen2022_fig12.groups(late) == [[2, 3], [4], [7, 8]]
