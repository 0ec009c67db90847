"""Tables of the ranging chip's readings against the chip itself, and what calibration and area do."""

from __future__ import annotations

import math

import numpy as np
import pytest

from chips.ranging.chip import RangingChip
from chips.ranging.circuit import BEST_DELAYS
from circuits.errors import ParameterError
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from system.openspace.reader import (
    NOBODY,
    STEP,
    WINDOW,
    delays,
    first_neurons,
    lookup,
    neurons_of,
    readings,
    share_alike,
)

NOMINAL = Silicon(AMI_1500_IDEAL)
DIE = Silicon(AMI_1500_IDEAL, die=Die(number=7, process=False))
USED = (delays() > 2e-3) & (delays() < 29e-3)


def error(silicon: Silicon, calibration: str) -> float:
    """Rms over the delays that are read, s."""
    found = readings(silicon, calibration, bias_kind="gate")[0]  # type: ignore[arg-type]
    return float(np.sqrt(np.nanmean((found - delays())[USED] ** 2)))


def spiking_first(silicon: Silicon, delay: float) -> int:
    """The first neuron after an echo, by the chip as a part of a running system."""
    chip = RangingChip(silicon)
    state = chip.begin()
    events = (("call", 10e-3), ("echo", 10e-3 + delay))
    state, reached, output = chip.advance(state, 50e-3, events)
    while reached < 50e-3:
        for name, time in output.events:
            if 10e-3 + delay <= time <= 10e-3 + delay + WINDOW:
                return int(name[6:-1])
        state, reached, output = chip.advance(state, 50e-3)
    return NOBODY


@pytest.mark.parametrize("silicon", [NOMINAL, DIE], ids=["nominal", "die"])
def test_the_table_is_the_chips(silicon: Silicon) -> None:
    table = first_neurons(neurons_of(silicon)).first
    for delay in (0.5e-3, 2.5e-3, 8.05e-3, 13e-3, 22.5e-3):
        assert table[round(delay / STEP)] == spiking_first(silicon, delay)


def test_the_nominal_die_reads_what_its_neurons_resolve() -> None:
    found = readings(NOMINAL, "nominal")[0]
    assert np.isnan(found[USED]).mean() < 0.03  # between the windows of neurons 0 to 3
    # thirteen windows of 2.17 ms: at best 2.17 ms / sqrt(12) = 0.63 ms rms
    assert 0.55e-3 < error(NOMINAL, "nominal") < 0.7e-3
    assert np.allclose(lookup(first_neurons(neurons_of(NOMINAL))), BEST_DELAYS, rtol=0.06)


def test_calibration_helps_a_die() -> None:
    assert error(DIE, "calibrated") < 0.7 * error(DIE, "nominal")


def test_a_calibrated_reader_meets_other_temperatures_with_its_own_values() -> None:
    warm = Silicon(AMI_1500_IDEAL, temperature_c=34.0)
    assert error(warm, "calibrated") > 2.0 * error(NOMINAL, "calibrated")
    shorter = readings(warm, "nominal", bias_kind="gate")[0]
    # gate voltages: the warm chip's delays are shorter, so that a far echo is past its last neuron's window
    assert np.isnan(shorter[delays() > 26e-3]).all()


def test_area_brings_a_die_to_the_nominal_one() -> None:
    own, large, nominal = (
        first_neurons(neurons_of(*which)).first for which in ((DIE,), (DIE, 1e8), (NOMINAL,))
    )
    assert (own != nominal).mean() > 0.1
    assert (large != nominal).mean() < 0.01  # a step of the table at the edge of a window


def test_a_lone_echo_of_a_train_is_the_tables() -> None:
    neurons = neurons_of(NOMINAL)
    table = first_neurons(neurons)
    lone = [np.array([d]) for d in (3.5e-3, 9e-3, 20e-3)]
    assert share_alike(neurons, table, lone) == (3, 3)


def test_echoes_of_a_ping_move_each_other() -> None:
    neurons = neurons_of(NOMINAL)
    random = np.random.default_rng(1)
    trains = [np.sort(random.uniform(2e-3, 29e-3, 6)) for _ in range(60)]
    alike, total = share_alike(neurons, first_neurons(neurons), trains)
    assert total == 360
    # the table's error that its docstring states, for another density: far from all, and far from none
    assert 0.5 < alike / total < 0.95


@pytest.mark.parametrize("area", [0.0, -1.0, math.inf])
def test_an_area_that_is_none(area: float) -> None:
    with pytest.raises(ParameterError, match=r"ranging_chip\.area: "):
        neurons_of(NOMINAL, area)


def test_a_calibration_that_is_none() -> None:
    with pytest.raises(ParameterError, match="reader: best"):
        readings(NOMINAL, "best")  # type: ignore[arg-type]
