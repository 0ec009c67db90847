"""Tuning of a neuron: its class and edges are converged at the tolerance that is the default."""

from __future__ import annotations

import math

import pytest

from circuits.blocks import rebound_neuron
from circuits.blocks.tuning import RESOLUTION, NeuronClass, tune, tuning_machine
from circuits.die import Die
from circuits.silicon import Silicon


# Nearly grazing dies: at 1e-4 the first edge of 77 is 53 us off, and 171 counts as working.
@pytest.mark.parametrize("number", [77, 171])
def test_grazing_dies_are_converged(number: int) -> None:
    silicon = Silicon(die=Die(number=number, process=False))
    machine = tuning_machine(rebound_neuron.build(), silicon)
    default, fine = tune(machine), tune(machine, 1e-6)
    assert default.outcome is fine.outcome
    if fine.outcome is NeuronClass.WORKS:
        # both bisected to the resolution
        assert default.first == pytest.approx(fine.first, abs=2.0 * RESOLUTION)
        assert default.last == pytest.approx(fine.last, abs=2.0 * RESOLUTION)


def test_what_does_not_work_has_no_best_delay() -> None:
    silicon = Silicon(die=Die(number=171, process=False))
    tuning = tune(tuning_machine(rebound_neuron.build(), silicon))
    assert tuning.outcome is not NeuronClass.WORKS
    assert math.isnan(tuning.best_delay)
    assert not math.isnan(tuning.t_inh)
