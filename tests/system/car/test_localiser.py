"""The localiser: beams, the training set, and how well it tells directions that it was not trained on."""

from __future__ import annotations

import math

import numpy as np
import pytest

from system.car.localiser import hearing, localise, trained, training_echoes, volts
from system.car.numbers import Robot
from system.worlds.sound.acoustics import beam

ROBOT = Robot()


def test_a_beam_has_half_its_power_at_half_its_width() -> None:
    edge = beam(np.array([0.5 * ROBOT.beam, -0.5 * ROBOT.beam]), ROBOT.beam)
    assert edge**2 == pytest.approx([0.5, 0.5])


def test_each_transducer_hears_best_where_it_points() -> None:
    angle = np.radians(np.arange(-90.0, 91.0))
    heard = hearing(ROBOT, angle)
    assert np.degrees(angle[heard.argmax(axis=1)]) == pytest.approx([45.0, 0.0, -45.0])


def test_the_training_set_has_910_echoes() -> None:
    u, angle = training_echoes(ROBOT)
    assert u.shape == (910, 3)
    assert len(np.unique(angle)) == 91


def test_it_tells_directions_between_the_trained_ones() -> None:
    random = np.random.default_rng(8)
    angle = np.radians(random.uniform(-45.0, 45.0, 1000))
    distance = random.uniform(0.3, 1.2, 1000)
    u = volts(ROBOT, beam(angle, ROBOT.beam) * hearing(ROBOT, angle) / distance**2).T
    off = np.degrees(localise(trained(ROBOT), u) - angle)
    # without noise; rounding to 1 degree alone is 0.29 degrees rms, the training's own noise a degree or so
    assert math.sqrt(float((off**2).mean())) < 1.5


def test_its_output_is_whole_degrees() -> None:
    u = training_echoes(ROBOT)[0][::13]
    angle = np.degrees(localise(trained(ROBOT), u))
    assert angle == pytest.approx(np.rint(angle), abs=1e-9)


def test_training_is_reproducible() -> None:
    kept = trained(ROBOT)
    trained.cache_clear()
    assert np.array_equal(kept.weights, trained(ROBOT).weights)
