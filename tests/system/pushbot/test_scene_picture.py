"""Pictures of a drive."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.figure import Figure

from circuits.silicon.die import Die
from system.pushbot.drive import Order, begin_run, drive
from system.pushbot.scene_picture import draw_events, draw_events_key, draw_path, draw_scene
from system.worlds.arena.file import load_scene, scene_names
from system.worlds.camera.event import joined
from tests.pictures import legend_of


@pytest.mark.parametrize("name", scene_names())
def test_every_scene_can_be_drawn(name: str) -> None:
    ax = Figure().subplots()
    scene = load_scene(name, seed=1)
    draw_scene(scene, ax, 1.0)
    assert len(ax.patches) == 1 + len(scene.shades) + len(scene.bodies)


def test_a_path_has_the_robot_at_its_start_and_at_moments() -> None:
    run = begin_run(load_scene("chase"), seed=1, die=Die(number=1003))
    drive(run, [Order(0.4, 0.3)])
    ax = Figure().subplots()
    draw_path(np.array(run.path), ax, (0.2, 0.4))
    assert len(ax.patches) == 3
    assert [text.get_text() for text in ax.texts] == ["1", "2"]


def test_events_are_coloured_by_polarity() -> None:
    run = begin_run(load_scene("pair"), seed=1, die=Die(number=1003))
    events = joined(drive(run, [Order(0.5, 0.35)]))
    ax = Figure().subplots()
    draw_events(events.where(~events.on), 128, 128, ax)
    image = np.asarray(ax.images[0].get_array())
    hit = (image < 1.0).any(axis=2)
    assert hit.any()
    assert np.all(image[hit][:, 0] > image[hit][:, 2])  # off is orange: more red than blue
    draw_events(events.where(events.on), 128, 128, ax)
    image = np.asarray(ax.images[1].get_array())
    hit = (image < 1.0).any(axis=2)
    assert np.all(image[hit][:, 0] < image[hit][:, 2])  # on is blue


def test_the_key_of_events_names_both_colours_and_the_line() -> None:
    figure = Figure()
    draw_events_key(figure.subplots())
    assert legend_of(figure) == {
        "on: brighter", "off: darker", "below it OL and OR see, above it the target field",
    }  # fmt: skip
