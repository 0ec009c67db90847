"""The ranging chip with its bias chain inside, as one circuit."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from chips.ranging import circuit as ranging_chip
from chips.registry import load_chip
from circuits.blocks.bias import chain as bias_chain
from circuits.blocks.sonar import rebound_neuron
from circuits.event import falling_crossing
from circuits.lowering.check import check_circuit
from circuits.lowering.kernel import Machine, to_kernel
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.operating_point import operating_point
from circuits.solver.transient import simulate
from netlists.dialects.ngspice import format_testbench

QUIET: dict[str, float | None] = {"delay": None, "call": None, "echo": None, "duration": 1e-3}
SILICON = Silicon(AMI_1500_IDEAL, die=Die("A", 1003))


def machine(params: bias_chain.Params, silicon: Silicon | None = None) -> Machine:
    chip = ranging_chip.build_with_chain(ranging_chip.BiasedParams(chain=params))
    return to_kernel(ranging_chip.testbench(chip, QUIET, 5.0), silicon or Silicon(AMI_1500_IDEAL))


def test_the_chain_s_ports_are_inside() -> None:
    chip = ranging_chip.build_with_chain()
    check_circuit(chip)
    ports = {p.name for p in chip.ports}
    assert {"v_inh_tau", "v_ex_tau"}.isdisjoint(ports)
    assert {"v_inh_start", "v_inh_step", "v_ex_start", "v_ex_step"} < ports
    assert {b.port for b in chip.biases} == {p.name for p in chip.ports if p.kind == "bias"}
    assert load_chip("ranging-chip-biased").build is ranging_chip.build_with_chain


@pytest.mark.parametrize(
    ("params", "wanted"),
    [
        (bias_chain.RECIPROCAL, ranging_chip.I_INH_TAU),
        (bias_chain.LINEAR, ranging_chip.linear_currents()),
    ],
    ids=["reciprocal", "linear"],
)
def test_the_chain_gives_the_currents_of_the_chip_without_it(
    params: bias_chain.Params, wanted: tuple[float, ...]
) -> None:
    found = bias_chain.currents(operating_point(machine(params)))
    assert found.inh_tau == pytest.approx(np.array(wanted), rel=0.01)
    assert found.ex_tau == pytest.approx(np.array(ranging_chip.I_EX_TAU), rel=0.01)


def test_a_die_has_the_same_neurons_with_and_without_the_chain() -> None:
    plain = to_kernel(ranging_chip.testbench(ranging_chip.build(), QUIET, 5.0), SILICON)
    biased = machine(bias_chain.RECIPROCAL, SILICON)
    count = plain.kernel.transistors.v_t0.size
    assert count == 34 * ranging_chip.NEURONS
    # the array comes first in both
    assert np.array_equal(plain.kernel.transistors.v_t0, biased.kernel.transistors.v_t0[:count])
    assert biased.kernel.transistors.v_t0.size == count + 2 * (2 + 5 * (ranging_chip.NEURONS - 1))


def test_the_neuron_of_the_delay_fires() -> None:
    chip = ranging_chip.build_with_chain()
    stimuli = QUIET | {"delay": 6.4e-3, "call": 1.0, "echo": 1.0, "duration": 12e-3}
    result = simulate(
        ranging_chip.testbench(chip, stimuli, 5.0), Silicon(AMI_1500_IDEAL), record=("spike[0]",)
    )
    assert ranging_chip.outcome(result) == "2"


def test_a_call_reaches_the_gates_of_the_chain_and_ends_inhibition_earlier() -> None:
    stimuli = QUIET | {"call": 1.0, "duration": 12e-3}
    node, ends = "neuron[3].inhibition.b", []
    for chip in (ranging_chip.build(), ranging_chip.build_with_chain()):
        result = simulate(ranging_chip.testbench(chip, stimuli, 5.0), Silicon(AMI_1500_IDEAL), record=(node,))
        crossing = falling_crossing(result.time, result[node], 2.5)
        assert crossing is not None
        ends.append(crossing - rebound_neuron.CALL_TIME)
    fixed, coupled = ends
    assert 0.03 < 1.0 - coupled / fixed < 0.06
    assert fixed - coupled < 0.4e-3


def test_it_can_be_exported() -> None:
    bench = replace(machine(bias_chain.RECIPROCAL).testbench, stop=1e-3)
    text = format_testbench(bench, SILICON)
    assert text.endswith("\n.end\n")
    for name in ("ranging_chip", "bias_chain", "current_chain_n", "chain_stage_p", "rebound_neuron"):
        assert name in text
