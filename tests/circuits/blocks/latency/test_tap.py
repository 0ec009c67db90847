"""A tap passes an event on after its time, at other temperatures, kinds of biases and on dies."""

import pytest

from circuits.bias import rebias
from circuits.blocks.latency.tap import BLOCK, Params, build
from circuits.circuit import BiasKind
from circuits.errors import ParameterError
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.transient import Result, simulate
from tests.refusals import refusals

USUAL = 5e-12 * 2.0 / 3.34e-9  # C V / I, s


def run(silicon: Silicon, kind: BiasKind = "gate") -> Result:
    return simulate(BLOCK.testbench(rebias(build(), {}, kind), {"duration": None}, 5.0), silicon)


def test_two_taps_take_twice_as_long() -> None:
    result = run(Silicon(AMI_1500_IDEAL))
    found = BLOCK.measures(result)
    # 1.1 % of parasitics on the timer, and 10 to 14 us of events that hold it
    assert found["delay_s"] == pytest.approx(USUAL * 1.011 + 10e-6, rel=0.01)
    assert found["hop_s"] == pytest.approx(USUAL * 1.011 + 14e-6, rel=0.01)
    # 0.2 pF and its gates from 5 V to an inverter's threshold of 2.2 V, by 50 nA
    assert found["pulse_s"] == pytest.approx(13e-6, rel=0.2)
    assert BLOCK.outcome(result) == "2 taps"


def test_a_generator_holds_the_delay_and_a_fixed_gate_does_not() -> None:
    cold = Silicon(AMI_1500_IDEAL, temperature_c=0.0)
    steady = BLOCK.measures(run(cold, "ideal"))["delay_s"]
    # PTAT: 300.15 / 273.15 as long; the comparator's own delay is below 0.2 %
    assert steady == pytest.approx(USUAL * 1.014 * 300.15 / 273.15, rel=0.01)
    drifted = BLOCK.measures(run(cold))["delay_s"]
    assert drifted is not None
    assert drifted > 2.0 * USUAL


def test_dies_differ() -> None:
    a, b = (
        BLOCK.measures(run(Silicon(AMI_1500_IDEAL, die=Die(number=n)), "ideal"))["delay_s"] for n in (1, 2)
    )
    assert a != b


test_what_cannot_be_built_is_refused = refusals(
    ParameterError,
    lambda sizes: Params(**sizes),
    [
        ({"timer_capacitance": 0.0}, "timer_capacitance: 0 F, must be > 0"),
        ({"taps": 0}, "taps: 0, must be a whole number from 1 to 64"),
    ],
)
