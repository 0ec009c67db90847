"""Animations have a frame a ping, and follow the bat across the border."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from circuits.errors import DataError, ParameterError
from system.forest.animation import begin_film, check_animation, save_animation, show_frame
from system.forest.run import run
from system.forest.scenario import Scenario
from tests.pictures import figure_of_files, leaving, legend_of


def test_a_frame_a_ping(tmp_path: Path) -> None:
    trace = run(Scenario(obstacles=300, pings=5, rows=5, seed=2))
    path, shares = tmp_path / "flight.gif", list[float]()
    bat = trace.scenario.bat
    assert save_animation(str(path), bat, trace.first, frames=4, progress=shares.append) == 4
    assert shares == [0.25, 0.5, 0.75, 1.0]
    with Image.open(path) as film:
        assert film.n_frames == 4  # type: ignore[attr-defined]
        one = np.asarray(film.convert("RGB"))
        film.seek(3)
        other = np.asarray(film.convert("RGB"))
    assert one.std() > 5.0  # not an empty figure
    assert (one != other).any(axis=2).mean() > 0.01


def test_a_frame_is_moved_and_not_drawn_anew() -> None:
    trace, figure = run(Scenario(obstacles=300, pings=5, rows=5, seed=2)), figure_of_files()
    film = begin_film(trace.scenario.bat, trace.first, figure, "failed: collided with an obstacle")
    before = figure.findobj()
    assert legend_of(figure) == {
        "zone of collision, radius 0.3 m", "path", "arcs to choose from", "chosen arc",
        "field of view of the ping", "bat",
    }  # fmt: skip
    assert leaving(figure) == []
    show_frame(film, 3)
    drawn = set(map(id, before))
    assert all(id(artist) in drawn for artist in film.ax.lines + film.ax.collections)
    place = trace.first.log[3, 1:3]
    assert np.allclose(np.ravel(film.sight.bat.get_data()), place)
    assert np.allclose(film.sight.chosen.get_xydata()[0], place)
    assert film.ax.get_title().startswith(f"{trace.first.log[3, 0]:.1f} s")


def test_names_that_are_none() -> None:
    with pytest.raises(ParameterError, match=r"must end with \.gif"):
        check_animation("flight.mp4")
    with pytest.raises(DataError, match="there is no folder"):
        check_animation("/nonexistent/flight.gif")
