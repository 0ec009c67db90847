"""Jitter of the axons: its size, whose it is, and that plans without it are what they were."""

from dataclasses import replace

import numpy as np
import pytest

from chips.lines.wander import swing_of, wander_of
from chips.noise import SiliconNoise
from chips.shot_noise import shot_share
from chips.wavefront.chip import ChipCells, WavefrontChip
from chips.wavefront.model import axon_delays, chip_model
from chips.wavefront.noise import axon_jitter, axon_spread, in_line_time, sinks_on
from circuits.arrays import F64
from circuits.bias import bias_voltages, rebias
from circuits.blocks.wavefront import axon_delay
from circuits.blocks.wavefront.grid import START_TIME, Params, build, firing_times, plan_testbench
from circuits.devices import Source
from circuits.devices.noise import WHITE_ONLY
from circuits.devices.source import PiecewiseLinear
from circuits.errors import ParameterError
from circuits.generator.ripple import Ripple
from circuits.lowering.kernel import to_kernel
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500, AMI_1500_IDEAL, ELEMENTARY_CHARGE, Process
from circuits.silicon.silicon import Silicon
from circuits.solver.noise.event_jitter import event_jitter
from circuits.solver.transient import simulate

WHITE = SiliconNoise(3, flicker=WHITE_ONLY)
MAP = np.random.default_rng(11).integers(1, 11, (6, 6))


def test_white_jitter_is_the_sinks_shot_noise() -> None:
    model, silicon = chip_model((1, 3)), Silicon(AMI_1500_IDEAL)
    delays = axon_delays(model, silicon, np.array([[1, 9, 0]])).ravel()
    found = axon_spread(model, silicon, delays, WHITE)
    current, specific, _ = sinks_on(model, silicon)
    # 3.0046 nA of the bias, 27 degC
    np.testing.assert_allclose(current, 3.0046e-9, rtol=1e-3)
    phi = shot_share(current, specific)[:2]
    np.testing.assert_allclose(
        found[:2], np.sqrt(phi * ELEMENTARY_CHARGE * delays[:2] / 3.0046e-9), rtol=1e-3
    )
    assert found[2] == 0.0
    both = axon_spread(model, silicon, delays, SiliconNoise(3))
    assert (both[:2] > found[:2]).all()
    # the sink's flicker, 5 uV/sqrt(Hz) at 1 Hz, moves a delay by its own share: longer ones by more
    extra = np.sqrt(both[:2] ** 2 - found[:2] ** 2)
    assert 6.0 < extra[1] / extra[0] < 9.5


@pytest.mark.parametrize("process", [AMI_1500_IDEAL, AMI_1500], ids=lambda p: p.effects)
@pytest.mark.parametrize("code", [1, 9])
def test_jitter_is_that_of_the_axon_s_circuit(code: int, process: Process) -> None:
    model, silicon = chip_model((1, 2), process), Silicon(process)
    delays = axon_delays(model, silicon, np.array([[code, 0]])).ravel()
    white, both = (axon_spread(model, silicon, delays, n) for n in (WHITE, SiliconNoise(3)))
    stimuli = {"code": float(code), "duration": None}
    bench = axon_delay.BLOCK.testbench(axon_delay.build(), stimuli, silicon.process.v_dd)
    found = event_jitter(to_kernel(bench, silicon), "delayed", rest=20e-6)
    # the comparator, which the model leaves out, has 1.5 % of the variance
    assert white[0] == pytest.approx(np.sqrt(found.white.sum()), rel=0.02)
    # its slope is the current's own; the sink's drain adds 3 %
    assert np.sqrt(both[0] ** 2 - white[0] ** 2) == pytest.approx(np.sqrt(found.flicker.sum()), rel=0.05)
    assert white[1] == 0.0


def test_draws_have_the_spread_and_follow_seed_and_plan() -> None:
    model, silicon = chip_model((50, 50)), Silicon(AMI_1500_IDEAL)
    delays = np.full(2500, 100e-6)
    drawn = axon_jitter(model, silicon, delays, WHITE, 0)
    spread = axon_spread(model, silicon, delays, WHITE)
    # 2,500 axons know a deviation to 1.4 %, a mean to 2 %: four of these
    assert (drawn / spread).std() == pytest.approx(1.0, abs=0.06)
    assert abs((drawn / spread).mean()) < 0.08
    np.testing.assert_array_equal(axon_jitter(model, silicon, delays, WHITE, 0), drawn)
    for other, number in (
        (WHITE, 1),
        (SiliconNoise(4, flicker=WHITE_ONLY), 0),
        (SiliconNoise(3, 1, WHITE_ONLY), 0),
    ):
        assert not np.isin(axon_jitter(model, silicon, delays, other, number), drawn).any()
    with pytest.raises(ParameterError, match=r"plan\.number"):
        axon_jitter(model, silicon, delays, WHITE, -1)


