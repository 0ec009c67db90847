"""Readings of whole pings by a calibrated chip: finer than its windows, in trains, noisy and warm."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from chips.codes import Codes
from chips.noise import SiliconNoise
from chips.ranging.calibration.calibrate import calibrate
from chips.ranging.response import respond
from circuits.arrays import F64
from circuits.errors import ParameterError
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500
from circuits.silicon.silicon import Silicon
from system.car.numbers import Robot
from system.car.run import sonar_of
from system.car.scenario import Scenario as Car
from system.openspace.law import Bat
from system.openspace.population import (
    SOON,
    Coded,
    Population,
    coded,
    forget,
    hear_ping,
    no_population,
    population_on,
    unsure_delays,
)
from system.openspace.reader import WINDOW, delays, late_spikes
from system.openspace.senses import Sensing, senses_of
from system.worlds.sound.acoustics import speed_of_sound

SILICON = Silicon(AMI_1500, die=Die(number=4))
USED = (delays() > 1.2e-3) & (delays() < 28.5e-3)
SPEED = speed_of_sound(293.15)


@pytest.fixture(scope="module")
def codes() -> Codes:
    return calibrate(SILICON, "generator")


@pytest.fixture(scope="module")
def chip(codes: Codes) -> Coded:
    return coded(SILICON, codes)


def read(population: Population, time: float, echoes: F64) -> F64:
    """Readings of a ping's echoes, s."""
    population.echo[: echoes.size, 0] = echoes
    hear_ping(population, time, echoes.size)
    return population.echo[: echoes.size, 1].copy()


def lone_readings(chip: Coded) -> F64:
    """What a chip without noise reads of an echo alone at each of `delays`, s, NaN for none."""
    population, each = population_on(chip), delays()
    return np.array([read(population, 0.2 * (k + 1), each[k : k + 1])[0] for k in range(each.size)])


def trains(count: int) -> list[F64]:
    """Delays of the echoes of pings in a forest, s: about 6.5 a ping, evenly over the area up to 5 m."""
    random = np.random.default_rng(3)
    far = [5.0 * np.sqrt(random.uniform(0.004, 1.0, max(1, random.poisson(6.5)))) for _ in range(count)]
    return [2.0 * np.sort(each) / SPEED for each in far]


def _error(found: F64, true: F64 | None = None) -> float:
    """Rms, in m of range; of an echo alone at each of the delays that are used unless `true` is given."""
    off = (found - delays())[USED] if true is None else found - true
    return 0.5 * SPEED * float(np.sqrt(np.mean(off**2)))


def test_a_die_reads_finer_than_its_windows_and_misses_nothing(chip: Coded) -> None:
    found = lone_readings(chip)
    # thirteen windows of 2.17 ms: at best 0.11 m; 0.1 m suffices for the bat
    assert _error(found) < 0.05
    assert unsure_delays(chip) < 20
    assert len({*found[USED].tolist()}) > 100


def test_neurons_that_are_off_are_not_read(chip: Coded) -> None:
    late = late_spikes(chip.neurons())[0]
    alone = (late[5] <= WINDOW) & ((late <= WINDOW).sum(axis=0) == 1)
    assert alone.any()
    found = lone_readings(replace(chip, off=(5,)))
    assert np.isnan(found[alone]).all()
    assert np.isnan(found[USED]).sum() < 60


def test_echoes_that_its_robot_cannot_meet_do_not_count(chip: Coded) -> None:
    nearest = 2.0e-3  # s, 0.34 m: what is nearer has been collided with
    plain, found = (lone_readings(c) for c in (chip, replace(chip, nearest=nearest)))
    met = delays() >= nearest
    assert np.nanmin(plain) < nearest <= np.nanmin(found[met])
    assert np.array_equal(plain[delays() > 4e-3], found[delays() > 4e-3], equal_nan=True)


@pytest.mark.parametrize("celsius", [17.0, 37.0])
def test_at_another_temperature_the_table_of_the_bench_is_scaled(chip: Coded, celsius: float) -> None:
    warmer = (celsius + 273.15) / 300.15
    found = lone_readings(chip.at(celsius))
    assert _error(found) < 0.09
    assert _error(found * warmer) > 1.3 * _error(found)


