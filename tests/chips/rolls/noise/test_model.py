"""Noise of the ROLLS chip: against closed forms and transistors, and what draws it."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest

from chips.lines.steps import no_lines
from chips.noise import SiliconNoise
from chips.noise_draw import new_draws, new_slow
from chips.rolls.calibration import code_for
from chips.rolls.chip import RollsChip
from chips.rolls.layout import SINCE, STATIC, WAIT, ZETA, Z
from chips.rolls.lumped.filter import OMEGA_POINTS
from chips.rolls.noise.kernel import disturb_plastic
from chips.rolls.noise.layout import DRAWN, INPUT, LINE_DIRECT, RISE, WHITE, NoiseTables
from chips.rolls.plastic.reference import prepared
from chips.rolls.program.address import NEURONS
from chips.rolls.program.bias_file import default_biases
from chips.rolls.program.program import Program
from circuits.bias import rebias
from circuits.blocks.rolls import neuron as rolls_neuron
from circuits.devices.noise import WHITE_ONLY
from circuits.errors import ParameterError
from circuits.generator.ripple import Ripple
from circuits.lowering.kernel import to_kernel
from circuits.silicon.die import Die
from circuits.silicon.process import ELEMENTARY_CHARGE, ROLLS_180_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.noise.transient import NoiseRun, simulate_noisy

SILENT = np.zeros((NEURONS, NEURONS), dtype=np.int8)
DRIVE = 250e-12  # A, about 113 Hz
WHITE_NOISE = SiliconNoise(3, flicker=WHITE_ONLY)


def chip_of(noise, die=None, step=0.4e-3, drive=DRIVE):
    biases = default_biases().with_code("IF_DC_P", *code_for(drive))
    return RollsChip(
        Program(SILENT, biases), Silicon(ROLLS_180_IDEAL, die=Die(number=die)), "gate", step=step, noise=noise
    )


def trains(chip, *durations):
    state, times, neurons = chip.at_rest(), [], []
    for duration in durations:
        spikes, state = chip.run(state, duration)
        times.append(spikes.times)
        neurons.append(spikes.neurons)
    return np.concatenate(times), np.concatenate(neurons)


def same(a, b):
    return all(x.size == y.size and bool((x == y).all()) for x, y in zip(a, b, strict=True))


@pytest.fixture(scope="module")
def white():
    return chip_of(WHITE_NOISE)


def test_a_chip_without_noise_is_one_whose_noise_is_nothing(white):
    quiet = chip_of(None)
    assert quiet.built().noise is None
    built = white.built()
    nothing = built.noise._replace(rows=0.0 * built.noise.rows, grain=0.0 * built.noise.grain)
    silent = chip_of(WHITE_NOISE)
    silent._built[27.0] = replace(built, noise=nothing)
    found = trains(quiet, 0.2)
    assert same(trains(silent, 0.2), found)
    assert not same(trains(white, 0.2), found)


def test_draws_are_of_seed_die_and_step_alone():
    chip = chip_of(SiliconNoise(1))
    found = trains(chip, 0.2)
    assert same(trains(chip, 0.2), found)
    # 40.4 ms is no whole number of the flicker's looks; a time is summed otherwise, in its last bits
    cut = trains(chip, 0.0404, 0.0596, 0.1)
    assert (cut[1] == found[1]).all()
    assert cut[0] == pytest.approx(found[0], abs=1e-14)
    with ThreadPoolExecutor(2) as threads:
        others = [chip_of(SiliconNoise(s)) for s in (1, 2)]
        again, other = threads.map(lambda c: trains(c, 0.2), others)
    assert same(again, found)
    assert not same(other, found)
    assert not same(trains(chip_of(SiliconNoise(1, trial=1)), 0.2), found)
    assert not same(trains(chip_of(SiliconNoise(1, flicker=WHITE_ONLY)), 0.2), found)


def test_a_chip_in_a_trial_is_the_chip_that_is_built_with_it():
    chip = chip_of(SiliconNoise(1), die=4)
    found = trains(chip, 0.2)
    third = chip.in_trial(3)
    assert third.noise == SiliconNoise(1, trial=3)
    assert same(trains(third, 0.2), trains(chip_of(SiliconNoise(1, trial=3), die=4), 0.2))
    assert not same(trains(third, 0.2), found)
    assert same(trains(third.in_trial(0), 0.2), found)
    assert third.built().tables is chip.built().tables
    quiet = chip_of(None)
    assert quiet.in_trial(3) is quiet
    with pytest.raises(ParameterError, match=r"noise\.trial: -1, must be at least 0"):
        chip.in_trial(-1)


def test_intervals_vary_as_the_closed_form():
    """`var T = int D / f^3 dzeta` of a neuron that f drives, by quadrature on its own tables."""
    chip = chip_of(WHITE_NOISE, step=0.1e-3)
    built = chip.built()
    m, rows = built.tables.membranes, built.noise.rows[0].astype(np.float64)
    edge = np.exp2(np.arange(rows.shape[0] + 1) // 16) * (1.0 + np.arange(rows.shape[0] + 1) % 16 / 16)
    zeta = np.geomspace(1.0, m.top[0], 20001)
    middle, width = 0.5 * (zeta[1:] + zeta[:-1]), np.diff(zeta)
    line = m.lines[0, np.searchsorted(edge, middle, side="right") - 1].astype(np.float64)
    rate = (line[:, STATIC] + line[:, STATIC + 1] * middle) * m.inverse[0]
    density = np.interp(middle, 0.5 * (edge[1:] + edge[:-1]), rows[:, WHITE])
    expected = np.sqrt((density / rate**3 * width).sum())
    times, neurons = trains(chip, 0.5)
    gaps = np.concatenate([np.diff(times[neurons == k]) for k in range(NEURONS)])
    # 0.7 % seen; 14,000 intervals know it to 0.6 %, and steps of 0.1 ms add 1 us of their own in squares
    assert gaps.std() == pytest.approx(expected, rel=0.03)
    assert (rows[:, RISE] > 0.0).all()


def test_jitter_is_the_transistors(white):
    circuit = rebias(rolls_neuron.build(), {"i_dc": DRIVE})
    given = rolls_neuron.BLOCK.defaults | {"current": 0.0, "duration": 0.8}
    machine = to_kernel(
        rolls_neuron.testbench(circuit, given, ROLLS_180_IDEAL.v_dd), Silicon(ROLLS_180_IDEAL)
    )
    result = simulate_noisy(machine, NoiseRun(1, 40e-6, WHITE_ONLY), record=("v_mem",))
    theirs = np.diff(result.spikes["spike"])[1:]
    times, neurons = trains(chip_of(WHITE_NOISE, step=0.1e-3), 0.3)
    ours = np.concatenate([np.diff(times[neurons == k]) for k in range(NEURONS)])
    assert ours.mean() == pytest.approx(theirs.mean(), rel=0.01)
    # 88 intervals know their deviation to 7.5 %: three of those
    assert ours.std() == pytest.approx(theirs.std(ddof=1), rel=0.23)


def test_a_filters_noise_is_that_of_its_charges(white):
    """One step of filters that leak far from rest: `q / (C U_T / kappa) (1 + v)^2 dt / tau` in z."""
    state = white.at_rest()
    f, shape = white.built().filters[0], white.built().shapes[0]
    log = 3.0
    state.values[Z] = shape.brought_at(np.full(NEURONS, log))
    state.values[SINCE] = 1.0
    quiet = chip_of(None)
    after = [c.run(state, 0.4e-3)[1].values[Z] for c in (quiet, white)]
    v = np.interp(log, np.arange(-40.0, 16.0, 1.0 / 128), shape.ratio)
    expected = ELEMENTARY_CHARGE / f.unit[0] * (1.0 + v) ** 2 * 0.4e-3 / f.tau[0]
    moved = after[1] - after[0]
    # a step of 0.75 time constants takes v and what noise moved it by to e^-0.75 and less; 256 draws: 9 %
    slope = np.exp(-0.4e-3 / f.tau[0])
    low, high = expected * slope**2, expected
    assert 0.75 * low < moved.var() < 1.25 * high
    assert not (state.values[WAIT] > 0.0).any()
    assert np.isfinite(state.values[ZETA]).all()


def test_the_plastic_filters_noise_is_that_of_leak_and_pulses():
    """`grain [(1 + v)^2 dt / tau + q (1 + v + excess)]` a step, of the slow filter and of the calcium."""
    plastic, _ = prepared(Silicon(ROLLS_180_IDEAL), "gate", 0.4e-3)
    n, steps = plastic.tables.up.shape[0], 500
    grain = np.array([[1e-4], [2e-4]], np.float32) * np.ones((2, n), np.float32)
    excess = np.array([[0.5], [3.0]], np.float32) * np.ones((2, n), np.float32)
    none = np.zeros((4, n), np.float32)
    tables = NoiseTables(
        np.zeros((n, 1, 9), np.float32), none, none, new_draws(1, 0, "array", n),
        new_slow(np.zeros(6), WHITE_ONLY, 0.4e-3, n), grain, excess, no_lines(),
    )  # fmt: skip
    at, charge = np.array([5.0, 2.0]), np.array([3.0, 1.5])
    found = np.zeros((steps, 2, n))
    for k in range(steps):
        plastic.arrays.filters[Z : Z + 2] = at[:, None]
        plastic.scratch.filters.charge[:2] = charge[:, None]
        disturb_plastic(tables, plastic, k)
        found[k] = plastic.arrays.filters[Z : Z + 2] - at[:, None]
    for k, bank in enumerate(plastic.tables.banks):
        more = 1.0 + np.interp(at[k], OMEGA_POINTS, plastic.tables.omega[k, :, 0])
        expected = grain[k, 0] * (more**2 * bank.fall[0] + charge[k] * (more + excess[k, 0]))
        # 4,000 draws know a variance to 2.2 %: three of those; the table is taken at its lower point
        assert found[:, k].var() == pytest.approx(expected, rel=0.07)
        assert found[:, k].mean() == pytest.approx(0.0, abs=3.0 * np.sqrt(expected / found[:, k].size))
    assert not np.array_equal(found[:, 0], found[:, 1])


def test_flickers_deviation_follows_area_and_band():
    chip = chip_of(SiliconNoise(1))
    found = chip.built().noise.slow.deviation
    # ml4 of 1 x 9 um at K_F = 2e-24 V^2 F; its weak inversion is nearly whole
    k = 2e-24 / (9e-12 * 8.4e-3) * (0.75 / chip.silicon.thermal_voltage) ** 2
    assert found[0] == pytest.approx(np.sqrt(np.log(2.0) * k), rel=0.05)
    # octaves from 3.2 ms to 6.5 s
    assert found.shape == (6, 12)
    assert chip_of(WHITE_NOISE).built().noise.slow.deviation.shape == (6, 0)


def test_lines_of_the_generator_move_all_neurons():
    """A line of the direct current that stands a tenth higher drives as a current a tenth higher does."""
    low, high = (default_biases().with_code("IF_DC_P", 4, code) for code in (100, 110))
    ripple = SiliconNoise(3, flicker=WHITE_ONLY, ripple=Ripple(20e-3, 50.0))
    silicon = Silicon(ROLLS_180_IDEAL, die=Die(number=5))

    def made(biases, noise):
        return RollsChip(Program(SILENT, biases), silicon, "generator", step=0.4e-3, noise=noise)

    chip = made(low, ripple)
    built = chip.built()
    lines = built.noise.lines
    assert lines.shift.size == 6
    assert (lines.ripple[:2] > 1e-5).all()
    assert (np.abs(lines.white).sum(axis=1) > 0.0).all()
    moved = np.zeros(6)
    moved[LINE_DIRECT] = 0.1
    held = lines._replace(
        white=0.0 * lines.white, pace=1e-9, phase=0.0, lag=np.full(6, 0.5 * np.pi), ripple=moved
    )
    nothing = built.noise._replace(rows=built.noise.rows.copy(), grain=0.0 * built.noise.grain, lines=held)
    for column in (WHITE, INPUT, DRAWN):
        nothing.rows[:, :, column] = 0.0
    chip._built[27.0] = replace(built, noise=nothing)
    ours, theirs, still = (trains(c, 0.5)[1].size for c in (chip, made(high, None), made(low, None)))
    assert ours == pytest.approx(theirs, rel=0.01)
    assert theirs > 1.03 * still


def test_a_ripple_on_fixed_gates_is_refused():
    with pytest.raises(
        ParameterError, match=r"rolls_chip\.i_tau2: ripple of 20 mV at 50 Hz on a bias of kind gate"
    ):
        chip_of(SiliconNoise(3, ripple=Ripple(20e-3, 50.0))).built()
