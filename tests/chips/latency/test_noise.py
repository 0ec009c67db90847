"""Noise of the latency chip: times against the closed form and the transistors, and what draws them."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest

from chips.latency.chip import LatencyChip
from chips.latency.model import charges_on, lumped, usual_biases
from chips.latency.noise import CHARGES, SOURCE, TIMES, charge_spread, noise_of, numbers_of_ping
from chips.latency.place import TAP_WIRES, bench_at, line_volts, standing
from chips.noise import SiliconNoise
from chips.shot_noise import shot_share, steepness
from circuits.blocks.latency import tap as latency_tap
from circuits.blocks.latency.tap import delay_tap
from circuits.devices import Source
from circuits.devices.noise import WHITE_ONLY
from circuits.devices.source import PiecewiseLinear
from circuits.generator.ripple import Ripple
from circuits.lowering.kernel import to_kernel
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500, AMI_1500_IDEAL, ELEMENTARY_CHARGE
from circuits.silicon.silicon import Silicon
from circuits.solver.noise.event_jitter import event_jitter
from circuits.solver.transient import simulate
from tests.chips.latency.test_chip import CHIP, DESIGN, told

WHITE = SiliconNoise(1, flicker=WHITE_ONLY)
SILICON = Silicon(AMI_1500_IDEAL)


@pytest.fixture(scope="module")
def pings():
    noise = noise_of(CHIP.lumped, CHIP.biases, SILICON, WHITE)
    return [numbers_of_ping(CHIP.lumped, noise, 0.1 * k) for k in range(300)]


def share(current):
    """What moderate inversion leaves of the shot noise of a pFET of 6 x 24 um."""
    return shot_share(current, SILICON.law("p").square_current * SOURCE.square)


def test_times_vary_by_the_root_of_charge_over_current(pings):
    """`sigma = sqrt(phi q T / I)`, I = Q / T."""
    charge = charges_on(SILICON)
    for name, kind in TIMES.items():
        length = np.asarray(getattr(CHIP.lumped, name))
        drawn = np.array([getattr(p, name) for p in pings]) / length - 1.0
        # 300 pings of one to some thousand places: 4 % of one's deviation
        expected = np.sqrt(ELEMENTARY_CHARGE / charge[kind] * share(charge[kind] / length).mean())
        assert np.sqrt((drawn**2).mean()) == pytest.approx(expected, rel=0.13 if drawn[0].size == 1 else 0.1)
        assert abs(drawn.mean()) < 4.0 * expected / np.sqrt(drawn.size)


def test_membranes_vary_by_the_root_of_their_charge(pings):
    given = {"integrating": CHIP.lumped.synapse.mean(axis=1), "race": CHIP.lumped.passive,
             "second_charge": CHIP.lumped.second}  # fmt: skip
    for name in CHARGES:
        taken = getattr(CHIP.lumped, name)
        drawn = np.array([getattr(p, name) for p in pings]) - taken
        expected = np.sqrt(ELEMENTARY_CHARGE * (taken * share(given[name])).mean())
        assert np.sqrt((drawn**2).mean()) == pytest.approx(expected, rel=0.03)
    # what noise has no share in
    assert all(p.seen is CHIP.lumped.seen and p.sum == CHIP.lumped.sum for p in pings)


def test_a_cell_alone_races_with_shot_noise():
    """A passive current that takes up Q: `sigma(T) = sqrt(phi q Q) / I`, seen at the chip's first layer."""
    chip = LatencyChip(DESIGN, silicon=Silicon(AMI_1500_IDEAL), noise=WHITE)
    quiet = (np.zeros(1), np.array([chip.addresses.onset]))
    # early enough that no memory speaks; a microsecond later is another draw
    starts = 0.1 + 1e-6 * np.arange(200)
    free = np.array([chip.ping(chip.new_memory(), start, *quiet).free for start in starts])
    n = chip.lumped
    expected = np.sqrt(ELEMENTARY_CHARGE * n.race * share(n.passive)) / n.passive
    # 33 cells of 200 pings
    assert free.std(axis=0).mean() == pytest.approx(expected.mean(), rel=0.03)


@pytest.mark.parametrize("process", [AMI_1500_IDEAL, AMI_1500])
def test_a_tap_jitters_as_the_transistors(process):
    """Linear theory of the whole tap, within 5 %: its comparator and mirrors make that much."""
    circuit, silicon = latency_tap.build(latency_tap.Params(taps=1)), Silicon(process)
    machine = to_kernel(latency_tap.testbench(circuit, {"duration": 3.3e-3}, AMI_1500_IDEAL.v_dd), silicon)
    for noise in (WHITE, SiliconNoise(1)):
        jitter = event_jitter(machine, "out[0]", noise.flicker)
        delay = np.array([jitter.time - latency_tap.START])
        charge = charges_on(silicon)["tap"]
        # under the full law the current is 1.5 % above that of a drain at its gate
        assert delay == pytest.approx(charge / 3.34e-9, rel=0.01 if process is AMI_1500_IDEAL else 0.02)
        spread = charge_spread(silicon, noise, charge / delay, delay)
        assert delay * spread / jitter.deviation == pytest.approx(1.0, abs=0.05)


