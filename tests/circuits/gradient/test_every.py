"""Gradients of measures of all kinds at once, and how far a coarser run's differ."""

import numpy as np
import pytest

from circuits.blocks.sonar.tuning_metrics import BEST_DELAY
from circuits.errors import ParameterError
from circuits.gradient.every import AGREES, Searched, every_gradient
from circuits.gradient.gradient import gradients_of
from circuits.gradient.measure import Extreme, SpikeTime, Voltage
from circuits.gradient.small_signal.transfer import Transfer
from circuits.gradient.stimulus import own_moves
from circuits.lowering.kernel import to_kernel
from circuits.registry import load_block
from circuits.silicon.die import Die
from circuits.silicon.silicon import Silicon


def lowered(name, number=None):
    block = load_block(name)
    return to_kernel(block.bench(), Silicon(block.process, 27.0, Die(number=number)))


def searched(machine):
    return Searched(BEST_DELAY, BEST_DELAY.prepare(machine.testbench.circuit, machine.silicon))


def test_kinds_stand_in_the_order_in_which_they_are_asked():
    machine = lowered("rebound-neuron")
    transfer = Transfer("mag", "v_mem", "vdd", 1e3)
    own = every_gradient(
        machine, (searched(machine), SpikeTime("spike"), transfer, Voltage("v_mem")), moves=own_moves(machine)
    )
    assert own.measures == ("best_delay", "spike_time(spike,0)", transfer.name, "voltage(v_mem)")
    run = gradients_of(machine, (SpikeTime("spike"), Voltage("v_mem")), moves=own_moves(machine))
    columns = [own.labels.index(label) for label in run.labels]
    np.testing.assert_array_equal(own.by[[1, 3]][:, columns], run.by)
    np.testing.assert_allclose(own.spread[[1, 3]], run.spread, rtol=1e-12)
    # the search has its own testbench
    driven = [k for k, label in enumerate(own.labels) if label.startswith("source.")]
    assert np.isfinite(own.by[1:][:, driven]).all()
    assert np.isnan(own.by[0, driven]).all()
    assert np.isfinite(own.spread).all()


def test_a_search_that_finds_nothing_says_why():
    machine = lowered("rebound-neuron", 1005)
    own = every_gradient(machine, (searched(machine), Voltage("v_mem")))
    assert np.isnan(own.values[0])
    assert np.isnan(own.by[0]).all()
    assert own.notes[0] == "never, so that it has no value"
    assert np.isfinite(own.by[1]).all()


def test_a_peak_within_a_step_is_told_by_another_tolerance():
    machine = lowered("envelope-detector")
    peak, whole = Extreme("i(ce)"), Voltage("v_e", 0.00075)
    own = every_gradient(machine, (peak, whole), check=True)
    assert own.error[0] > 0.05
    assert "at ten times the tolerance it differs by" in own.notes[0]
    assert own.error[1] < AGREES
    assert not own.notes[1]
    assert not every_gradient(machine, (peak,)).error.size


def test_no_measure_is_refused():
    with pytest.raises(ParameterError, match="no measure"):
        every_gradient(lowered("envelope-detector"), ())
