"""Animations have a frame a ping, and follow the bat across the border."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from circuits.errors import DataError, ParameterError
from system.forest.animation import check_animation, save_animation
from system.forest.run import run
from system.forest.scenario import Scenario


def test_a_frame_a_ping(tmp_path: Path) -> None:
    trace = run(Scenario(obstacles=300, pings=5, rows=5, seed=2))
    path = tmp_path / "flight.gif"
    assert save_animation(str(path), trace.scenario.bat, trace.first, frames=4) == 4
    with Image.open(path) as film:
        assert film.n_frames == 4  # type: ignore[attr-defined]
        one = np.asarray(film.convert("RGB"))
        film.seek(3)
        other = np.asarray(film.convert("RGB"))
    assert one.std() > 5.0  # not an empty figure
    assert (one != other).any(axis=2).mean() > 0.01


def test_names_that_are_none() -> None:
    with pytest.raises(ParameterError, match=r"must end with \.gif"):
        check_animation("flight.mp4")
    with pytest.raises(DataError, match="there is no folder"):
        check_animation("/nonexistent/flight.gif")
