"""Which neuron lost a target, and which of its transistors."""

from dataclasses import replace

import numpy as np
import pytest

from circuits.silicon.die import Die
from system.approach.loss import explained, losses
from system.approach.neuron import TOLERANCE, waveform
from system.approach.trace import Trace
from system.registry import load_system


@pytest.fixture(scope="module")
def trace() -> Trace:
    """A die whose neuron 2, with the codes of the design, does not answer at 2.9 s."""
    approach = load_system("approach")
    scenario = approach.on_silicon(
        level="behavioural", codes="default", die=Die(number=1002), duration=3.2, silicon_noise="off"
    )
    found: Trace = approach.run(scenario)
    return found


def test_a_target_that_is_held_is_never_lost(trace: Trace) -> None:
    assert losses(trace)
    assert losses(replace(trace, estimate_m=trace.range_m)) == []


def test_healing_the_transistor_that_lost_it_brings_the_spike_back(trace: Trace) -> None:
    ((moment, neuron), *_) = explained(trace)
    assert neuron is not None
    k = int(neuron.name[7:-1])
    own = [t for t, n in trace.spikes if n == k and moment.time < t < moment.end]
    assert own == []  # it was silent
    assert np.min(np.abs(trace.echoes - moment.time)) == 0.0  # at an echo that the chip heard
    first, *others = neuron.devices
    assert first.mended.startswith("spikes ")
    assert [d.mended.startswith("silent") for d in others][-20:] == [True] * 20
    assert first.waveform is not None
    as_it_is, healed = first.waveform.lines
    late = [line.value[line.time > moment.time].max() for line in (as_it_is, healed)]
    assert late[1] > late[0] + 0.1  # V, up to the threshold


def test_a_thinned_waveform_is_as_near_as_it_says() -> None:
    time = np.linspace(0.0, 1.0, 2001)
    volts = np.sin(7.0 * time)
    line = waveform("v", time, volts)
    assert line.time.size < 200
    assert np.abs(np.interp(time, line.time, line.value) - volts).max() <= TOLERANCE
