"""Tuning of a neuron: its class and edges are converged at the tolerance that is the default."""

from __future__ import annotations

import math

import pytest

from circuits.blocks import rebound_neuron
from circuits.blocks.tuning import RESOLUTION, NeuronClass, rebound_bound, tune, tuning_machine
from circuits.die import Die
from circuits.silicon import Silicon
from circuits.solver.transient import Runner


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


def test_a_slow_rebound_is_waited_for() -> None:
    """The pFETs of this die pass so little I_rtau that its rebound outlasts C_r V_dd / 400 pA, 7.5 ms."""
    machine = tuning_machine(rebound_neuron.build(), Silicon(die=Die(number=2138)))
    tuning = tune(machine)
    bound = rebound_bound(Runner(machine))
    assert tuning.t_reb > 7.5e-3
    assert tuning.t_reb < 0.99 * bound
    assert tuning.last < tuning.t_inh + 0.99 * bound
