"""The envelope detector follows the amplitude of a tone, squares noise away, and is soon back at rest."""

import numpy as np
import pytest

from circuits.blocks.sonar.envelope_detector import (
    BLOCK,
    CARRIER,
    SAMPLE_RATE,
    SOUND_TIME,
    Params,
    build,
    tone_bursts,
)
from circuits.devices import Source
from circuits.devices.source import Constant, Sampled
from circuits.errors import ParameterError
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.transient import Result, simulate
from circuits.testbench import Testbench
from tests.circuits.blocks.values import TEMPERATURES, number

PEDESTAL = 0.15  # V
DEFAULTS = BLOCK.defaults


def run(temperature: float = 27.0, **stimuli: float | None) -> Result:
    return simulate(BLOCK.testbench(build(), DEFAULTS | stimuli, 5.0), Silicon(AMI_1500_IDEAL, temperature))


@pytest.mark.parametrize("temperature", TEMPERATURES)
def test_silence_is_the_pedestal(temperature: float) -> None:
    result = run(temperature, amplitude=0.0)
    found = BLOCK.measures(result)
    # the amplifier's gain of 1e4 leaves its input 0.45 mV apart, 1.2 mV at the output
    assert found["pedestal_V"] == pytest.approx(PEDESTAL, abs=2e-3)
    assert np.ptp(result["envelope"]) < 1e-5
    assert found["latency_s"] is None
    assert found["fall_time_s"] is None
    assert BLOCK.outcome(result) == "silence"


@pytest.mark.parametrize("temperature", TEMPERATURES)
def test_loud_sounds_lie_on_a_straight_line(temperature: float) -> None:
    amplitude = np.array([0.3, 0.6, 1.0, 1.5, 2.0, 2.4])
    peak = np.array(
        [BLOCK.measures(run(temperature, amplitude=float(a)))["envelope_peak_V"] for a in amplitude]
    )
    slope, offset = np.polyfit(amplitude, peak, 1)
    # kappa times the amplifier's 1.6 is 1.12; C_e loses some of it between the peaks
    assert slope == pytest.approx(1.03, rel=0.03)
    assert offset == pytest.approx(-0.10, abs=0.03)  # sounds below 0.1 V lie above the line, on a parabola
    assert np.abs(peak - (slope * amplitude + offset)).max() < 0.01 * peak[-1]


def test_weak_sounds_are_squared() -> None:
    means = []
    for amplitude in (5e-3, 10e-3, 20e-3):
        result = run(amplitude=amplitude)
        grid = SOUND_TIME + np.arange(0.5e-3, 0.75e-3, 1e-6)  # ten cycles, steady
        means.append(np.interp(grid, result.time, result["envelope"]).mean() - result["envelope"][0])
    # the next term of ln I_0(x) is -x^2 / 16 of the first: 2 % at 20 mV
    assert means[1] == pytest.approx(4.0 * means[0], rel=0.03)
    assert means[2] == pytest.approx(4.0 * means[1], rel=0.05)


@pytest.mark.parametrize("temperature", TEMPERATURES)
def test_the_weakest_echo_stands_out(temperature: float) -> None:
    assert number(BLOCK.measures(run(temperature, amplitude=0.05))["envelope_peak_V"]) > 0.011


@pytest.mark.parametrize("temperature", TEMPERATURES)
def test_a_call_has_gone_before_the_next_echo(temperature: float) -> None:
    result = run(temperature, amplitude=12.0)  # clipped at the rails
    later = result.time >= SOUND_TIME + 2e-3 - 1e-9
    assert later.any()
    assert np.abs(result["envelope"][later] - result["envelope"][0]).max() < 1e-3
    assert 2.4 < result["envelope"].max() < 3.2


def test_the_ripple_of_a_call_is_small() -> None:
    result = run()
    steady = (result.time > SOUND_TIME + 0.5e-3) & (result.time < SOUND_TIME + 0.7e-3)
    peak = number(BLOCK.measures(result)["envelope_peak_V"])
    assert np.ptp(result["envelope"][steady]) < 0.01 * peak


def test_a_second_burst_is_seen_as_the_first() -> None:
    result = run(amplitude=0.3, second_amplitude=0.3, delay=2e-3)
    grid = np.arange(0.0, 1.5e-3, 1e-6)
    first, second = (np.interp(start + grid, result.time, result["envelope"]) for start in (5e-4, 2.5e-3))
    assert np.abs(first - second).max() < 1e-3  # the carrier has the same phase; what is left is the tail


@pytest.mark.parametrize(("amplitude", "limit"), [(0.0, 25.5), (0.05, 26.0), (2.4, 42.0)])
def test_a_cycle_takes_few_steps(amplitude: float, limit: float) -> None:
    bench = BLOCK.testbench(build(), DEFAULTS | {"amplitude": amplitude}, 5.0)
    result = simulate(bench, rtol=1e-4)
    inside = (result.time > SOUND_TIME) & (result.time <= SOUND_TIME + 1e-3)
    assert np.count_nonzero(inside) / (1e-3 * CARRIER) < limit


def test_noise_hardly_moves_the_envelope() -> None:
    stop, rms = 20e-3, 5e-3  # s, V
    time = np.arange(int(stop * SAMPLE_RATE)) / SAMPLE_RATE
    baseband = np.random.Generator(np.random.Philox(key=8)).standard_normal((2, int(stop * 8e3) + 2))
    x, y = (np.interp(time * 8e3, np.arange(part.size), part) for part in baseband)
    angle = 2.0 * np.pi * CARRIER * time
    noise = rms * (x * np.cos(angle) - y * np.sin(angle))
    noise[0] = 0.0  # the run starts from the rest of silence
    sources = (
        Source("vdd", "vdd", Constant(5.0)),
        Source("microphone", "microphone", Sampled(0.0, SAMPLE_RATE, 2.5 + noise)),
    )
    envelope = simulate(Testbench("noise", build(), sources, stop))["envelope"]
    assert 0.0 < envelope.std() < 0.6e-3  # V; a 50 mV echo makes 13 mV


def test_a_slower_leak_falls_later() -> None:
    slow = build(Params(leak_resistance=500e3))
    fall = number(BLOCK.measures(simulate(BLOCK.testbench(slow, DEFAULTS, 5.0)))["fall_time_s"])
    assert fall > 1.3 * number(BLOCK.measures(run())["fall_time_s"])


def test_bursts_are_cut_off_at_the_rails_and_have_edges() -> None:
    wave = tone_bursts(((1e-3, 1e-3, 4.0),), 3e-3, 2.5, 5.0).value
    assert wave.min() == 0.0
    assert wave.max() == 5.0
    assert (wave[:1001] == 2.5).all()
    with pytest.raises(ParameterError, match="duration"):
        BLOCK.testbench(build(), DEFAULTS | {"duration": 0.3e-3}, 5.0)
