"""Pictures of a drive."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

from circuits.silicon.die import Die
from system.plot import save_picture
from system.pushbot.drive import Order, begin_run, drive
from system.pushbot.scene_picture import draw_drive, draw_events, draw_intensity, draw_scene
from system.worlds.arena.file import load_scene, scene_names
from system.worlds.camera.event import joined
from system.worlds.camera.sensor import picture


@pytest.mark.parametrize("name", scene_names())
def test_every_scene_can_be_drawn(name: str) -> None:
    ax = Figure().subplots()
    scene = load_scene(name, seed=1)
    draw_scene(scene, ax, 1.0)
    assert len(ax.patches) == 1 + len(scene.shades) + len(scene.bodies)


def test_a_drive_makes_a_file(tmp_path: Path) -> None:
    scene = load_scene("chase")
    run = begin_run(scene, seed=1, die=Die(number=1003))
    events = joined(drive(run, [Order(0.4, 0.3)]))
    path = tmp_path / "drive.png"
    save_picture(str(path), lambda figure: draw_drive(scene, np.array(run.path), events, (0.2, 0.4), figure))
    assert path.read_bytes()[1:4] == b"PNG"


def test_events_are_coloured_by_polarity() -> None:
    run = begin_run(load_scene("pair"), seed=1, die=Die(number=1003))
    events = joined(drive(run, [Order(0.5, 0.35)]))
    ax = Figure().subplots()
    draw_events(events.where(~events.on), 128, 128, ax)
    image = np.asarray(ax.images[0].get_array())
    assert np.all(image[:, :, 1] == 1.0)  # off is green: the other two go down
    assert image[:, :, 0].min() < 1.0


def test_intensity_has_the_rows_of_the_sensor() -> None:
    run = begin_run(load_scene("pair"), seed=1)
    ax = Figure().subplots()
    draw_intensity(picture(run.sensor, run.eye), ax)
    assert np.asarray(ax.images[0].get_array()).shape == (128, 128)