def test_flicker_follows_the_devices_area():
    white, both = (
        noise_of(CHIP.lumped, CHIP.biases, SILICON, n).spread["tap"] for n in (WHITE, SiliconNoise(1))
    )
    more = noise_of(CHIP.lumped, CHIP.biases, SILICON, SiliconNoise(1), area=4.0).spread["tap"]
    added = both**2 - white**2
    assert more**2 - white**2 == pytest.approx(added / 4.0, rel=1e-6)
    # K_F of a pFET of 6 x 24 um, and a band of some e-folds from 0.1 Hz to a few times 1 / 3 ms
    per_fold = 2e-25 / (SOURCE.gate_area * AMI_1500_IDEAL.p.oxide_capacitance)
    current = charges_on(SILICON)["tap"] / CHIP.lumped.tap
    psi = steepness(current, SILICON.law("p").square_current * SOURCE.square)
    folds = added / (per_fold * (psi * SILICON.law("p").kappa / SILICON.thermal_voltage) ** 2)
    assert 5.0 < folds.min() <= folds.max() < 12.0


def test_draws_are_of_seed_die_and_ping_alone():
    def run(seed, number=3):
        noise = None if seed is None else SiliconNoise(seed)
        return told(LatencyChip(DESIGN, silicon=Silicon(AMI_1500_IDEAL, die=Die(number=number)), noise=noise))

    def same(a, b):
        return all(np.array_equal(x.free, y.free) and np.array_equal(x.memory, y.memory)
                   for x, y in zip(a, b, strict=True))  # fmt: skip

    noisy, quiet = run(1), run(None)
    with ThreadPoolExecutor(2) as threads:
        again, other = threads.map(run, (1, 2))
    assert same(again, noisy)
    assert not same(other, noisy)
    assert not same(quiet, noisy)
    # a thousandth of any time
    assert noisy[0].free == pytest.approx(quiet[0].free, rel=5e-3)
    # other pings of the same numbers are other draws
    assert (noisy[1].free != noisy[2].free).any()
    assert np.array_equal(quiet[1].free, quiet[2].free)


def test_a_chip_without_noise_has_its_own_numbers():
    assert LatencyChip(DESIGN, silicon=Silicon(AMI_1500_IDEAL))._numbers(0.3) is not None
    chip = LatencyChip(DESIGN, silicon=Silicon(AMI_1500_IDEAL))
    assert chip._numbers(0.3) is chip.lumped
    assert LatencyChip(DESIGN, silicon=Silicon(AMI_1500_IDEAL), noise=WHITE).at(40.0).noise is WHITE


def test_a_line_s_ripple_moves_a_tap_as_the_transistors():
    """A tap behind a line that swings by what the generator makes of 60 mV at 150 Hz."""
    biases, silicon, k = usual_biases(DESIGN, "generator", AMI_1500), Silicon(AMI_1500), 3
    noise = SiliconNoise(2, flicker=WHITE_ONLY, ripple=Ripple(60e-3, 150.0))
    numbers = lumped(DESIGN, biases, silicon)
    found = noise_of(numbers, biases, silicon, noise)
    reach, swing = found.reach["tap"], found.lines.swing
    supply = found.lines.wander.supply[reach.line[k]]
    volts = line_volts(biases, silicon, TAP_WIRES, {"tap": k})
    stop, at = 3e-3 + 2.0 * float(numbers.tap[k]), 3e-3

    def delay(swings):
        bench = bench_at("tap", delay_tap(5e-12), volts, {"event": [at]}, stop, AMI_1500.v_dd, ("out",))
        times = np.linspace(0.0, stop, 2001)
        line = volts["v_tap"] - swings * np.abs(supply) * np.sin(
            swing.pace * times + swing.phase + np.angle(supply)
        )
        moving = Source("v_tap", "v_tap", PiecewiseLinear(tuple(times), tuple(line)))
        sources = tuple(moving if s.name == "v_tap" else s for s in bench.sources)
        made = to_kernel(replace(bench, sources=sources), standing(silicon, ("tap", (k,))))
        return float(simulate(made, rtol=1e-5, record=()).spikes["out"][0]) - at

    asked = found.lines.changes(reach, np.zeros((2, found.lines.wander.white.size)), at)[k]
    assert abs(asked) > 0.005
    assert np.log(delay(1.0) / delay(0.0)) == pytest.approx(asked, rel=0.06)


def test_lines_of_a_generator_move_what_they_bias():
    biases, silicon = usual_biases(DESIGN, "generator", AMI_1500), Silicon(AMI_1500)
    numbers = lumped(DESIGN, biases, silicon)
    noise = noise_of(numbers, biases, silicon, SiliconNoise(3))
    pings = [numbers_of_ping(numbers, noise, 0.1 * k) for k in range(400)]
    for name in ("hold", "tap", "race"):
        found = np.log(np.array([getattr(p, name) for p in pings]) / getattr(numbers, name))
        lines, own = noise.lines.spread(noise.reach[name]), noise.spread[name]
        assert (lines > 3.0 * own).all()
        assert found.std(axis=0).mean() == pytest.approx(np.hypot(lines, own).mean(), rel=0.12)
    # all holds have one line, each tap its own
    hold = np.log(np.array([p.hold for p in pings]) / numbers.hold)[:, :3, 0]
    assert np.corrcoef(hold.T).min() > 0.9
    gate = usual_biases(DESIGN, "gate", AMI_1500)
    still = noise_of(numbers, gate, silicon, SiliconNoise(3))
    assert not still.lines.spread(still.reach["hold"]).any()
