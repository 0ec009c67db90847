"""Panels of the head's picture show what is in the log."""

import numpy as np
from matplotlib.figure import Figure

from system.head.picture import draw_angles, draw_counts, draw_raster
from system.head.run import SYSTEM

LOG = SYSTEM.run(SYSTEM.scenario(duration=3.0)).log


def test_angles_are_in_degrees_and_lost_pings_are_marked() -> None:
    ax = Figure().subplots()
    draw_angles(SYSTEM.run(SYSTEM.scenario(duration=1.0, distance=6.0, swing=0.0)).log, ax)
    labels = [line.get_label() for line in ax.lines]
    assert labels == ["target", "head", "lost: faint"]
    draw_angles(LOG, ax)
    assert np.array_equal(np.asarray(ax.lines[4].get_ydata()), np.degrees(LOG.head))


def test_every_spike_is_there() -> None:
    ax = Figure().subplots()
    draw_raster(LOG, ax)
    assert sum(len(np.asarray(line.get_xdata())) for line in ax.lines) == len(LOG.levels) > 0
    counts = Figure().subplots()
    draw_counts(LOG, counts)
    assert len(counts.collections) == 2
