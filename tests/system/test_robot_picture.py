"""The robot's picture: a disc a pipe, a ray a ping."""

from __future__ import annotations

import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

from system.robot import Scenario, run
from system.robot_picture import NAMES, RAY, draw_robot


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
