"""The first spike stops the others after a while; what spikes before that wins too; a ping begins anew."""

import pytest

from circuits.bias import rebias
from circuits.blocks.latency.layer import BLOCK, Params, build
from circuits.errors import ParameterError
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.transient import Result, simulate
from tests.refusals import refusals

NONE: dict[str, float | None] = {s.name: None for s in BLOCK.stimuli}
CHARGE, PASSIVE, Q = 10e-12 * 2.0, 345e-12, 800e-12 * 2e-3  # C, A, C
STOP = 5e-12 * 2.0 / 7.3e-9  # s
NOMINAL = Silicon(AMI_1500_IDEAL)


def run(silicon: Silicon = NOMINAL, **stimuli: float) -> Result:
    circuit = rebias(build(), {}, "ideal")
    return simulate(BLOCK.testbench(circuit, NONE | stimuli, 5.0), silicon)


def test_the_most_excited_cell_wins_and_stops_the_others() -> None:
    result = run(excite_0=5e-3, inhibit_1=40e-3)
    found = BLOCK.measures(result)
    # equation (10); parasitics of the membrane are 1 %
    assert found["latency_s"] == pytest.approx((CHARGE - Q) / PASSIVE, rel=0.02)
    # 1.4 % of parasitics on the capacitor of the recurrent inhibition
    assert found["stop_s"] == pytest.approx(STOP, rel=0.025)
    assert BLOCK.outcome(result) == "0"


def test_cells_that_spike_before_the_stop_win_too() -> None:
    # 0.4 ms apart by inhibitions of 100 pA: 40 ms later by I_inh / I_passive of the rest each
    result = run(inhibit_0=56e-3, inhibit_1=55e-3, inhibit_2=20e-3)
    times = [result.spikes[f"spike[{k}]"] for k in range(3)]
    assert [t.size for t in times] == [1, 1, 0]
    assert 0.0 < times[1][0] - times[0][0] < STOP


def test_dies_have_winners_of_their_own() -> None:
    winners = {
        BLOCK.outcome(run(Silicon(AMI_1500_IDEAL, die=Die(number=n)), excite_0=5e-3, excite_1=5e-3))
        for n in range(6)
    }
    assert len(winners) > 1


test_what_cannot_be_built_is_refused = refusals(
    ParameterError,
    lambda sizes: Params(**sizes),
    [
        ({"recurrent_capacitance": 0.0}, "recurrent_capacitance: 0 F, must be > 0"),
        ({"cells": 0}, "cells: 0, must be a whole number from 1 to 64"),
    ],
)
