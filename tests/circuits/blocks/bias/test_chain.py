"""Bias chains of the 13-neuron array: currents of the facts, and errors that accumulate from stage to stage.

Currents: facts on the rebound neuron, reconstructed from the paper; the linear chain's are even steps between
the first and the last.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from circuits.bias import bias_voltages, rebias
from circuits.blocks.bias.chain import (
    BIASED_SIZE,
    BLOCK,
    LINEAR,
    NEURONS,
    RECIPROCAL,
    Params,
    build,
    currents,
)
from circuits.blocks.bias.generator import transistor_current
from circuits.blocks.sonar import rebound_neuron
from circuits.circuit import Circuit
from circuits.devices import Transistor
from circuits.errors import ParameterError
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.operating_point import OperatingPoint, operating_point, solve_near
from circuits.solver.transient import simulate

FACTS = 1e-12 * np.array([955.3, 330.7, 199.9, 143.2, 111.6, 91.4, 77.4, 67.1, 59.2, 52.9, 47.9, 43.7, 40.1])
EX_TAU = 1e-12 * np.array([68.9, 64.8, 60.7, 56.6, 52.5, 48.4, 44.3, 40.2, 36.1, 32.0, 27.9, 23.8, 19.7])
DEFAULTS = BLOCK.defaults
NOMINAL = Silicon(AMI_1500_IDEAL)
CHAINS = {"inhibition": "inh_tau", "excitation": "ex_tau"}


def rest(params: Params = RECIPROCAL, silicon: Silicon = NOMINAL) -> OperatingPoint:
    return operating_point(BLOCK.testbench(build(params), DEFAULTS, 5.0), silicon)


def transistor_labels(point: OperatingPoint) -> list[str]:
    return [g.label(0) for g in point.machine.flat.groups if isinstance(g.device, Transistor)]


def shifted(point: OperatingPoint, path: str, v_t0: float) -> OperatingPoint:
    """The state with V_T0 of the transistor at `path` shifted by `v_t0` V."""
    kernel = point.machine.kernel
    values = kernel.transistors.v_t0.copy()
    values[transistor_labels(point).index(path)] += v_t0
    changed = kernel._replace(transistors=kernel.transistors._replace(v_t0=values))
    found = solve_near(replace(point.machine, kernel=changed), point.voltage)
    assert found is not None
    return found


def test_reciprocal_currents_are_the_facts() -> None:
    found = currents(rest(RECIPROCAL))
    assert found.inh_tau == pytest.approx(FACTS, rel=0.01)
    assert found.ex_tau == pytest.approx(EX_TAU, rel=0.01)


def test_linear_currents_rise_in_even_steps_between_the_same_ends() -> None:
    found = currents(rest(LINEAR))
    assert found.inh_tau == pytest.approx(np.linspace(955.3e-12, 40.1e-12, NEURONS), rel=0.01)
    assert found.ex_tau == pytest.approx(EX_TAU, rel=0.01)


def test_the_biased_devices_are_the_neuron_s() -> None:
    neuron = rebound_neuron.build()
    for bias, polarity in (("i_inh_tau", "n"), ("i_ex_tau", "p")):
        device = neuron.device(neuron.bias(bias).device or "")
        assert isinstance(device, Transistor)
        assert (device.polarity, device.width, device.length) == (polarity, BIASED_SIZE, BIASED_SIZE)


def test_gate_voltages_are_those_of_the_neuron_s_own_biases() -> None:
    point, neuron = rest(), rebound_neuron.build()
    for name, found in zip(("i_inh_tau", "i_ex_tau"), currents(point), strict=True):
        bias = neuron.bias(name)
        for k in range(NEURONS):
            wanted = bias_voltages(neuron, replace(bias, value=float(found[k])), Silicon(AMI_1500_IDEAL))
            assert point[f"{bias.port}[{k}]"] == pytest.approx(float(wanted), abs=1e-6)


def test_the_diode_of_a_stage_carries_the_current_of_its_neuron() -> None:
    point = rest()
    found = currents(point)
    for stage in range(NEURONS):
        neuron = NEURONS - 1 - stage
        assert transistor_current(point, f"inhibition.stage_{stage}.md") == pytest.approx(
            found.inh_tau[neuron]
        )
        assert transistor_current(point, f"excitation.stage_{stage}.md") == pytest.approx(
            -found.ex_tau[neuron]
        )


@pytest.mark.parametrize("device", ["ma", "md", "mc", "mp", "mq"])
@pytest.mark.parametrize("chain", CHAINS)
@pytest.mark.parametrize("stage", [1, 5, 12])
@pytest.mark.parametrize("params", [LINEAR, RECIPROCAL], ids=["linear", "reciprocal"])
def test_a_shift_in_one_stage_moves_it_and_all_later_ones(
    params: Params, stage: int, chain: str, device: str
) -> None:
    point = rest(params)
    moved = shifted(point, f"{chain}.stage_{stage}.{device}", 5e-3)
    change = {
        name: getattr(currents(moved), name) / getattr(currents(point), name) - 1 for name in CHAINS.values()
    }
    own, other = change.pop(CHAINS[chain]), next(iter(change.values()))
    in_order = own[::-1]  # stage by stage
    assert np.abs(in_order[:stage]).max() < 1e-9
    assert np.abs(in_order[stage:]).min() > 1e-4
    assert len(set(np.sign(in_order[stage:]))) == 1
    assert np.abs(other).max() < 1e-9


def test_spread_over_dies_accumulates_along_the_chain() -> None:
    dies = (Silicon(AMI_1500_IDEAL, die=Die("A", number, process=False)) for number in range(1000, 1020))
    logs = np.log([np.concatenate(currents(rest(LINEAR, silicon))) for silicon in dies])
    spread = logs.std(axis=0, ddof=1)
    # ma and md of the first stage alone, by area in weak inversion: sigma(ln I) = kappa sigma_VT / U_T each
    sigma_v_t0 = AMI_1500_IDEAL.pair_a_vt / np.sqrt(2.0 * RECIPROCAL.side_length**2)
    kappas = np.array([AMI_1500_IDEAL.n.kappa, AMI_1500_IDEAL.p.kappa])
    first = float(np.linalg.norm(kappas)) * sigma_v_t0 / Silicon(AMI_1500_IDEAL).thermal_voltage
    assert spread[NEURONS - 1] == pytest.approx(first, rel=0.5)
    assert spread[2 * NEURONS - 1] == pytest.approx(first, rel=0.5)
    assert spread[0] > 1.5 * spread[NEURONS - 1]
    assert spread[NEURONS] > 1.5 * spread[2 * NEURONS - 1]


@pytest.mark.parametrize("corner", ["ss", "ff", "sf", "fs"])
def test_currents_follow_their_biases_whatever_the_process_is(corner: str) -> None:
    # ideal biases take the process out of the added currents, and the mirrors do not bring it back
    circuit = rebias(build(), kind="ideal")
    silicon = Silicon(AMI_1500_IDEAL, die=Die(corner=corner))  # type: ignore[arg-type]
    found = currents(operating_point(BLOCK.testbench(circuit, DEFAULTS, 5.0), silicon))
    # an nFET's off current of some fA is 3 sigma larger in a fast process: 0.2 pA beside 2 pA steps
    assert found.inh_tau == pytest.approx(FACTS, rel=0.02)
    assert found.ex_tau == pytest.approx(EX_TAU, rel=0.02)


def test_wrong_ratios_are_refused() -> None:
    with pytest.raises(ParameterError, match=r"inhibition_ratios: \(1.0,\), must be 12 numbers > 0"):
        Params(inhibition_ratios=(1.0,))
    with pytest.raises(ParameterError, match=r"excitation_ratios: .*, must be 12 numbers > 0"):
        Params(excitation_ratios=(0.0,) * 12)


def test_measures_and_outcome_of_a_run() -> None:
    result = simulate(BLOCK.testbench(build(), DEFAULTS, 5.0), Silicon(AMI_1500_IDEAL))
    found = BLOCK.measures(result)
    assert found["i_inh_tau_0_A"] == pytest.approx(FACTS[0], rel=0.01)
    assert found["i_ex_tau_12_A"] == pytest.approx(EX_TAU[12], rel=0.01)
    assert BLOCK.outcome(result) == "falling"
    uneven = Params(inhibition_ratios=(0.1, *RECIPROCAL.inhibition_ratios[1:]))
    assert (
        BLOCK.outcome(simulate(BLOCK.testbench(build(uneven), DEFAULTS, 5.0), Silicon(AMI_1500_IDEAL)))
        == "not-monotone"
    )


def test_biases_reach_the_first_and_the_second_stage() -> None:
    circuit: Circuit = build()
    for bias in circuit.biases:
        assert isinstance(circuit.device(bias.device or ""), Transistor)