def test_noise_moves_readings_by_little(chip: Coded) -> None:
    population, still = population_on(chip, SiliconNoise(1)), lone_readings(chip)
    moved = np.array([read(population, 0.2 * (k + 1), delays()[k : k + 1])[0] for k in range(delays().size)])
    assert 0.0 < 0.5 * SPEED * np.abs(moved - still)[USED].mean() < 0.02
    assert _error(moved) < 0.06


@pytest.mark.parametrize("noise", [None, SiliconNoise(1)])
def test_echoes_of_a_whole_ping_are_read_as_well(chip: Coded, noise: SiliconNoise | None) -> None:
    population, pings = population_on(chip, noise), trains(300)
    found = [read(population, 0.2 * (k + 1), ping) for k, ping in enumerate(pings)]
    assert all((later >= sooner).all() for each in found for sooner, later in pairwise(each))
    off = np.concatenate(found) - np.concatenate(pings)
    assert not np.isnan(off).any()
    assert _error(np.concatenate(found), np.concatenate(pings)) < 0.09
    assert np.abs(off).max() * 0.5 * SPEED < 0.7


def test_an_echo_in_the_window_of_neurons_that_have_spiked_is_not_taken_for_theirs(chip: Coded) -> None:
    near = 5e-3
    for far in (6e-3, 8e-3, 10e-3, 15e-3):
        first, second = read(population_on(chip), 0.2, np.array([near, far]))
        alone = read(population_on(chip), 0.2, np.array([near]))
        assert first == alone
        assert second == pytest.approx(far, abs=2.0 * 0.2 / SPEED)


def test_echoes_that_come_before_the_answer_are_one(chip: Coded) -> None:
    population = population_on(chip)
    same = read(population, 0.2, np.array([5e-3, 5e-3 + 5e-6]))  # within a pulse on the board
    assert same[0] == same[1]
    close = read(population, 0.4, np.array([5e-3, 5e-3 + 0.02e-3]))
    assert close[0] == close[1] == pytest.approx(5e-3, abs=SOON)


def test_spikes_of_a_ping_are_those_of_its_neurons(chip: Coded) -> None:
    population, echoes = population_on(chip), np.array([4e-3, 11e-3, 19e-3])
    read(population, 0.2, echoes)
    times, who = population.spoke()
    until = float(echoes[-1]) + WINDOW
    expected = respond(chip.neurons(), [0.0], echoes.tolist(), until).spikes
    assert sum(each.size for each in expected) > 3
    for k, each in enumerate(expected):
        assert times[who == k] - 0.2 == pytest.approx(each, abs=2e-6)


def test_a_run_is_the_same_again_and_pings_in_a_row_are_those_of_a_chip_at_rest(chip: Coded) -> None:
    population, pings = population_on(chip), trains(20)
    once = [read(population, 0.2 * (k + 1), ping) for k, ping in enumerate(pings)]
    forget(population)
    again = [read(population, 0.2 * (k + 1), ping) for k, ping in enumerate(pings)]
    sooner = [read(population, 10.0 + 0.08 * k, ping) for k, ping in enumerate(pings)]
    assert all(np.array_equal(a, b) for a, b in zip(once, again, strict=True))
    assert np.concatenate(sooner) == pytest.approx(np.concatenate(once), abs=0.05e-3)


def test_outside_the_box_it_is_refused(chip: Coded) -> None:
    with pytest.raises(ParameterError, match=r"ranging_chip.temperature: 90 degC"):
        population_on(chip.at(90.0))


def test_without_a_chip_there_is_no_neuron() -> None:
    assert no_population().on.size == no_population().met.size == 0


def test_a_call_before_the_last_ping_is_answered_is_refused(codes: Codes) -> None:
    heard = Sensing("chip")
    with pytest.raises(
        ParameterError, match=r"ping_rate: 40 Hz, must be <= 30\.6 Hz, or a call comes before"
    ):
        senses_of(heard, Bat(ping_rate=40.0), SILICON, codes=codes)
    senses_of(heard, Bat(ping_rate=30.0), SILICON, codes=codes)
    with pytest.raises(ParameterError, match=r"ping_rate: 80 Hz, must be <= 62\.\d Hz"):
        sonar_of(
            Car(ranges="chip", die=Die(number=1000), robot=Robot(ping_rate=80.0)), np.random.default_rng(0)
        )
