"""Gradients from one run backwards against those of two dies a draw."""

import numpy as np
import pytest

from circuits.silicon.die import Die
from system.study.search.adjoint import adjoint_sensitivity
from system.study.search.sensitivity import STEP, measure_rows, varying_labels
from system.study.table import Condition
from system.study.target import Subject, open_target

CONDITION = Condition("typical", 27.0, 0)
DIE = Die()


def test_gradients_are_those_of_moved_dies():
    # a draw moved by half a sigma bends the inhibition's time by some per cent of its change
    target = open_target(Subject("rebound-neuron", ("t_inh_s", "v_mem_peak_V")))
    found = adjoint_sensitivity(target, DIE, CONDITION, "t_inh_s")
    assert not isinstance(found, str)
    assert found.labels == varying_labels(target, "typical")
    assert np.isnan(found.gradient[:, 1]).all()
    largest = np.argsort(-np.abs(found.gradient[:, 0]))[:2]
    rows = np.zeros((2 * largest.size, len(found.labels)))
    for k, column in enumerate(largest):
        rows[2 * k : 2 * k + 2, column] = -STEP, STEP
    values = [m.values[0] for m in measure_rows(target, DIE, CONDITION, found.labels, rows, 1)]
    moved = np.log(values[1::2]) - np.log(values[::2])
    np.testing.assert_allclose(found.log_gradient[largest, 0], moved, rtol=0.05)


def test_what_has_no_gradient_says_why():
    target = open_target(Subject("rebound-neuron", ("spikes_per_echo", "supply_power_W")))
    assert "is no number of one run" in str(adjoint_sensitivity(target, DIE, CONDITION, "spikes_per_echo"))
    assert "reads devices beside" in str(adjoint_sensitivity(target, DIE, CONDITION, "supply_power_W"))


def test_a_search_has_the_gradient_of_its_edges():
    target = open_target(Subject("rebound-neuron", ("best_delay",)))
    found = adjoint_sensitivity(target, DIE, CONDITION, "best_delay")
    assert not isinstance(found, str)
    assert found.labels == varying_labels(target, "typical")
    largest = int(np.argmax(np.abs(found.gradient[:, 0])))
    assert found.labels[largest] == "rebound_neuron.inhibition.mi5.v_t0"
    rows = np.zeros((2, len(found.labels)))
    rows[:, largest] = -STEP, STEP
    low, high = (m.values[0] for m in measure_rows(target, DIE, CONDITION, found.labels, rows, 1))
    # both ends of the difference are searched to 10 us
    assert found.gradient[largest, 0] == pytest.approx((high - low) / (2.0 * STEP), abs=2e-5 / STEP)
