"""Steps, dead zones, ranges and counts are those of the board."""

import numpy as np
import pytest

from chips.coach import readout
from circuits.errors import ParameterError

BOARD = readout.Board()


def test_the_host_cuts_a_voltage_down_to_a_code() -> None:
    assert readout.set_level(BOARD, "AIN0", 1.65, 1.8) == pytest.approx(
        1.6487, abs=5e-5
    )  # as the laboratory has it
    assert readout.set_level(BOARD, "AIN0", 1.5 * readout.DAC_STEP, 1.8) == readout.DAC_STEP
    assert readout.set_level(readout.Board(dac_offset=-10e-3), "AIN0", 0.0, 1.8) == 0.0
    with pytest.raises(ParameterError, match=r"AIN0: 1.9 V, must be within 0 V and the supply of 1.8 V"):
        readout.set_level(BOARD, "AIN0", 1.9, 1.8)


def test_the_buffer_ends_before_the_rails_and_the_adc_has_steps() -> None:
    found = readout.read_level(BOARD, np.array([0.0, 0.5, 1.8]))
    assert found[0] == pytest.approx(13e-3, abs=readout.ADC_STEP)
    assert found[2] == pytest.approx(1.781, abs=readout.ADC_STEP)
    assert 0.0 <= 0.5 - found[1] < readout.ADC_STEP
    assert np.allclose(found / readout.ADC_STEP, np.round(found / readout.ADC_STEP))
    assert 0.0 <= 0.5 - float(readout.read_level(BOARD, 0.5, readout.FAST_STEP)) < readout.FAST_STEP
    assert abs(readout.interference(BOARD, np.linspace(0.0, 1e-3, 1000), 0.0)).max() == pytest.approx(
        1.5e-3, rel=0.01
    )


def test_an_ammeter_has_a_dead_zone_and_a_full_scale() -> None:
    low, high = readout.RANGES["low"], readout.RANGES["high"]
    assert readout.read_ammeter(BOARD, 15e-9, low) == 0.0
    assert readout.read_ammeter(BOARD, 25e-9, low) == pytest.approx(25e-9, abs=0.25e-9)
    assert readout.read_ammeter(BOARD, 1.5e-6, high) == 0.0
    assert readout.read_ammeter(BOARD, 5e-6, low) == pytest.approx(low.full, rel=1e-3)
    assert readout.read_ammeter(BOARD, -50e-6, high) == pytest.approx(50e-6, abs=25e-9)


def test_counts_are_those_of_a_charge_and_a_dead_time() -> None:
    one = readout.channel(0)
    closed = 0.1 / (one.charge / 5e-9 + one.dead_time)
    assert readout.read_counts(BOARD, one, 5e-9, 0.1, 0.0) == pytest.approx(closed + 3.0, abs=1.0)
    assert readout.counted_current(BOARD, one, closed + 3.0, 0.1) == pytest.approx(5e-9)
    assert readout.counted_current(BOARD, one, 0, 0.1) < 10e-12  # one event at least
    assert readout.read_counts(BOARD, readout.CHANNELS[6], 2e-9, 0.1, 0.0) % 2 == 0  # counts twice
    assert readout.read_counts(BOARD, one, 0.0, 0.1, 0.0) == 3  # dark
    assert readout.read_counts(BOARD, one, 1e-3, 10.0, 0.0) == 65_535


def test_above_the_range_readings_scatter() -> None:
    one = readout.channel(0)
    low, high = (
        np.std([readout.read_counts(BOARD, one, i, 0.1, z) for z in (-1.0, 0.0, 1.0)])
        / (0.1 / (one.charge / i + one.dead_time))
        for i in (5e-9, 45e-9)
    )
    assert low < 0.01
    assert 0.1 < high < 0.2


def test_what_cannot_be() -> None:
    with pytest.raises(ParameterError, match=r"C2F16: must be a channel from 0 to 15"):
        readout.channel(16)
    with pytest.raises(ParameterError, match=r"counts: 0 s, must be > 0"):
        readout.read_counts(BOARD, readout.channel(0), 1e-9, 0.0, 0.0)
