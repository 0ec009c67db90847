"""Readings of a ranging chip with noise: the table, what a later release does, and draws."""

import numpy as np
import pytest

from chips.noise import SiliconNoise
from chips.ranging.noise import spread
from circuits.devices.noise import WHITE_ONLY
from circuits.silicon.process import AMI_1500_IDEAL, ELEMENTARY_CHARGE
from circuits.silicon.silicon import Silicon
from system.openspace.reader import STEP, delays, first_neurons, neurons_of, readings, values_of
from system.openspace.reader_noise import late_spikes, next_ping, no_reader, read, reader_of
from system.openspace.senses import EXACT, begin_again

SILICON = Silicon(AMI_1500_IDEAL)
NOISE = SiliconNoise(1, flicker=WHITE_ONLY)


def quiet():
    """A reader before any ping: no neuron is moved."""
    return reader_of(SILICON, "nominal", NOISE, bias_kind="gate")


def all_of(reader):
    return np.array([read(reader, d) for d in delays()])


def same(a, b):
    return (a == b) | (np.isnan(a) & np.isnan(b))


def test_without_jitter_it_reads_as_the_table():
    reader, table = quiet(), readings(SILICON, "nominal", bias_kind="gate")[0]
    assert same(all_of(reader), table).all()
    between = np.random.default_rng(0).uniform(0.0, 30e-3, 500)
    found = np.array([read(reader, d) for d in between])
    assert same(found, table[np.rint(between / STEP).astype(int)]).all()
    assert reader_of(SILICON, "nominal", None).value.size == no_reader().value.size == 0


@pytest.mark.parametrize("steps", [-1, 2])
def test_a_release_that_moved_is_an_echo_that_did(steps):
    """Against the chip's kernel with all inhibitions longer by some `STEP`s."""
    reader = quiet()
    reader.t_inh[:] += steps * STEP
    neurons = neurons_of(SILICON, bias_kind="gate")
    table = first_neurons(neurons._replace(t_inh=reader.t_inh.copy()))
    values = values_of(SILICON, "nominal", bias_kind="gate")
    expected = np.where(table.first < 0, np.nan, values[table.first])
    # 3 of 611 delays are at the table's edge or too near to call
    assert (~same(all_of(reader), expected)).sum() <= 3
    assert (~same(all_of(quiet()), expected)).sum() > 10


def test_late_spikes_are_those_of_the_chip():
    late, doubts = late_spikes(neurons_of(SILICON, bias_kind="gate"))
    first = np.where(np.isfinite(late.min(axis=0)), late.argmin(axis=0), -1)
    table = first_neurons(neurons_of(SILICON, bias_kind="gate"))
    assert np.array_equal(first, table.first)
    assert doubts == table.doubts


def test_pings_scatter_by_the_shot_noise_of_the_inhibition():
    reader = quiet()
    drawn = []
    for k in range(400):
        next_ping(reader, 0.1 * k)
        drawn.append(reader.t_inh - reader.jitter.t_inh)
    own = reader.jitter.t_inh
    # sqrt(q t_inh / I) of neuron 12, 40.1 pA
    expected = np.sqrt(ELEMENTARY_CHARGE * own[12] / 40.1e-12)
    assert np.std(drawn, axis=0)[12] == pytest.approx(expected, rel=0.12)  # 400 pings know 3.5 %
    assert spread(reader.jitter)[12] == pytest.approx(expected, rel=1e-3)


def test_a_run_forgets_the_flicker_of_the_one_before():
    reader = reader_of(SILICON, "nominal", SiliconNoise(1), 4.0, "gate")
    next_ping(reader, 10.0)
    before = reader.t_inh.copy()
    begin_again(EXACT._replace(reader=reader))
    next_ping(reader, 0.0)
    assert np.isfinite(reader.t_inh).all()
    assert not np.array_equal(reader.t_inh, before)


def test_flicker_is_as_one_over_the_area():
    small, large = (spread(reader_of(SILICON, "nominal", SiliconNoise(1), a, "gate").jitter) for a in (1, 4))
    white = spread(reader_of(SILICON, "nominal", NOISE, bias_kind="gate").jitter)
    assert small**2 - white**2 == pytest.approx(4.0 * (large**2 - white**2), rel=1e-6)
