"""Coupling through the bias chain: what a call does to the neurons' gates, and nothing at rest."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from chips.ranging import circuit as ranging_chip
from chips.ranging.coupling import Coupling, measure_coupling, separate_neuron
from circuits.blocks.sonar import rebound_neuron
from circuits.lowering.kernel import to_kernel
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.operating_point import operating_point

QUIET: dict[str, float | None] = {"delay": None, "call": None, "echo": None, "duration": 1e-3}


@pytest.fixture(scope="module")
def found() -> Coupling:
    return measure_coupling(Silicon(AMI_1500_IDEAL), rtol=1e-4)


def test_inhibition_ends_earlier_on_the_coupled_chip(found: Coupling) -> None:
    share = found.t_inh / found.t_inh_separate
    assert (found.t_inh > 0.0).all()
    # what docs/evidence/cheely2003.md says: neuron 1 in relation, neuron 4 in time
    assert int(share.argmax()) == 1
    assert share.max() == pytest.approx(0.049, abs=0.001)
    assert int(found.t_inh.argmax()) == 4
    assert found.t_inh.max() == pytest.approx(0.364e-3, abs=5e-6)


def test_every_neuron_fires_in_both_and_earlier_when_coupled(found: Coupling) -> None:
    assert found.only_one_fires == ()
    assert int(np.nanargmax(found.spike)) == 4
    assert found.spike.max() == pytest.approx(0.29e-3, abs=5e-6)
    assert found.spike.min() > 0.0


def test_a_neuron_that_fires_in_one_only_is_told(found: Coupling) -> None:
    spikes = found.spike_coupled.copy()
    spikes[7] = np.nan
    lost = replace(found, spike_coupled=spikes)
    assert lost.only_one_fires == (7,)
    assert np.isnan(lost.spike[7])


def test_a_separate_neuron_rests_where_it_does_on_the_chip() -> None:
    silicon = Silicon(AMI_1500_IDEAL, die=Die("A", 1003))
    chip = ranging_chip.build_with_chain()
    rest = operating_point(to_kernel(ranging_chip.testbench(chip, QUIET, 5.0), silicon))
    neuron, there = separate_neuron(chip, rest, 5)
    alone = operating_point(to_kernel(rebound_neuron.testbench(neuron, QUIET, 5.0), there))
    # nothing couples at rest: gates take no current
    for node in ("v_mem", "membrane.v_r", "excitation.v_ex"):
        inside = "v_mem[5]" if node == "v_mem" else f"neuron[5].{node}"
        assert alone[node] == pytest.approx(rest[inside], abs=1e-6)
