"""Closed forms from the circuit's own sizes, against the circuit's simulation."""

from __future__ import annotations

import pytest

from circuits.bias import rebias
from circuits.blocks.sonar import rebound_neuron
from circuits.blocks.sonar.rebound_analysis import analyse, closed_forms
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.transient import simulate

# Neuron 12, the longest delay.
CIRCUIT = rebias(rebound_neuron.build(), {"i_inh_tau": 40.1e-12, "i_ex_tau": 19.7e-12})


def test_parameters_are_the_circuit_s() -> None:
    drawn = analyse(CIRCUIT, Silicon(AMI_1500_IDEAL)).drawn
    assert drawn.c_inh == 440e-15
    assert drawn.i_inh_tau == pytest.approx(40.1e-12, rel=1e-3)
    # the study: 24.89 ms by equation (3); its U_T is 25.85 mV, ours 25.865 mV
    assert drawn.c_inh * (drawn.v_inh_high - drawn.v_hl) / drawn.i_inh_tau == pytest.approx(
        24.89e-3, rel=5e-3
    )


def test_corrected_forms_are_nearer_to_the_simulation_than_printed_ones() -> None:
    stimuli = rebound_neuron.BLOCK.defaults | {"echo": None, "duration": 45e-3}
    bench = rebound_neuron.testbench(CIRCUIT, stimuli, 5.0)
    measured = rebound_neuron.measures(simulate(bench, Silicon(AMI_1500_IDEAL)))
    for form in closed_forms(CIRCUIT, Silicon(AMI_1500_IDEAL)):
        value = measured.get(form.name)
        if value is not None and form.corrected is not None:
            assert abs(form.corrected - value) < abs(form.printed - value), form.name
            # the closed forms leave out the diode's node (4 % of t_inh) and the law's rounding
            assert form.corrected == pytest.approx(value, rel=0.05), form.name


def test_hot_silicon_shortens_the_delay() -> None:
    cold, hot = (
        closed_forms(CIRCUIT, Silicon(AMI_1500_IDEAL, temperature_c=t))[0].printed for t in (27.0, 60.0)
    )
    assert hot < 0.5 * cold
