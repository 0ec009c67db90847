"""Draws of a plan in the place of a die's own."""

from __future__ import annotations

import pickle
from dataclasses import replace

import numpy as np
import pytest

from circuits.blocks.sonar import rebound_neuron
from circuits.circuit import Circuit, InstanceArray
from circuits.errors import ParameterError
from circuits.lowering.flatten import flatten
from circuits.lowering.variation import variation_draws, variation_labels
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.sampling import Sampling, labels
from circuits.silicon.silicon import Silicon

FLAT = flatten(rebound_neuron.build())


def test_every_transistor_has_two_labels_and_every_polarity_two() -> None:
    silicon = Silicon(AMI_1500_IDEAL, die=Die(number=3))
    found = variation_labels(FLAT, silicon)
    transistors = [g for g in FLAT.groups if hasattr(g.device, "polarity")]
    assert len(found) == len(set(found)) == 2 * len(transistors) + 4
    assert "rebound_neuron.inhibition.mi5.v_t0" in found
    assert "process.p.shared.beta" in found
    local = variation_labels(FLAT, Silicon(AMI_1500_IDEAL, die=Die(number=3, process=False)))
    assert len(local) == 2 * len(transistors)
    assert len(variation_labels(FLAT, Silicon(AMI_1500_IDEAL, die=Die(number=3, mismatch=False)))) == 4


def test_arrays_are_labelled_element_by_element() -> None:
    paths = [(("neuron", (2, 2)), ("m1", ())), (("bias", ()), ("m2", ()))]
    assert labels((("chip", ()), ("half", (1,))), paths, "beta") == [
        *(f"chip.half[1].neuron[{i},{j}].m1.beta" for i in range(2) for j in range(2)),
        "chip.half[1].bias.m2.beta",
    ]


def test_a_plan_takes_the_place_of_the_draws_that_it_has() -> None:
    die = Die(number=5)
    silicon = Silicon(AMI_1500_IDEAL, die=die)
    found = variation_labels(FLAT, silicon)
    own = variation_draws(FLAT, silicon, die)
    rows = np.array([[9.0, 8.0], [7.0, 6.0]])
    plan = Sampling("test", 5, {found[3]: 0, "process.n.shared.v_t0": 1}, rows)
    planned = variation_draws(FLAT, silicon, replace(die, sampling=plan))
    changed = np.flatnonzero(planned != own)
    assert [found[k] for k in changed] == [found[3], "process.n.shared.v_t0"]
    assert planned[changed].tolist() == [9.0, 8.0]
    there = replace(silicon, die=replace(die, sampling=plan))
    shift = there.law("n").v_t0 - Silicon(AMI_1500_IDEAL).law("n").v_t0
    assert shift == pytest.approx(8.0 * 33e-3)
    again = pickle.loads(pickle.dumps(replace(die, sampling=plan)))
    np.testing.assert_array_equal(variation_draws(FLAT, silicon, again), planned)


def test_a_die_outside_the_plan_is_refused_and_named() -> None:
    plan = Sampling("lhs", 5, {"process.n.shared.v_t0": 0}, np.zeros((2, 1)))
    die = Die(number=7, sampling=plan)
    with pytest.raises(ParameterError, match="die: 7, the plan lhs has 5 to 6"):
        Silicon(AMI_1500_IDEAL, die=die).law("n")
    assert str(replace(die, number=6)) == "die A/6 plan lhs"


def test_the_labels_are_those_of_the_solver_s_draws() -> None:
    inner = rebound_neuron.build()
    ports = inner.wired()
    array = InstanceArray("neuron", inner, (2,), ports)
    chip = Circuit("pair", tuple(inner.ports), instances=(array,))
    flat = flatten(chip)
    silicon = Silicon(AMI_1500_IDEAL, die=Die(number=1, process=False))
    found = variation_labels(flat, silicon)
    plan = Sampling("one", 1, {"pair.neuron[1].inhibition.mi5.v_t0": 0}, np.array([[100.0]]))
    drawn = variation_draws(flat, silicon, replace(silicon.die, sampling=plan))
    assert found[int(drawn.argmax())] == "pair.neuron[1].inhibition.mi5.v_t0"
