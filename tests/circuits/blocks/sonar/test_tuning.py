"""Tuning of a neuron: its class and edges are converged at the tolerance that is the default."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import pytest

from circuits.blocks.sonar import rebound_neuron
from circuits.blocks.sonar.tuning import (
    RESOLUTION,
    Call,
    NeuronClass,
    Trials,
    rebound_bound,
    search,
    tune,
    tuning_machine,
)
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon


# Nearly grazing dies: at 1e-4 the first edge of 77 is 53 us off, and 171 counts as working.
@pytest.mark.parametrize("number", [77, 171])
def test_grazing_dies_are_converged(number: int) -> None:
    silicon = Silicon(AMI_1500_IDEAL, die=Die(number=number, process=False))
    machine = tuning_machine(rebound_neuron.build(), silicon)
    default, fine = tune(machine), tune(machine, 1e-6)
    assert default.outcome is fine.outcome
    if fine.outcome is NeuronClass.WORKS:
        # both bisected to the resolution
        assert default.first == pytest.approx(fine.first, abs=2.0 * RESOLUTION)
        assert default.last == pytest.approx(fine.last, abs=2.0 * RESOLUTION)


def test_what_does_not_work_has_no_best_delay() -> None:
    silicon = Silicon(AMI_1500_IDEAL, die=Die(number=171, process=False))
    tuning = tune(tuning_machine(rebound_neuron.build(), silicon))
    assert tuning.outcome is not NeuronClass.WORKS
    assert math.isnan(tuning.best_delay)
    assert not math.isnan(tuning.t_inh)


def test_a_slow_rebound_is_waited_for() -> None:
    """The pFETs of this die pass so little I_rtau that its rebound outlasts C_r V_dd / 400 pA, 7.5 ms."""
    machine = tuning_machine(rebound_neuron.build(), Silicon(AMI_1500_IDEAL, die=Die(number=2138)))
    tuning = tune(machine)
    bound = rebound_bound(machine)
    assert tuning.t_reb > 7.5e-3
    assert tuning.t_reb < 0.99 * bound
    assert tuning.last < tuning.t_inh + 0.99 * bound


SILENT = Call(fires=False, t_inh=5e-3, t_reb=2e-3, latest=12e-3)


@dataclass
class Neuron(Trials):
    """An engine that only says what it is told: fires after a call for echoes between two delays."""

    rest: bool = False
    call: Call | None = SILENT
    echo: bool = False
    between: tuple[float, float] = (5.1e-3, 7.3e-3)
    asked: list[float] = field(default_factory=list)

    def fires_at_rest(self, until: float) -> bool:
        return self.rest

    def after_call(self) -> Call | None:
        return self.call

    def fires_after_echo(self, until: float) -> bool:
        return self.echo

    def fires_after_both(self, delay: float, until: float) -> bool:
        self.asked.append(delay)
        return self.between[0] < delay < self.between[1]


@pytest.mark.parametrize(
    ("neuron", "outcome"),
    [
        (Neuron(), NeuronClass.WORKS),
        (Neuron(rest=True, echo=True), NeuronClass.REST_FIRES),
        (Neuron(call=None), NeuronClass.NEVER),
        (Neuron(call=replace(SILENT, fires=True)), NeuronClass.CALL_ALONE),
        (Neuron(echo=True), NeuronClass.ECHO_ALONE),
        (Neuron(between=(6e-3, 6e-3)), NeuronClass.NEVER),
    ],
    ids=["works", "rest", "inhibited", "call", "echo", "never"],
)
def test_any_engine_can_be_searched(neuron: Neuron, outcome: NeuronClass) -> None:
    assert search(neuron).outcome is outcome


@pytest.mark.parametrize("between", [(5.1e-3, 7.3e-3), (5.1e-3, 5.3e-3), (0.0, 1.0)], ids=str)
def test_edges_are_those_of_the_interval(between: tuple[float, float]) -> None:
    neuron = Neuron(between=between)
    tuning = search(neuron)
    # 7 ms before the release that comes after 5 ms is before the call: the scan begins after its pulse
    assert tuning.first == pytest.approx(max(between[0], 30e-6), abs=RESOLUTION)
    assert tuning.last == pytest.approx(min(between[1], 12e-3), abs=RESOLUTION)
    assert all(30e-6 <= delay <= 12e-3 for delay in neuron.asked)
