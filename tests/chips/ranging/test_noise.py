"""Jitter of the behavioural rebound neurons: its size, its keys, and that it is off unless asked for."""

from dataclasses import replace

import numpy as np
import pytest

from chips.lines.wander import swing_of
from chips.noise import SiliconNoise
from chips.ranging import circuit as ranging_chip
from chips.ranging.chip import RangingChip
from chips.ranging.kernel import new_chip, new_plan, next_due, on_call, on_echo, take
from chips.ranging.neuron_kernel import RELEASE
from chips.ranging.noise import most, next_durations, no_jitter, spread
from circuits.bias import lines_of
from circuits.devices.noise import WHITE_ONLY, NoiseModel
from circuits.errors import ParameterError
from circuits.generator.ripple import Ripple, line_response
from circuits.silicon.process import AMI_1500_IDEAL, ELEMENTARY_CHARGE
from circuits.silicon.silicon import Silicon

WHITE = SiliconNoise(5, flicker=WHITE_ONLY)


def durations(noise: SiliconNoise, calls: int, interval: float = 0.1) -> np.ndarray:
    """t_inh after calls `interval` s apart, float64[calls, 13], s."""
    jitter = RangingChip(Silicon(AMI_1500_IDEAL), noise=noise, bias_kind="gate").jitter_at(27.0)
    assert jitter is not None
    found = np.zeros((calls, ranging_chip.NEURONS))
    for k, row in enumerate(found):
        next_durations(jitter, k * interval, row)
    return found


def test_white_jitter_is_the_shot_noise_of_the_bias_current() -> None:
    jitter = RangingChip(Silicon(AMI_1500_IDEAL), noise=WHITE, bias_kind="gate").jitter_at(27.0)
    assert jitter is not None
    expected = np.sqrt(ELEMENTARY_CHARGE * jitter.t_inh / np.array(ranging_chip.I_INH_TAU))
    # the bias's gate voltage gives the nominal device its current by the same law
    np.testing.assert_allclose(jitter.white, expected, rtol=1e-3)
    assert jitter.white[12] == pytest.approx(10.5e-6, rel=0.01)
    times = durations(WHITE, 2000)
    # 2,000 calls know a deviation to 1.6 %, a mean to 2.2 % of it: four of these; neurons are independent
    np.testing.assert_allclose(times.std(axis=0), jitter.white, rtol=0.065)
    assert np.abs((times.mean(axis=0) - jitter.t_inh) / jitter.white).max() < 0.09
    others = np.corrcoef(times.T)[~np.eye(13, dtype=bool)]
    assert np.abs(others).max() < 0.1


def test_flicker_goes_on_from_call_to_call() -> None:
    noise = SiliconNoise(5, flicker=NoiseModel(1e-22, 0.0))
    jitter = RangingChip(Silicon(AMI_1500_IDEAL), noise=noise, bias_kind="gate").jitter_at(27.0)
    assert jitter is not None
    times = durations(noise, 400)
    assert (spread(jitter) > 5.0 * jitter.white).all()
    moved = times - times.mean(axis=0)
    neighbours = (moved[1:] * moved[:-1]).mean() / (moved**2).mean()
    # relaxations of less than 10 rad/s, half of the decades in play, keep their sign over 0.1 s
    assert 0.3 < neighbours < 0.9
    far_apart = durations(noise, 400, 100.0)
    apart = far_apart - far_apart.mean(axis=0)
    # 100 s outlast the slowest relaxation 60 times; 5,200 products scatter by 1.4 %
    assert abs((apart[1:] * apart[:-1]).mean() / (apart**2).mean()) < 0.06


def test_seed_trial_and_place_choose_the_noise() -> None:
    one = durations(WHITE, 3)
    np.testing.assert_array_equal(durations(WHITE, 3), one)
    for other in (replace(WHITE, seed=6), replace(WHITE, trial=1)):
        assert not np.isin(durations(other, 3), one).any()


def test_a_chip_without_noise_is_the_chip_it_was() -> None:
    quiet, noisy = (
        RangingChip(Silicon(AMI_1500_IDEAL), bias_kind="gate"),
        RangingChip(Silicon(AMI_1500_IDEAL), noise=WHITE, bias_kind="gate"),
    )
    assert quiet.jitter_at(27.0) is None
    assert quiet.begin().noise_state is None
    t_inh = np.ones(13)
    next_durations(no_jitter(), 1.0, t_inh)
    np.testing.assert_array_equal(t_inh, 1.0)
    events = [("call", 1e-3)]
    a, _, _ = quiet.advance(quiet.begin(), 2e-3, events)
    b, _, _ = noisy.advance(noisy.begin(), 2e-3, events)
    assert b.noise_state is not None
    assert a.noise_state is None
    moved = b.neurons.base[:, RELEASE] - a.neurons.base[:, RELEASE]
    assert 0.0 < np.abs(moved).max() < 100e-6


def test_a_state_goes_on_as_a_value_and_over_temperature() -> None:
    chip = RangingChip(Silicon(AMI_1500_IDEAL), noise=SiliconNoise(5), bias_kind="gate")
    begun, _, _ = chip.advance(chip.begin(), 2e-3, [("call", 1e-3)])
    again = [chip.advance(begun, 0.2, [("call", 0.15)])[0].neurons.base for _ in range(2)]
    np.testing.assert_array_equal(again[0], again[1])
    warm = {"temperature": (np.array([0.0]), np.array([40.0]))}
    warmer, _, _ = chip.advance(begun, 0.2, [("call", 0.15)], warm)
    assert warmer.noise_state is not None
    assert warmer.noise_state[2][0] == 2
    assert warmer.temperature_c == 40.0


