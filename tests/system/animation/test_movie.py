"""Moving pictures of a film: what is where in a frame, how many frames there are, and what is refused."""

import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from circuits.errors import DataError, ParameterError, SimulatorError
from system.animation.frame import begin_reel
from system.animation.movie import Frames, check_animation, read_frames, save_animation
from system.cli.command_line import main
from system.view.film import Film
from system.view.kept import keep
from tests.system.view.films import film


def moved(one: Any, other: Any) -> Any:
    """Columns of the upper half in which two frames differ."""
    different = (one != other).any(axis=2)[: len(one) // 2]
    return np.flatnonzero(different.any(axis=0))


def test_a_frame_shows_the_film_at_its_time() -> None:
    blind = replace(film(), eye=None)
    reel = begin_reel(blind, 400, 300, 1.0)
    frames = [reel.frame(t) for t in (0.0, 5.0, 10.0, 5.0)]
    assert frames[0].shape == (300, 400, 3)
    assert np.array_equal(frames[1], frames[3])  # what moves leaves nothing behind
    early, late = moved(frames[0], frames[1]), moved(frames[1], frames[2])
    assert early.mean() < late.mean()  # the robot goes to the right
    without = [int((f[150:] > 250).all(axis=2).sum()) for f in frames[:3]]
    assert without[0] > without[1] > without[2]  # what is to come is pale


def test_frames_follow_the_rate_and_the_speed(tmp_path: Path) -> None:
    shares: list[float] = []
    short = replace(film(), duration=0.5)
    path = tmp_path / "film.gif"
    assert save_animation(str(path), short, Frames(300, 240, 10, 0.5), shares.append) == 11
    assert shares[-1] == 1.0
    assert len(shares) == 11
    with Image.open(path) as found:
        assert found.n_frames == 11  # type: ignore[attr-defined]
        assert found.size == (300, 240)
        assert found.info["duration"] == 100
    assert Frames().speed_of(film()) == 1.0
    assert Frames().speed_of(short) == pytest.approx(0.1)  # or it were over at once
    assert read_frames("640x480@25x4") == Frames(640, 480, 25, 4.0)


@pytest.mark.parametrize("suffix", [".mp4", ".webm"])
def test_ffmpeg_writes_it_and_view_makes_it_of_a_kept_run(tmp_path: Path, suffix: str) -> None:
    run, path = tmp_path / "run.nc", tmp_path / f"film{suffix}"
    keep(str(run), replace(film(), duration=0.3))
    assert main(["view", str(run), "-o", str(path), "--frames", "480x360@10x1"]) == 0
    head = path.read_bytes()[:12]
    assert head[4:8] == b"ftyp" if suffix == ".mp4" else head[:4] == b"\x1a\x45\xdf\xa3"
    assert main(["view", str(run), "--beside", str(run), "-o", str(path)]) == 2


def test_what_cannot_be_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for text in ("960", "960x720", "961x720@20", "300x720@20", "960x720@0", "960x720@20x0"):
        with pytest.raises(ParameterError, match="frames: "):
            read_frames(text)
    with pytest.raises(ParameterError, match="hundredths of one; give 10, 20, 25 or 50"):
        check_animation("a.gif", Frames(rate=24))
    with pytest.raises(DataError, match="there is no folder"):
        check_animation("/nonexistent/a.gif", Frames())
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    with pytest.raises(SimulatorError, match=r"a.mp4 needs it; pip install imageio-ffmpeg, or write a .gif"):
        check_animation(str(tmp_path / "a.mp4"), Frames())


def test_the_smallest_frame_has_room_for_all_and_a_film_without_a_world_its_panels_alone() -> None:
    full = replace(film(), panels=film().panels * 3)
    assert begin_reel(full, 480, 360, 0.5).frame(1.0).shape == (360, 480, 3)  # without a warning
    bare: Film = replace(film(), world=None, eye=None, panels=film().panels[:1])
    frame = begin_reel(bare, 300, 200, 1.0).frame(1.0)
    assert frame.std() > 5.0