def test_a_die_has_currents_of_its_own() -> None:
    model = chip_model((4, 4))
    nominal, die = (
        sinks_on(model, s).current
        for s in (Silicon(AMI_1500_IDEAL), Silicon(AMI_1500_IDEAL, die=Die(number=1003)))
    )
    np.testing.assert_allclose(nominal, nominal[0])
    assert np.unique(die).size == 16


def test_plans_differ_only_with_noise() -> None:
    silicon = Silicon(AMI_1500_IDEAL, die=Die(number=1000, process=False))
    quiet, noisy = (WavefrontChip(6, 6, cells=ChipCells(silicon, noise=n)) for n in (None, SiliconNoise(1)))
    program = quiet.program(MAP)
    plain = quiet.plan(program, (0, 0)).arrivals
    assert (quiet.plan(program, (0, 0), number=1).arrivals == plain).all()
    first, again, other = (noisy.plan(program, (0, 0), number=k).arrivals for k in (0, 0, 1))
    assert (first == again).all()
    later = np.abs(first - other).ravel()[1:]
    assert (later > 0.0).all()
    # microseconds over plans of milliseconds
    assert np.abs(first - plain).max() < 50e-6


def test_a_line_that_swings_moves_a_wave_as_the_transistors() -> None:
    """A row of cells whose line swings by what the generator makes of 20 mV at 2 kHz."""
    silicon, codes, ripple = Silicon(AMI_1500), np.array([[3, 2, 4, 1]]), Ripple(20e-3, 2e3)
    noise = SiliconNoise(5, flicker=WHITE_ONLY, ripple=ripple)
    chip = WavefrontChip(1, 4, cells=ChipCells(silicon))
    still = chip.plan(chip.program(codes), (0, 0)).arrivals
    model = chip_model((1, 4), AMI_1500, bias_kind="generator")
    moved = in_line_time(model, silicon, still, noise, (0, 0.0))
    plain = in_line_time(model, silicon, still, replace(noise, ripple=None), (0, 0.0))
    grid = rebias(build(Params(1, 4)), kind="generator")
    line = grid.bias("i_delay")
    volts = float(bias_voltages(grid, line, silicon)[()])
    held = replace(grid, biases=tuple(b for b in grid.biases if b.name != "i_delay"))
    bench = plan_testbench(held, codes, (0, 0), START_TIME + 1.3 * float(moved.max()), AMI_1500.v_dd)
    times = np.linspace(0.0, bench.stop, 4001)
    supply, swing = wander_of(model.circuit, ["i_delay"], silicon, noise).supply[0], swing_of(noise)

    def fired(share: float) -> F64:
        angle = swing.pace * (times - START_TIME) + swing.phase + np.angle(supply)
        wave = volts + share * np.abs(supply) * np.sin(angle)
        source = Source(line.port, line.port, PiecewiseLinear(tuple(times), tuple(wave)))
        made = replace(bench, sources=(*bench.sources, source))
        found = firing_times(simulate(made, silicon, rtol=1e-5, record=()))[0]
        return np.asarray(found - found[0])[1:]

    theirs, ours = fired(1.0) / fired(0.0), moved[0, 1:] / plain[0, 1:]
    assert ours == pytest.approx(theirs, abs=0.1 * np.abs(theirs - 1.0).max())
    assert np.abs(theirs - 1.0).max() > 0.003


def test_all_axons_have_one_line_and_a_wave_keeps_its_order() -> None:
    silicon = Silicon(AMI_1500, die=Die(number=4))
    chips = [
        WavefrontChip(6, 6, cells=ChipCells(silicon, noise=n))
        for n in (None, SiliconNoise(3, flicker=WHITE_ONLY))
    ]
    quiet, first, second = (
        chips[k].plan(chips[k].program(MAP), (0, 0), number=n) for k, n in ((0, 0), (1, 1), (1, 2))
    )
    ratio = first.arrivals.ravel()[1:] / quiet.arrivals.ravel()[1:]
    # 0.1 % that all have in common, beside each axon's jitter
    assert 2e-5 < abs(ratio.mean() - 1.0) < 1e-2
    assert not np.array_equal(first.arrivals, second.arrivals)
    gates = WavefrontChip(
        6, 6, cells=ChipCells(silicon, "gate", noise=SiliconNoise(3, ripple=Ripple(0.1, 50.0)))
    )
    with pytest.raises(ParameterError, match=r"i_delay: ripple of 100 mV at 50 Hz on a bias of kind gate"):
        gates.plan(gates.program(MAP), (0, 0))
