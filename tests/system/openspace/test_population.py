"""Readings of a calibrated chip by all that answers: finer than its windows, with noise and when warm."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from chips.codes import Codes
from chips.noise import SiliconNoise
from chips.ranging.calibration.calibrate import calibrate
from circuits.errors import ParameterError
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500
from circuits.silicon.silicon import Silicon
from system.openspace.population import Coded, coded, population_of, population_reader, population_readings
from system.openspace.reader import delays
from system.openspace.reader_noise import next_ping, read
from system.worlds.sound.acoustics import speed_of_sound

SILICON = Silicon(AMI_1500, die=Die(number=4))
USED = (delays() > 1.2e-3) & (delays() < 28.5e-3)


@pytest.fixture(scope="module")
def codes() -> Codes:
    return calibrate(SILICON, "generator")


@pytest.fixture(scope="module")
def chip(codes: Codes) -> Coded:
    return coded(SILICON, codes)


def _error(found: np.ndarray) -> float:
    """Rms, in m of range."""
    return 0.5 * speed_of_sound(293.15) * float(np.sqrt(np.mean((found - delays())[USED] ** 2)))


def test_a_die_reads_finer_than_its_windows_and_misses_nothing(chip: Coded) -> None:
    found, doubts = population_readings(chip)
    # thirteen windows of 2.17 ms: at best 0.11 m; 0.1 m suffices for the bat
    assert _error(found) < 0.08
    assert doubts < 20
    assert len({*found[USED].tolist()}) > 23


def test_neurons_that_are_off_are_not_read(chip: Coded) -> None:
    found = population_readings(replace(chip, off=(5,)))[0]
    at = round(float(np.searchsorted(delays(), chip.spare[5])))
    assert np.isnan(found[at])
    assert np.isnan(found[USED]).sum() < 60


def test_echoes_that_its_robot_cannot_meet_do_not_count(chip: Coded) -> None:
    nearest = 2.0e-3  # s, 0.34 m: what is nearer has been collided with
    plain, found = (population_readings(c)[0] for c in (chip, replace(chip, nearest=nearest)))
    met = delays() >= nearest
    assert np.nanmin(plain[met]) < nearest < np.nanmin(found[met])
    assert np.array_equal(plain[delays() > 4e-3], found[delays() > 4e-3], equal_nan=True)


@pytest.mark.parametrize("celsius", [17.0, 37.0])
def test_at_another_temperature_the_table_of_the_bench_is_scaled(chip: Coded, celsius: float) -> None:
    there = chip.at(celsius)
    warmer = (celsius + 273.15) / 300.15
    assert np.allclose(population_of(there) * warmer, population_of(chip), rtol=1e-12)
    found = population_readings(there)[0]
    assert _error(found) < 0.09
    assert _error(found * warmer) > 1.3 * _error(found)


def test_noise_moves_readings_by_little_and_none_does_not_at_all(chip: Coded) -> None:
    reader = population_reader(chip, SiliconNoise(1))
    still, table = np.array([read(reader, d) for d in delays()]), population_readings(chip)[0]
    assert np.array_equal(still, table, equal_nan=True)
    next_ping(reader, 0.1)
    moved = np.array([read(reader, d) for d in delays()])
    assert 0.0 < np.mean(moved[USED] != still[USED]) < 0.2
    assert _error(moved) < 0.08
    assert population_reader(chip, None).value.size == 0


def test_outside_the_box_it_is_refused(chip: Coded) -> None:
    with pytest.raises(ParameterError, match=r"ranging_chip.temperature: 90 degC"):
        population_readings(chip.at(90.0))
