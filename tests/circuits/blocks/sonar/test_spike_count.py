"""One spike or several after a facilitative echo, by the biases alone."""

from __future__ import annotations

import math
from collections.abc import Mapping

import pytest

from circuits.bias import rebias
from circuits.blocks.sonar import rebound_neuron
from circuits.blocks.sonar.rebound_neuron import BIAS_SETS, BURST_BIASES, ROBUST_BIASES, SINGLE_SPIKE_BIASES
from circuits.blocks.sonar.spike_count import count_spikes
from circuits.blocks.sonar.tuning import tuning_machine
from circuits.lowering.kernel import Machine
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.transient import simulate


def machine(biases: Mapping[str, float], number: int | None = None) -> Machine:
    circuit = rebias(rebound_neuron.build(), biases)
    return tuning_machine(circuit, Silicon(AMI_1500_IDEAL, die=Die(number=number, process=False)))


def spikes(biases: Mapping[str, float], **stimuli: float | None) -> int:
    """Spikes in the block's own testbench on the nominal die."""
    values = rebound_neuron.BLOCK.defaults | {"duration": 60e-3} | stimuli
    circuit, silicon = rebias(rebound_neuron.build(), biases), Silicon(AMI_1500_IDEAL)
    bench = rebound_neuron.testbench(circuit, values, silicon.process.v_dd)
    return int(simulate(bench, silicon, rtol=1e-5, record=()).spikes["spike"].size)


# The nominal neuron's number is exact: it does not move with the tolerance.
NOMINAL = {"facts": 1, "robust": 1, "single-spike": 1, "burst": 3}


@pytest.mark.parametrize("name", NOMINAL)
def test_an_echo_at_the_best_delay_makes_one_spike_or_three(name: str) -> None:
    found = count_spikes(machine(BIAS_SETS[name]))
    assert found.spikes == NOMINAL[name]
    assert found.outcome == ("one-spike" if NOMINAL[name] == 1 else "several-spikes")
    assert spikes(BIAS_SETS[name], delay=found.tuning.best_delay) == NOMINAL[name]


@pytest.mark.parametrize("name", NOMINAL)
def test_a_call_alone_and_an_echo_alone_make_none(name: str) -> None:
    assert spikes(BIAS_SETS[name], echo=None) == 0
    assert spikes(BIAS_SETS[name], call=None) == 0


def test_all_keep_the_nominal_best_delay() -> None:
    robust, *others = (count_spikes(machine(b)).tuning for b in (ROBUST_BIASES, *BIAS_SETS.values()))
    for tuning in others:
        assert tuning.best_delay == pytest.approx(robust.best_delay, rel=0.01)  # the search's own bound


def test_only_the_echo_s_current_and_the_inhibition_s_differ_from_the_robust_set() -> None:
    for biases in (SINGLE_SPIKE_BIASES, BURST_BIASES):
        differs = {n for n, value in biases.items() if value != ROBUST_BIASES.get(n)}
        assert differs <= {"i_ex_tau", "i_inh_tau"}
    assert all(set(b) == set(BIAS_SETS["facts"]) for b in BIAS_SETS.values())


@pytest.mark.parametrize("number", [1300, 1301, 1302])
def test_other_dies_do_the_same(number: int) -> None:
    assert count_spikes(machine(SINGLE_SPIKE_BIASES, number)).outcome == "one-spike"
    assert count_spikes(machine(BURST_BIASES, number)).outcome == "several-spikes"


def test_a_neuron_that_does_not_work_has_no_count() -> None:
    found = count_spikes(machine({}, 171))
    assert found.outcome == "never"
    assert math.isnan(found.spikes)
