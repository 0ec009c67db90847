"""Published forms of ROLLS' circuits, and the circuit's own with both kappas."""

from dataclasses import replace

import numpy as np
import pytest

from chips.rolls.synapse import forms
from circuits.silicon.process import ROLLS_180_IDEAL

SYNAPSE = forms.SynapseForm(i_w=20e-9, i_th=100e-12, i_tau=100e-12, tau=0.6e-3, rest=0.1e-12, power=1.136)
NEURON = forms.circuit_neuron(2.1e-12)
CURRENT = 0.3e-9


def test_both_forms_of_the_synapse_are_one_where_the_kappas_are_equal() -> None:
    equal = replace(SYNAPSE, power=1.0)
    assert forms.synapse_pair(equal, 1e-12, 20e-6) == forms.synapse_full(equal, 1e-12, 20e-6)
    assert forms.synapse_pair(SYNAPSE, 1e-9, 20e-6) != forms.synapse_full(SYNAPSE, 1e-9, 20e-6)


def test_the_full_form_ends_where_it_stands_still_and_the_linear_one_above() -> None:
    gain = SYNAPSE.i_th * SYNAPSE.i_w / SYNAPSE.i_tau
    assert forms.synapse_full(SYNAPSE, gain, 0.02) == pytest.approx(gain - SYNAPSE.i_th, rel=1e-6)
    assert forms.synapse_linear(SYNAPSE, 1e-12, 0.02) == pytest.approx(gain, rel=1e-6)


def test_a_long_train_of_the_linear_form_has_its_gain_times_the_duty() -> None:
    _, mean = forms.synapse_train(SYNAPSE, forms.synapse_linear, 20e-6, 200.0, 5)
    expected = SYNAPSE.i_th * SYNAPSE.i_w / SYNAPSE.i_tau * 200.0 * 20e-6
    # the trapezoid over a pulse of a thirtieth of tau
    assert mean == pytest.approx(expected, rel=0.01)


def test_a_jump_does_not_know_how_long_the_pulse_is() -> None:
    _, mean = forms.synapse_jumps(replace(SYNAPSE, rest=1e-9), 10.0, 1)
    step = SYNAPSE.i_w * SYNAPSE.i_th / (SYNAPSE.i_tau * 1.1)
    assert mean == pytest.approx(10.0 * SYNAPSE.tau * step, rel=1e-3)


def test_a_neuron_fires_above_its_rheobase_alone() -> None:
    feedback = forms.feedback_linear(NEURON)
    rate = [forms.rate_of(NEURON, forms.neuron_pair(NEURON, feedback, i)) for i in (127e-12, 134e-12)]
    assert rate[0] == 0.0
    assert rate[1] > 10.0


def test_without_its_threshold_term_a_neuron_is_faster_and_with_adaptation_slower() -> None:
    feedback = forms.feedback_linear(NEURON)
    whole = forms.rate_of(NEURON, forms.neuron_published(NEURON, feedback, CURRENT))
    without = forms.rate_of(NEURON, forms.neuron_without_threshold(NEURON, feedback, CURRENT))
    adapted = forms.rate_of(NEURON, forms.neuron_published(NEURON, feedback, CURRENT, 20e-12))
    assert without > whole > adapted > 0.0


def test_feedbacks_are_as_printed() -> None:
    i = np.array([0.5e-9])
    assert forms.feedback_sigmoid(NEURON)(i) == pytest.approx(25e-12)
    kappa = ROLLS_180_IDEAL.n.kappa
    power = NEURON.i_0 * (i / NEURON.i_0) ** (kappa / (kappa + 1.0))
    assert forms.feedback_power(NEURON)(i) == pytest.approx(power, rel=1e-12)
    assert forms.feedback_linear(NEURON)(i) == pytest.approx(NEURON.alpha * i)


def test_the_process_has_the_software_s_off_current() -> None:
    for m in (ROLLS_180_IDEAL.n, ROLLS_180_IDEAL.p):
        # V_T0 has three digits
        assert forms.off_current(m.mu_cox, m.kappa, m.v_t0) == pytest.approx(0.5e-12, rel=0.02)