def test_both_loops_have_the_same_noise() -> None:
    """A chip that sleeps between echoes, and one whose neurons are always integrated."""
    chip = RangingChip(Silicon(AMI_1500_IDEAL), noise=SiliconNoise(9), bias_kind="gate")
    neurons, jitter = chip.neurons_at(27.0), chip.jitter_at(27.0)
    own = neurons._replace(t_inh=neurons.t_inh.copy())
    plan = new_plan(neurons)
    asleep = new_chip(own, plan, jitter=jitter)
    pairs = [(0.1 * k + 1e-3, 0.1 * k + 1e-3 + 6.4e-3) for k in range(5)]
    slept: list[float] = []
    for called, heard in pairs:
        on_call(own, plan, asleep, called)
        on_echo(own, plan, asleep, heard, np.nan)
        while next_due(asleep)[0] < called + 0.09:
            time, k = next_due(asleep)
            if take(own, plan, asleep, k) and k == 2:
                slept.append(time)
    state, now, spikes = chip.begin(), 0.0, []
    events = [e for c, h in pairs for e in (("call", c), ("echo", h))]
    while now < 0.5:
        state, now, output = chip.advance(state, 0.5, events)
        events = []
        spikes += [t for port, t in output.events if port == "spike[2]"]
    assert len(slept) == len(spikes) == 5
    # a step's error over the slope of v_mem, as between the loops without noise; noise moves spikes by 5 us
    # from one call to the next
    np.testing.assert_allclose(slept, spikes, atol=20e-6)
    delays = np.array(spikes) - [c for c, _ in pairs]
    assert np.ptp(delays) > 2e-6


def test_wrong_numbers_are_refused() -> None:
    for wrong in ({"seed": -1}, {"trial": -2}):
        with pytest.raises(ParameterError, match="must be at least 0"):
            SiliconNoise(**wrong)


def test_lines_of_a_generator_make_noise_that_neurons_share():
    noise = SiliconNoise(5)
    gate, line = (
        RangingChip(Silicon(AMI_1500_IDEAL), noise=noise, bias_kind=k).jitter_at(27.0)
        for k in ("gate", "generator")
    )
    assert gate is not None
    assert line is not None
    assert gate.follow.shape == (13, 0)
    assert (spread(line) > 1.5 * spread(gate)).all()
    times = np.empty((2000, 13))
    for k, row in enumerate(times):
        next_durations(line, 0.1 * k, row)
    np.testing.assert_allclose(times.std(axis=0), spread(line), rtol=0.08)
    alike = np.corrcoef(times.T)[6, 8]  # of one coarse code
    shared = (line.follow_white[6] * line.follow_white[8]).sum()
    shared += (line.follow[6] * line.follow[8]).sum() * (line.share[6] * line.share[8]).sum()
    assert alike == pytest.approx(shared / (spread(line)[6] * spread(line)[8]), abs=0.08)
    assert alike > 0.1


def test_a_ripple_of_the_supply_moves_inhibitions_by_its_mean():
    ripple = Ripple(50e-3, 50.0)
    quiet, moved = (
        RangingChip(Silicon(AMI_1500_IDEAL), noise=SiliconNoise(5, ripple=r), bias_kind="generator")
        for r in (None, ripple)
    )
    still, swaying = quiet.jitter_at(27.0), moved.jitter_at(27.0)
    assert still is not None
    assert swaying is not None
    assert spread(swaying) == pytest.approx(spread(still))
    assert (most(swaying) > most(still)).all()
    a, b = np.empty(13), np.empty(13)
    silicon = Silicon(AMI_1500_IDEAL)
    circuit = quiet.model.circuit
    lines, current = lines_of(circuit, next(x for x in circuit.biases if x.name == "i_inh_tau"), silicon)
    supply = ripple.amplitude * line_response(lines, current, silicon, ripple.frequency)
    phase = swing_of(SiliconNoise(5, ripple=ripple)).phase
    per_volt = silicon.law("n").kappa / silicon.thermal_voltage
    for k in range(6):
        next_durations(still, 0.1 * k + 3e-3 * k, a)
        next_durations(swaying, 0.1 * k + 3e-3 * k, b)
        grid = 0.103 * k + np.linspace(0.0, 1.0, 4001)[:, None] * still.t_inh
        sine = np.abs(supply) * np.sin(2.0 * np.pi * 50.0 * grid + phase + np.angle(supply))
        asked = -still.t_inh * per_volt * sine.mean(axis=0)
        np.testing.assert_allclose(
            b - a, asked, atol=0.02 * np.abs(still.t_inh * per_volt * np.abs(supply)).max()
        )
    assert np.abs(b - a).max() > 2.0 * spread(still).min()


def test_a_ripple_on_fixed_gates_is_refused():
    noise = SiliconNoise(5, ripple=Ripple(50e-3, 50.0))
    chip = RangingChip(Silicon(AMI_1500_IDEAL), noise=noise, bias_kind="gate")
    with pytest.raises(ParameterError, match=r"i_inh_tau: ripple of 50 mV at 50 Hz on a bias of kind gate"):
        chip.jitter_at(27.0)
