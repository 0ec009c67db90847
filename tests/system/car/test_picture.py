"""The robot's picture: a disc a pipe, a ray a ping."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

from system.car.picture import NAMES, RAY, draw_robot
from system.car.run import SYSTEM, run
from system.car.scenario import Scenario
from tests.pictures import figure_of_files, leaving, legend_of


def test_each_ping_has_a_ray_in_its_direction() -> None:
    trace = run(Scenario(forest="open", ranges="exact", pings=150, seed=2))
    ax = Figure().subplots()
    draw_robot(trace.forest, trace.arcs, trace.path, trace.drive.log, 0.1, ax)
    rays = {str(c.get_label()): c.get_segments() for c in ax.collections if isinstance(c, LineCollection)}
    assert sum(len(each) for each in rays.values()) == len(trace.drive.log)
    assert set(rays) <= {f"ping {name}" for name in NAMES}
    first = rays["ping middle"][0]
    heading = trace.drive.log[0, 3]
    assert np.allclose(first[1] - first[0], [RAY * np.cos(heading), RAY * np.sin(heading)])
    assert len(ax.patches) == len(trace.forest.place)


@pytest.mark.parametrize(
    ("seed", "forest", "label"), [(1000, "corridor", "succeeded"), (1003, "dense", "failed")]
)
def test_only_a_failure_is_a_cross(seed: int, forest: str, label: str) -> None:
    trace, figure = run(Scenario(forest=forest, seed=seed)), Figure()
    SYSTEM.draw(trace, figure)
    marks = {str(line.get_label()): line.get_marker() for line in figure.axes[0].lines}
    assert (f"end: {label}" in marks, "x" in marks.values()) == (True, label == "failed")


def test_the_legend_names_pipes_and_their_zones() -> None:
    trace, figure = run(Scenario(forest="corridor", seed=1000, pings=50)), figure_of_files()
    SYSTEM.draw(trace, figure)
    zone = f"zone of collision, radius {trace.scenario.robot.zone:g} m"
    assert {zone, "pipe, radius 2.5 cm", "path", "start"} <= legend_of(figure)
    assert leaving(figure) == []
