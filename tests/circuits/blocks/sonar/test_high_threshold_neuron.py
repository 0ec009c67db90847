"""The high-threshold neuron fires once a call, never for echoes; with the onset neuron it makes Figure 8."""

import numpy as np
import pytest

from circuits.blocks.block import Block
from circuits.blocks.sonar import envelope_detector, onset_neuron
from circuits.blocks.sonar.high_threshold_neuron import BLOCK, build
from circuits.devices import Source
from circuits.devices.source import Constant, Sampled
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.transient import Result, simulate
from circuits.testbench import Testbench
from tests.circuits.blocks.values import TEMPERATURES

DEFAULTS = BLOCK.defaults
RATE = envelope_detector.SAMPLE_RATE  # Hz
CALL_TIME = 0.5e-3  # s
VDD = Source("vdd", "vdd", Constant(5.0))


def run(temperature: float = 27.0, **stimuli: float | None) -> Result:
    return simulate(BLOCK.testbench(build(), DEFAULTS | stimuli, 5.0), Silicon(AMI_1500_IDEAL, temperature))


def microphone_noise(samples: int, rms: float) -> np.ndarray:
    time = np.arange(samples) / RATE
    baseband = np.random.Generator(np.random.Philox(key=11)).standard_normal((2, int(time[-1] * 8e3) + 2))
    x, y = (np.interp(time * 8e3, np.arange(part.size), part) for part in baseband)
    angle = 2.0 * np.pi * envelope_detector.CARRIER * time
    noise = rms * (x * np.cos(angle) - y * np.sin(angle))
    noise[0] = 0.0  # the run starts from the rest of silence
    return np.asarray(noise)


def hear(
    bursts: tuple[tuple[float, float, float], ...], stop: float, temperature: float, rms: float = 0.0
) -> tuple[np.ndarray, np.ndarray]:
    """Spikes of the onset and of the high-threshold neuron after the first burst's start, s."""
    silicon = Silicon(AMI_1500_IDEAL, temperature)
    sound = envelope_detector.tone_bursts(bursts, stop, 2.5, 5.0).value
    heard = Sampled(0.0, RATE, np.clip(sound + microphone_noise(sound.size, rms), 0.0, 5.0))
    sources = (VDD, Source("microphone", "microphone", heard))
    ear = simulate(Testbench("ear", envelope_detector.build(), sources, stop), silicon, record=("envelope",))
    grid = np.arange(0.0, stop, 2.0 / RATE)
    envelope = Sampled(0.0, 0.5 * RATE, np.interp(grid, ear.time, ear["envelope"]))
    blocks: tuple[Block, Block] = (onset_neuron.BLOCK, BLOCK)
    spikes = []
    for block in blocks:
        bench = Testbench(
            block.name, block.build(), (VDD, Source("envelope", "envelope", envelope)), stop,
            watch=("spike",),
        )  # fmt: skip
        spikes.append(simulate(bench, silicon, record=("spike",)).spikes["spike"] - CALL_TIME)
    return spikes[0], spikes[1]


@pytest.mark.parametrize("temperature", TEMPERATURES)
@pytest.mark.parametrize(
    ("amplitude", "expected"),
    [(0.0, "none"), (0.94, "none"), (1.3, "none"), (1.4, "one-spike"), (2.5, "one-spike")],
)
def test_the_threshold_parts_call_and_echoes(amplitude: float, expected: str, temperature: float) -> None:
    # 1.5 V less the pedestal of 0.15 V: 1.35 V; 1 V at the microphone gives at most 0.94 V
    result = run(temperature, amplitude=amplitude)
    assert BLOCK.outcome(result) == expected
    margin = BLOCK.measures(result)["margin_V"]
    assert margin is not None
    assert (margin > 0.0) == (expected == "one-spike")


@pytest.mark.parametrize("temperature", TEMPERATURES)
@pytest.mark.parametrize("duration", [1e-3, 2.5e-3, 20e-3])
def test_a_call_gives_one_spike_however_long(duration: float, temperature: float) -> None:
    assert run(temperature, duration=duration).spikes["spike"].size == 1


@pytest.mark.parametrize("temperature", TEMPERATURES)
def test_two_calls_need_the_refractory_period_between_them(temperature: float) -> None:
    assert BLOCK.outcome(run(temperature, second_amplitude=2.2, delay=3e-3)) == "one-spike"
    assert run(temperature, second_amplitude=2.2, delay=6e-3).spikes["spike"].size == 2


@pytest.mark.parametrize("temperature", TEMPERATURES)
@pytest.mark.parametrize("echo", [0.05, 0.2, 1.0])
@pytest.mark.parametrize("call", [2.4, 12.0])
def test_figure_8(call: float, echo: float, temperature: float) -> None:
    bursts = ((CALL_TIME, 1e-3, call), (CALL_TIME + 2e-3, 1e-3, echo), (CALL_TIME + 4.5e-3, 1e-3, echo))
    onset, high = hear(bursts, 6.5e-3, temperature, rms=5e-3)
    assert high.size == 1
    assert onset.size == 3
    assert 0.0 < onset[0] < high[0] < 0.25e-3
    assert high[0] - onset[0] < 0.15e-3  # the fixed offset of every range: 2.5 cm
    assert (onset[1:] > np.array([2e-3, 4.5e-3])).all()
    assert (onset[1:] < np.array([2.4e-3, 4.9e-3])).all()


@pytest.mark.parametrize("temperature", TEMPERATURES)
def test_noise_gives_no_spike(temperature: float) -> None:
    onset, high = hear((), 40e-3, temperature, rms=5e-3)
    assert onset.size == 0
    assert high.size == 0


def test_the_latency_to_a_call_hardly_moves_with_temperature() -> None:
    spikes = [hear(((CALL_TIME, 1e-3, 2.4),), 2e-3, t) for t in TEMPERATURES]
    for neuron in range(2):
        latencies = [float(pair[neuron][0]) for pair in spikes]
        assert max(latencies) - min(latencies) < 15e-6
