"""The solver agrees with ngspice on a die: a neuron at its place on the chip, biased from the generator."""

from dataclasses import replace

import pytest

from chips.ranging import circuit as ranging_chip
from circuits.bias import rebias
from circuits.blocks.sonar.tuning import tuning_machine
from circuits.lowering.coupling import coupled
from circuits.place import circuit_at
from circuits.registry import load_block
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.operating_point import operating_point
from circuits.solver.transient import Result, simulate
from circuits.testbench import Testbench
from netlists.ngspice import engine
from netlists.ngspice.agreement import SOLVER_RTOL, USUAL, compare, difference
from netlists.ngspice.form import scaled_testbench, started
from tests.agreement.blocks import Case, case_of, silicon_of

pytestmark = pytest.mark.usefixtures("kept_ngspice")

CHIP = rebias(ranging_chip.build(), kind="ideal")
DIE = Die("B", 1003)


def test_a_neuron_at_its_place_agrees() -> None:
    neuron, place = circuit_at(CHIP, (("neuron", (5,)),))
    silicon = Silicon(AMI_1500_IDEAL, die=DIE, place=place)
    block = load_block("rebound-neuron")
    stimuli = block.defaults | {"delay": 0.3e-3, "duration": 1.7e-3}
    testbench = block.testbench(neuron, stimuli, silicon.process.v_dd)
    found = compare(testbench, silicon)
    assert found.agrees, found
    ours = operating_point(tuning_machine(neuron, silicon)).voltages()
    elsewhere = engine.operating_point(testbench, replace(silicon, place=None))
    peer = engine.operating_point(testbench, silicon)
    assert all(abs(ours[n] - peer[n]) < USUAL.operating_point for n in ours)
    assert max(abs(elsewhere[n] - peer[n]) for n in ours) > 10.0 * USUAL.operating_point


def agreed(bench: Testbench, silicon: Silicon, case: Case) -> tuple[Result, Result]:
    """Waveforms of the solver and of ngspice, which agree."""
    ours = simulate(bench, silicon, rtol=SOLVER_RTOL)
    peer = engine.simulate(bench, silicon, reltol=case.reltol, tmax=bench.stop / case.points)
    found = difference(ours, peer, case.allowed)
    assert found.share <= 1.0, (found, found.worst_node, found.worst_rms)
    return ours, peer


def test_a_block_agrees_on_a_die_with_all_components() -> None:
    """One that then keeps silent; those that fire have such a die in `tests.agreement.blocks`."""
    block, case = load_block("rebound-neuron"), case_of("rebound-neuron")
    drawn = silicon_of(block)
    silicon = replace(drawn, die=replace(drawn.die, variation="full"))
    testbench = started(scaled_testbench(block, silicon, case.form), silicon)
    _, peer = agreed(testbench, silicon, case)
    plain = difference(simulate(testbench, drawn, rtol=SOLVER_RTOL), peer, case.allowed)
    assert plain.share > 1.0, "the components change nothing that is compared"


def test_a_coupled_block_agrees() -> None:
    block, case = load_block("rebound-neuron"), case_of("rebound-neuron")
    silicon = Silicon(AMI_1500_IDEAL)
    plain = scaled_testbench(block, silicon, case.form)
    bench = started(replace(plain, circuit=coupled(plain.circuit, "bus")), silicon)
    ours, _ = agreed(bench, silicon, case)
    apart = difference(simulate(plain, silicon, rtol=SOLVER_RTOL), ours, case.allowed)
    assert apart.share > 1.0, "coupling changes nothing that is compared"
