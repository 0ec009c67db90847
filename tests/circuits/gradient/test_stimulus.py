"""Gradients by what sources give and by when, and by stimuli of blocks, against differences."""

from dataclasses import replace

import numpy as np
import pytest

from circuits.gradient.gradient import gradients_of
from circuits.gradient.measure import Current, Energy, Integral, SpikeTime, Voltage
from circuits.gradient.stimulus import own_moves
from circuits.gradient.way import way_of
from circuits.lowering.kernel import to_kernel
from circuits.registry import load_block
from circuits.silicon.die import Die
from circuits.silicon.silicon import Silicon
from circuits.solver.transient import simulate
from tests.circuits.gradient.differences import RTOL


def lowered(name, number=None):
    block = load_block(name)
    return to_kernel(block.bench(), Silicon(block.process, 27.0, Die(number=number)))


def found(machine, measures):
    return gradients_of(machine, measures, moves=own_moves(machine))


def by(gradients, label):
    return gradients.by[:, gradients.labels.index(label)]


def by_lines(machine, measures, move, times):
    """Central differences by a parameter of sources, float64[measures]."""
    ends = []
    for lines in (move.more, move.less):
        moved = tuple(
            (a[0] + times * (b[0] - a[0]), a[1] + times * (b[1] - a[1]))
            for a, b in zip(machine.polylines, lines, strict=True)
        )
        result = simulate(replace(machine, polylines=moved), rtol=RTOL)
        way = way_of(result)
        ends.append(np.array([measure.read(result, way).value for measure in measures]))
    return (ends[0] - ends[1]) / (2.0 * times * move.step.size)


@pytest.mark.parametrize("number", [None, 1003])
def test_sources_of_the_rebound_neuron_move_what_differences_say(number):
    machine = lowered("rebound-neuron", number)
    measures = (
        SpikeTime("spike"),
        Current("vdd", 5e-3),
        Integral("i(vdd)", 1e-3, 5e-3),
        Energy("vdd", 0.0, 5e-3),
    )
    own = found(machine, measures)
    for label, kept in (("vdd.value", 4), ("call.time", 2)):
        (move,) = (m for m in own_moves(machine) if m.step.label == f"source.{label}")
        wanted = by_lines(machine, measures, move, 3.0)
        np.testing.assert_allclose(by(own, f"source.{label}")[:kept], wanted[:kept], rtol=2e-3)


def test_sources_that_come_later_together_move_a_spike_by_as_much():
    machine = lowered("rebound-neuron")
    own = found(machine, (SpikeTime("spike"),))
    assert by(own, "source.call.time") + by(own, "source.echo.time") == pytest.approx(1.0, abs=1e-4)
    # the inhibition ends where the call says, and the echo comes before its end
    assert by(own, "source.echo.time") < -0.1


def test_a_current_into_a_membrane_moves_spikes_as_much_as_it_charges_it():
    machine = lowered("axon-hillock")
    measures = (SpikeTime("spike", 2), Voltage("v_mem", 4.6))
    own = found(machine, measures)
    for move in own_moves(machine):
        wanted = by_lines(machine, measures, move, 1.0)
        np.testing.assert_allclose(by(own, move.step.label), wanted, rtol=5e-3)


def test_sources_have_no_sigma_and_are_none_unless_asked():
    machine = lowered("rebound-neuron")
    measures = (SpikeTime("spike"),)
    own, without = found(machine, measures), gradients_of(machine, measures)
    assert not [label for label in without.labels if label.startswith("source.")]
    assert own.labels[: len(without.labels)] == without.labels
    assert own.spread[0] == without.spread[0]
    assert not own.sigma[len(without.labels) :].any()
