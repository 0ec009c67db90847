"""Gradients of measures of all kinds at once, and how far a coarser run's differ."""

import re
from dataclasses import replace

import numpy as np
import pytest

from circuits.bias import rebias
from circuits.blocks.sonar.tuning_metrics import BEST_DELAY
from circuits.errors import ParameterError
from circuits.gradient.every import AGREES, Searched, _moved, every_gradient
from circuits.gradient.gradient import gradients_of
from circuits.gradient.measure import Extreme, Measured, SpikeTime, Voltage
from circuits.gradient.small_signal.spectrum import Spectrum
from circuits.gradient.small_signal.transfer import Transfer
from circuits.gradient.stimulus import own_moves
from circuits.gradient.way import way_of
from circuits.lowering.kernel import to_kernel
from circuits.registry import load_block
from circuits.silicon.die import Die
from circuits.silicon.silicon import Silicon
from circuits.solver.operating_point import operating_point
from circuits.solver.transient import simulate
from circuits.units import format_quantity


def lowered(name, number=None, die=None):
    block = load_block(name)
    return to_kernel(block.bench(), Silicon(block.process, 27.0, die or Die(number=number)))


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


def test_a_spike_that_dies_one_sigma_away_do_not_have_is_told():
    """The process alone moves the release by milliseconds, away from the echo that it has to meet."""
    spike = SpikeTime("spike")
    machine = lowered("rebound-neuron")
    own = every_gradient(machine, (spike, Extreme("v_mem", end=1e-2)), check=True)
    assert own.notes[0].count("one sigma") == 2
    assert "one sigma along its gradient it has no value: 0 spikes" in own.notes[0]
    assert own.notes[1] == ""
    gap = Measured("gap", lambda result: float(result.spikes["spike"][0] - 1e-3), "s")
    assert "it has no value: index 0" in every_gradient(machine, (gap,), check=True).notes[0]
    alike = lowered("rebound-neuron", die=Die(process=False))
    assert every_gradient(alike, (spike,), check=True).notes[0].count("one sigma") == 1


def test_what_bends_within_a_sigma_is_told_with_what_it_moves_by():
    machine, measure = lowered("rebound-neuron", 1003), Voltage("v_mem", 8e-3)
    own = every_gradient(machine, (measure,), check=True)
    there = _moved(machine, own, own.by[0] / own.spread[0])
    moved = simulate(there, rtol=1e-7)
    by = measure.read(moved, way_of(moved)).value - own.values[0]
    assert abs(by) < 0.5 * own.spread[0]
    assert f"moves by {format_quantity(by, 'V')}, not by the sigma" in own.notes[0]


@pytest.mark.parametrize("die", [Die(), Die(number=1003), Die(number=1003, variation="full")], ids=str)
@pytest.mark.parametrize("kind", ["gate", "ideal", "generator"])
def test_a_die_that_is_not_moved_is_the_same(die, kind):
    block = load_block("rebound-neuron")
    bench = block.bench()
    bench = replace(bench, circuit=rebias(bench.circuit, kind=kind))
    machine = to_kernel(bench, Silicon(block.process, 27.0, die))
    found = gradients_of(machine, (Voltage("v_mem"),))
    same, other = (_moved(machine, found, share * found.by[0]) for share in (0.0, 1e-3))
    kept, there, away = (each.kernel.transistors for each in (machine, same, other))
    assert all(np.array_equal(a, b) for a, b in zip(kept, there, strict=True))
    assert not all(np.array_equal(a, b) for a, b in zip(kept, away, strict=True))
    for own, at in zip(machine.polylines, same.polylines, strict=True):
        np.testing.assert_array_equal(own[1], at[1])


def test_searches_and_small_signals_are_measured_there_too():
    machine = lowered("rebound-neuron")
    transfer = Transfer("db", "v_mem", "vdd", 1e3)
    own = every_gradient(machine, (searched(machine), transfer), check=True)
    assert re.fullmatch(r"one sigma along its gradient it moves by .*ms, not by the sigma", own.notes[0])
    there = searched(_moved(machine, own, own.by[0] / own.spread[0]))
    by = BEST_DELAY.value(BEST_DELAY.measure(there.machine)) - own.values[0]
    assert by > 1.5 * own.spread[0]
    assert transfer.read(Spectrum(operating_point(machine))).value == pytest.approx(own.values[1])
    assert "one sigma" not in own.notes[1]
