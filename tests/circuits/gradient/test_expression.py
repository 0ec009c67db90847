"""Gradients of expressions against those of what they read, and against differences."""

import numpy as np
import pytest

from circuits.gradient.expression import Expression
from circuits.gradient.gradient import gradients_of
from circuits.gradient.measure import Current, Energy, Extreme, Integral, SpikeTime
from circuits.lowering.kernel import to_kernel
from circuits.measure.measure import read_measures
from circuits.measure.scope import scope_of
from circuits.registry import load_block
from circuits.silicon.die import Die
from circuits.silicon.silicon import Silicon
from tests.circuits.gradient.differences import by_deviations, by_temperature


@pytest.fixture(scope="module")
def machine():
    block = load_block("rebound-neuron")
    return to_kernel(block.bench(), Silicon(block.process, 27.0, Die(number=1003)))


def expressions(machine, *texts):
    return tuple(Expression(each) for each in read_measures(texts, scope_of(machine)))


def test_functions_of_one_waveform_are_the_measures_that_they_are(machine):
    asked = expressions(
        machine,
        "energy(vdd, from=3ms, to=13ms)", "integral(i(vdd))", "mean(i(vdd), from=1ms, to=9ms)",
        "value(i(vdd), at=5ms)", "max(i(axon.ma8))", "cross(spike, 2.5, rise) - cross(call, 2.5, rise)",
    )  # fmt: skip
    same = (
        Energy("vdd", 3e-3, 13e-3), Integral("i(vdd)"), Integral("i(vdd)", 1e-3, 9e-3), Current("vdd", 5e-3),
        Extreme("i(axon.ma8)"), SpikeTime("spike"),
    )  # fmt: skip
    scale = np.array([1.0, 1.0, 1.0 / 8e-3, 1.0, 1.0, 1.0])
    own, other = gradients_of(machine, asked), gradients_of(machine, same)
    assert own.notes == ("",) * len(asked)
    np.testing.assert_allclose(own.values[:-1], (scale * other.values)[:-1], rtol=1e-4)
    tolerance = 1e-6 * scale * other.spread
    assert (np.abs(own.by - scale[:, None] * other.by) * own.sigma <= tolerance[:, None]).all()


def test_arithmetic_goes_by_the_chain_rule(machine):
    asked = expressions(machine, "energy(vdd, to=9ms) / mean(v_mem)", "max(v_mem)^2 * value(i(vdd), at=5ms)")
    own = gradients_of(machine, asked)
    label = "process.n.shared.v_t0"
    at = own.labels.index(label)
    wanted = by_deviations(machine, asked, label, 0.005 * own.sigma[at])
    assert (np.abs(own.by[:, at] - wanted) * own.sigma[at] < 0.01 * own.spread).all()


@pytest.mark.parametrize("label", ["process.n.shared.v_t0", "process.p.shared.v_t0", "temperature"])
def test_root_mean_squares_have_the_gradients_of_differences(machine, label):
    asked = expressions(
        machine, "rms(i(vdd))", "rms(i(axon.ma8), from=2ms)", "rms(i(inhibition.c_inh), to=9ms)",
        "rms(v_mem, from=1ms)", "rms(i(vdd))^2 / rms(v_mem)",
    )  # fmt: skip
    own = gradients_of(machine, asked)
    assert own.notes == ("",) * len(asked)
    at = own.labels.index(label)
    if label == "temperature":
        size, wanted = 1.0, np.array([by_temperature(machine, each, 0.1) for each in asked])
    else:
        size = own.sigma[at]
        wanted = by_deviations(machine, asked, label, 0.005 * size)
    assert (np.abs(own.by[:, at] - wanted) * size < 0.01 * own.spread).all()
    assert (np.abs(wanted) * size > 0.01 * own.spread).any()


def test_root_mean_square_of_what_is_not_there_has_none(machine):
    (asked,) = expressions(machine, "rms(call, to=1us)")
    own = gradients_of(machine, (asked,))
    assert own.values[0] == 0.0
    assert np.isnan(own.by[0]).all()
    assert "can but rise" in own.notes[0]


def test_what_is_read_otherwise_is_a_number_of_the_voltages(machine):
    asked = expressions(
        machine, "max(v_mem * v_ax)", "slope(i(vdd))", "mean(i(vdd), from=cross(call, 2.5, rise))"
    )
    own = gradients_of(machine, asked)
    assert np.isfinite(own.by[0]).all()
    assert not own.notes[0]
    for k in (1, 2):
        assert np.isnan(own.by[k]).all()
        assert "reads devices beside the run's voltages" in own.notes[k]


def test_an_expression_without_a_value_says_why(machine):
    (asked,) = expressions(machine, "cross(spike, 2.5, rise, 7) * 2")
    own = gradients_of(machine, (asked,))
    assert np.isnan(own.values[0])
    assert "does not rise through 2.5V 7 times" in own.notes[0]
