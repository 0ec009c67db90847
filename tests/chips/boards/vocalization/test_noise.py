"""Jitter of call intervals: the model draws what the closed forms say."""

import numpy as np
import pytest

from chips.boards.vocalization.model import VocalizationModel
from chips.boards.vocalization.noise import (
    comparator_jitter,
    interval_spread,
    no_oscillator_noise,
    phase_after_call,
)
from chips.noise import SiliconNoise
from chips.shot_noise import current_wander, steepness
from circuits.blocks.sonar import vocalization_controller as board
from circuits.devices.noise import WHITE_ONLY
from circuits.lowering.kernel import to_kernel
from circuits.silicon.process import AMI_1500_IDEAL, BOLTZMANN, kelvin
from circuits.silicon.silicon import Silicon
from circuits.solver.noise.event_jitter import event_jitter

SILICON = Silicon(AMI_1500_IDEAL)
WHITE = SiliconNoise(1, flicker=WHITE_ONLY)
PROXIMITY = 1.5
BOARD = {"proximity": 3.0, "amplitude_control": None, "duration": None}
RISE = 76.1  # V/s, of the ramp there


def calls(noise, count=400):
    """Call times at a constant proximity."""
    model = VocalizationModel(SILICON, noise=noise)
    line = {"proximity": (np.zeros(1), np.full(1, PROXIMITY))}
    state, found = model.begin(), []
    while len(found) < count:
        state, _, output = model.advance(state, state.time + 1.0, (), line)
        found += [time for _, time in output.events]
    return np.array(found), model.numbers


@pytest.mark.parametrize("noise", [WHITE, SiliconNoise(1)], ids=["white", "all"])
def test_intervals_scatter_by_their_spread(noise):
    found, numbers = calls(noise)
    rate = numbers.base + numbers.slope * PROXIMITY
    expected = interval_spread(numbers, SILICON, noise, np.array([rate]))[0] / rate
    # 399 intervals know 3.5 %; five knots over the rate are 1 % off
    assert np.diff(found).std() == pytest.approx(expected, rel=0.12)
    assert np.diff(found).mean() == pytest.approx(1.0 / rate + numbers.dead, rel=1e-4)


def test_without_noise_intervals_are_alike():
    found, _ = calls(None, 20)
    assert np.diff(found)[1:] == pytest.approx(np.diff(found)[1], abs=1e-12)
    assert phase_after_call(no_oscillator_noise(), 3, 20.0) == 0.0
    assert np.array_equal(calls(WHITE, 20)[0], calls(WHITE, 20)[0])
    assert not np.array_equal(calls(WHITE, 20)[0], calls(SiliconNoise(2, flicker=WHITE_ONLY), 20)[0])


def test_flicker_adds_that_of_both_mirror_transistors():
    numbers = VocalizationModel(SILICON).numbers
    rate = np.array([17.0])
    white, both = (interval_spread(numbers, SILICON, n, rate) for n in (WHITE, SiliconNoise(1)))
    # 60 x 6 um with 4.2 uA: I_S of the pFETs is the law's times 10
    psi = steepness(4.2e-6, 10.0 * SILICON.law("p").square_current)
    wander = current_wander(SILICON, SiliconNoise(1), "p", 360e-12, 1.0 / rate, psi)
    assert both**2 - white**2 == pytest.approx(2.0 * wander, rel=0.05)


def test_a_fast_ramp_meets_the_noise_of_the_moment_and_a_slow_one_its_mean():
    """At most sqrt(k T / C) of the threshold's node, over the slope; a slower ramp takes a longer mean."""
    thermal = np.sqrt(BOLTZMANN * kelvin(27.0) / 5e-12)
    volts = [comparator_jitter(slope, SILICON) * slope for slope in (20.0, 400.0, 4e3)]
    assert volts[0] < volts[1] < volts[2] < thermal
    assert volts[0] == pytest.approx(0.3 * thermal, rel=0.2)


def test_an_interval_scatters_as_that_of_the_whole_board():
    """The board's second call without what its first one has, linear theory, within 8 %.

    1 % is the run's tolerance; strays and the delay of the inverter that ends a call are left out. Without
    the noise with which a call ends it would be 0.52 of it.
    """
    machine = to_kernel(board.testbench(board.build(), BOARD, SILICON.process.v_dd), SILICON)
    first, second = (event_jitter(machine, "call", WHITE_ONLY, number=k, rtol=1e-8) for k in (0, 1))
    numbers = VocalizationModel(SILICON).numbers
    rate = numbers.base + numbers.slope * 3.0
    spread = interval_spread(numbers, SILICON, WHITE, np.array([rate]))[0] / rate
    theirs = np.sqrt(second.deviation**2 - first.deviation**2)
    assert spread / theirs == pytest.approx(1.0, abs=0.08)
    met = comparator_jitter(RISE, SILICON)
    assert met == pytest.approx(first.deviation, rel=0.05)
    assert met / theirs == pytest.approx(0.52, abs=0.04)
