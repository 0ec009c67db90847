"""The solver agrees with ngspice on a die: a neuron at its place on the chip, biased from the generator."""

from dataclasses import replace

import pytest

from chips.ranging import circuit as ranging_chip
from circuits.bias import rebias
from circuits.blocks.sonar.tuning import tuning_machine
from circuits.place import circuit_at
from circuits.registry import load_block
from circuits.silicon.die import Die
from circuits.silicon.silicon import Silicon
from circuits.solver.operating_point import operating_point
from netlists.ngspice import engine
from netlists.ngspice.agreement import USUAL, compare

pytestmark = pytest.mark.usefixtures("kept_ngspice")

CHIP = rebias(ranging_chip.build(), kind="ideal")
DIE = Die("B", 1003)


def test_a_neuron_at_its_place_agrees() -> None:
    neuron, place = circuit_at(CHIP, (("neuron", (5,)),))
    silicon = Silicon(die=DIE, place=place)
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
