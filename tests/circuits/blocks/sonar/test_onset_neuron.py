"""The onset neuron fires once at the beginning of each sound, and neither in noise nor on a slow rise."""

import numpy as np
import pytest

from circuits.blocks.drive import powered, step
from circuits.blocks.sonar.onset_neuron import BLOCK, build
from circuits.devices.source import PiecewiseLinear
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.transient import Result, simulate
from circuits.testbench import Testbench
from tests.circuits.blocks.values import TEMPERATURES, number

CALL = 2.36  # V, the envelope detector's answer to 2.4 V at the microphone
WEAKEST = 0.0118  # V, its answer to 50 mV, at 85 degC where it is smallest
DEFAULTS = BLOCK.defaults


def run(temperature: float = 27.0, **stimuli: float | None) -> Result:
    return simulate(BLOCK.testbench(build(), DEFAULTS | stimuli, 5.0), Silicon(AMI_1500_IDEAL, temperature))


def ramp(slope: float, height: float, temperature: float) -> Result:
    rise = height / slope
    sources = powered(5.0, {"envelope": step(1e-3, 1e-3 + rise, 0.15, 0.15 + height)})
    bench = Testbench("ramp", build(), sources, 2e-3 + rise, watch=("spike",))
    return simulate(bench, Silicon(AMI_1500_IDEAL, temperature))


@pytest.mark.parametrize("temperature", TEMPERATURES)
def test_silence_gives_no_spike(temperature: float) -> None:
    result = run(temperature, amplitude=0.0)
    found = BLOCK.measures(result)
    assert BLOCK.outcome(result) == "none"
    assert found["latency_s"] is None
    assert found["interval_s"] is None
    assert found["spike_width_s"] is None
    # kappa (v_level - v_base) is 42 mV at every temperature
    assert found["margin_V"] == pytest.approx(-0.042, abs=1e-3)


@pytest.mark.parametrize("temperature", TEMPERATURES)
@pytest.mark.parametrize("amplitude", [WEAKEST, 0.05, 0.2, 1.0, CALL])
@pytest.mark.parametrize("duration", [1e-3, 10e-3])
def test_a_sound_gives_one_spike(amplitude: float, duration: float, temperature: float) -> None:
    result = run(temperature, amplitude=amplitude, duration=duration)
    found = BLOCK.measures(result)
    assert BLOCK.outcome(result) == "one-spike"
    assert 0.0 < number(found["latency_s"]) < 0.25e-3
    assert number(found["margin_V"]) > 0.0


@pytest.mark.parametrize("temperature", TEMPERATURES)
@pytest.mark.parametrize(
    ("first", "second"), [(CALL, WEAKEST), (CALL, CALL), (WEAKEST, WEAKEST), (0.3, WEAKEST)]
)
def test_sounds_2_ms_apart_give_a_spike_each(first: float, second: float, temperature: float) -> None:
    result = run(temperature, amplitude=first, second_amplitude=second)
    assert result.spikes["spike"].size == 2
    assert BLOCK.measures(result)["interval_s"] == pytest.approx(2e-3, abs=0.25e-3)


def test_a_louder_sound_is_heard_earlier() -> None:
    latencies = [number(BLOCK.measures(run(amplitude=a))["latency_s"]) for a in (WEAKEST, 0.05, 0.2, CALL)]
    assert latencies == sorted(latencies, reverse=True)


@pytest.mark.parametrize("temperature", TEMPERATURES)
def test_a_slow_rise_gives_no_spike_and_a_fast_one_does(temperature: float) -> None:
    # s_h / G is 17 V/s; v_h reaches the threshold at the share 1 - e^(-42 mV / U_T): 0.74 of it at 85 degC
    assert ramp(10.0, 0.3, temperature).spikes["spike"].size == 0
    assert ramp(30.0, 0.3, temperature).spikes["spike"].size == 1


@pytest.mark.parametrize("temperature", TEMPERATURES)
def test_the_noise_of_an_envelope_gives_no_spike(temperature: float) -> None:
    # 5 mV rms at the microphone makes 0.3 mV rms of envelope
    time = np.arange(0.0, 0.1, 0.125e-3)
    noise = 0.15 + 0.3e-3 * np.random.Generator(np.random.Philox(key=6)).standard_normal(time.size)
    noise[0] = 0.15
    envelope = PiecewiseLinear(tuple(time.tolist()), tuple(noise.tolist()))
    sources = powered(5.0, {"envelope": envelope})
    bench = Testbench("noise", build(), sources, 0.1, watch=("spike",))
    result = simulate(bench, Silicon(AMI_1500_IDEAL, temperature))
    assert result.spikes["spike"].size == 0
    assert number(BLOCK.measures(result)["margin_V"]) < -0.02
