"""Noise of the generator's lines: as the solver finds it in the block that is one generator and a line."""

from dataclasses import replace

import numpy as np
import pytest

from circuits.blocks.bias import generator
from circuits.devices import Transistor
from circuits.devices.noise import WHITE_ONLY, noise_model
from circuits.generator.code import codes_of
from circuits.generator.noise import following, line_noise, shared_noise
from circuits.generator.voltage import Line
from circuits.lowering.kernel import to_kernel
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500_IDEAL, ROLLS_180
from circuits.silicon.silicon import Silicon
from circuits.solver.noise.analysis import noise
from circuits.solver.operating_point import operating_point

DEVICE = Transistor("m", "n", "d", "g", "0", "0", 6e-6, 6e-6)  # of the size of the block's output device
LINES = Line((("chip", ()),), "v_tau", (3,), None, DEVICE)
CURRENT = np.array([400e-12, 100e-12, 10e-9])
MODEL = noise_model(AMI_1500_IDEAL)


@pytest.mark.parametrize("current", CURRENT.tolist())
def test_a_line_and_its_masters_make_the_noise_of_the_whole_generator(current):
    line = Line((("chip", ()),), "v_tau", (1,), None, DEVICE)
    own, shared = (
        line_noise(line, np.array([current]), Silicon(AMI_1500_IDEAL), MODEL),
        shared_noise(line, Silicon(AMI_1500_IDEAL), MODEL),
    )
    white = own.white + (following(shared.white, own) ** 2).sum(axis=1)
    flicker = own.flicker + (following(shared.flicker, own) ** 2).sum(axis=1)
    coarse, fine = codes_of(np.array([current]))[0]
    circuit = generator.build(generator.Params(coarse=int(coarse), fine=int(fine)))
    bench = generator.BLOCK.bench(circuit)
    whole = noise(
        operating_point(to_kernel(bench, Silicon(AMI_1500_IDEAL))), "v_n", np.array([1.0]), model=MODEL
    )
    # the block ends its other coarse branches at ground, where the chip's masters have diodes
    assert white == pytest.approx(whole.white.sum(), rel=5e-3)
    assert flicker == pytest.approx(whole.flicker.sum(), rel=5e-3)


def test_lines_of_a_coarse_code_follow_the_same_sources():
    own, shared = (
        line_noise(LINES, CURRENT, Silicon(AMI_1500_IDEAL), MODEL),
        shared_noise(LINES, Silicon(AMI_1500_IDEAL), MODEL),
    )
    assert own.coarse.tolist() == [5, 6, 3]
    follow = following(shared.flicker, own)
    covariance = follow @ follow.T
    asked = own.by_coarse[:, None] * shared.flicker[np.ix_(own.coarse, own.coarse)] * own.by_coarse
    np.testing.assert_allclose(covariance, asked, rtol=1e-9)
    np.testing.assert_allclose(own.by_coarse, 1.0, atol=0.03)
    correlation = covariance[0, 1] / np.sqrt(covariance[0, 0] * covariance[1, 1])
    assert 0.1 < correlation < 1.0  # by the core


def test_lines_of_two_sizes_make_the_noise_that_each_makes_alone():
    silicon, model = Silicon(ROLLS_180), noise_model(ROLLS_180)
    current = np.array([2e-12, 2e-6])
    both = line_noise(replace(LINES, shape=(2,)), current, silicon, model)
    for k in range(2):
        alone = line_noise(replace(LINES, shape=(1,)), current[k : k + 1], silicon, model)
        assert both.flicker[k] == pytest.approx(alone.flicker[0], rel=1e-9)
        assert both.white[k] == pytest.approx(alone.white[0], rel=1e-9)


def test_a_die_moves_its_lines_noise_and_white_devices_have_no_flicker():
    die = Silicon(AMI_1500_IDEAL, die=Die(number=1000))
    nominal, own = (line_noise(LINES, CURRENT, s, MODEL) for s in (Silicon(AMI_1500_IDEAL), die))
    assert (np.abs(own.white / nominal.white - 1.0) > 1e-3).all()
    assert not line_noise(LINES, CURRENT, die, WHITE_ONLY).flicker.any()
