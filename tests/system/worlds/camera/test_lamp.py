"""Lights in the picture."""

from __future__ import annotations

import math

import numpy as np
import pytest

from system.worlds.arena.file import load_scene
from system.worlds.arena.motion import place_bodies
from system.worlds.arena.scene import Led
from system.worlds.camera.lamp import find_lamps, is_on, no_glow
from system.worlds.camera.project import sketch_of
from system.worlds.camera.render import render
from system.worlds.camera.sensor import Dvs, camera_of
from system.worlds.camera.stage import stage_of


def glow_at(pose: tuple[float, float, float]) -> tuple[np.ndarray, np.ndarray]:
    """Pixels (column, row) and lux of the target's light."""
    stage, camera = stage_of(load_scene("target")), camera_of(Dvs(ahead=0.0))
    sketch, glow = sketch_of(stage, camera), no_glow()
    place_bodies(stage.motions, 0.0, sketch.pose)
    render(stage, camera, sketch, *pose)
    find_lamps(stage, camera, sketch, glow, *pose)
    n = int(glow.used[0])
    return np.stack(np.divmod(glow.pixel[:n], 128), axis=1), glow.lux[:n]


@pytest.mark.parametrize("distance", [1.5, 0.8, 0.3])
def test_its_light_is_its_area_and_its_centre_is_in_place(distance: float) -> None:
    pixels, lux = glow_at((2.0 - distance, 1.2 - 0.1, 0.0))
    scale = 64.0 / math.tan(math.radians(30.0)) / distance
    area = math.pi * 0.0025**2 * scale**2
    # beyond four sigma of the blur nothing is added: 6e-5 on either axis
    assert lux.sum() == pytest.approx(Led().luminance * area, rel=2e-4)
    centre = (lux[:, None] * (pixels + 0.5)).sum(axis=0) / lux.sum()
    # sampled by pixels, a Gaussian of 0.8 has its centre of mass within exp(-2 (pi 0.8)^2) < 1e-5 of a pixel;
    # what is cut off beyond four sigma moves it by up to 1e-3
    assert centre == pytest.approx([64.0 - 0.1 * scale, 64.0 + 0.035 * scale], abs=2e-3)


def test_behind_the_camera_it_is_not_seen() -> None:
    assert len(glow_at((2.3, 1.2, 0.0))[0]) == 0
    assert len(glow_at((1.0, 1.2, math.pi))[0]) == 0


def test_it_is_on_for_its_share_of_a_period() -> None:
    lamp = np.array([0.11, 0.0025, 5e4, 5e-3, 0.75, 0.0])
    on = [is_on(lamp, 5e-5 + 1e-4 * k) for k in range(1000)]
    assert np.mean(on) == pytest.approx(0.75, abs=0.01)
