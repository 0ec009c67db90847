"""One spike a crossing, none while the input stays above, and a refractory period that a board's RC keeps."""

import numpy as np
import pytest

from circuits.blocks.drive import powered
from circuits.blocks.sonar import envelope_detector, high_threshold_neuron
from circuits.blocks.sonar.spike_generator import (
    PEDESTAL,
    GeneratorParams,
    envelope_testbench,
    spike_generator,
)
from circuits.devices.source import PiecewiseLinear
from circuits.errors import ParameterError
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.transient import Result, simulate
from circuits.testbench import Testbench
from tests.circuits.blocks.values import TEMPERATURES
from tests.circuits.soundness import fault

THRESHOLD = 1.5  # V


def fire(vertices: list[tuple[float, float]], stop: float, temperature: float = 27.0) -> Result:
    time, value = zip(*vertices, strict=True)
    sources = powered(5.0, {"envelope": PiecewiseLinear(time, value)})
    bench = Testbench("generator", high_threshold_neuron.build(), sources, stop, watch=("spike",))
    return simulate(bench, Silicon(AMI_1500_IDEAL, temperature))


def square(*edges: float) -> list[tuple[float, float]]:
    """1 V, and 2 V between each pair of edges."""
    vertices = [(0.0, 1.0)]
    for k, edge in enumerate(edges):
        vertices += [(edge, 1.0 + k % 2), (edge + 1e-5, 2.0 - k % 2)]
    return vertices


def test_the_circuit_is_sound() -> None:
    assert fault(spike_generator(GeneratorParams())) == ""


@pytest.mark.parametrize("temperature", TEMPERATURES)
def test_a_long_input_gives_one_spike(temperature: float) -> None:
    result = fire(square(1e-3, 30e-3), 34e-3, temperature)
    assert result.spikes["spike"].size == 1
    # charging the axon's 3 pF to about 1 V at 250 nA takes 12 us
    assert 1e-3 < result.spikes["spike"][0] < 1.03e-3


@pytest.mark.parametrize("temperature", TEMPERATURES)
def test_the_spike_is_a_full_pulse_of_some_microseconds(temperature: float) -> None:
    result = fire(square(1e-3, 2e-3), 3e-3, temperature)
    width = high_threshold_neuron.BLOCK.measures(result)["spike_width_s"]
    assert width is not None
    assert 4e-6 < width < 15e-6  # fixed gates: 12 us at -20 degC, 5.5 us at 85 degC
    assert result["spike"].max() > 4.9


@pytest.mark.parametrize("temperature", TEMPERATURES)
def test_the_refractory_period_follows_the_end_of_the_input(temperature: float) -> None:
    time_constant = high_threshold_neuron.Params().refractory_resistance * 470e-12
    # the inverter switches between 1.9 and 2.6 V, so the period is within 0.48 to 0.73 time constants
    early = fire(square(1e-3, 2e-3, 2e-3 + 0.45 * time_constant, 6e-3), 6.5e-3, temperature)
    late = fire(square(1e-3, 2e-3, 2e-3 + 0.76 * time_constant, 7e-3), 7.5e-3, temperature)
    assert early.spikes["spike"].size == 1
    assert late.spikes["spike"].size == 2


def test_a_slow_noisy_crossing_gives_one_spike() -> None:
    time = np.arange(0.0, 6e-3, 10e-6)
    noise = 5e-3 * np.random.Generator(np.random.Philox(key=4)).standard_normal(time.size)
    ramp = THRESHOLD + 20.0 * (time - 3e-3) + noise  # 20 V/s: the noise crosses many times
    result = fire(list(zip(time.tolist(), ramp.tolist(), strict=True)), 6e-3)
    assert result.spikes["spike"].size == 1


def test_the_testbench_has_the_detectors_pedestal() -> None:
    bias = {b.name: b.value for b in envelope_detector.BIASES}
    assert bias["v_pedestal"] == PEDESTAL


@pytest.mark.parametrize("rise", [0.0, -1e-4, 0.6e-3])
def test_a_rise_time_that_does_not_fit_is_refused(rise: float) -> None:
    stimuli = {"amplitude": 1.0, "second_amplitude": None, "delay": 2e-3, "duration": 1e-3, "rise_time": rise}
    with pytest.raises(ParameterError, match="rise_time"):
        envelope_testbench("any", high_threshold_neuron.build(), stimuli, 5.0)
