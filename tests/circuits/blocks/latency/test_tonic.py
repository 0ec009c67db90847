"""A tonic neuron spikes at its period, is silent for its synapse's time, and begins anew at the end."""

import pytest

from circuits.bias import rebias
from circuits.blocks.latency.tonic import BLOCK, START, Params, build
from circuits.circuit import BiasKind
from circuits.errors import ParameterError
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.transient import Result, simulate

DEFAULTS = BLOCK.defaults
PERIOD, HOLD = 5e-12 * 2.0 / 1e-9, 5e-12 * 2.0 / 57e-12  # s
NOMINAL = Silicon(AMI_1500_IDEAL)


def run(silicon: Silicon = NOMINAL, kind: BiasKind = "gate", **stimuli: float | None) -> Result:
    bench = BLOCK.testbench(rebias(build(), {}, kind), DEFAULTS | stimuli, 5.0)
    return simulate(bench, silicon)


def test_it_spikes_at_its_period_until_it_is_inhibited() -> None:
    found = BLOCK.measures(run(inhibit=None, duration=60e-3))
    # parasitics of the membrane, its four transistors, are 1.6 %
    assert found["period_s"] == pytest.approx(PERIOD, rel=0.025)
    result = run()
    found = BLOCK.measures(result)
    assert found["hold_s"] == pytest.approx(HOLD, rel=0.02)  # 1.1 % of parasitics
    # the period is between the last spike before and the event: at 10 of 15 ms
    assert found["silence_s"] == pytest.approx(HOLD + PERIOD + 5e-3, rel=0.02)
    assert BLOCK.outcome(result) == "tonic"


def test_an_end_makes_it_spike_a_period_later() -> None:
    spikes = run(inhibit=15e-3, end=50e-3, duration=70e-3).spikes["spike"]
    # from the end of an event of 10 us
    assert spikes[1] - START - 50e-3 == pytest.approx(PERIOD, rel=0.025)


def test_a_generator_holds_the_time_within_what_is_absolute_temperature() -> None:
    warm = Silicon(AMI_1500_IDEAL, temperature_c=60.0)
    assert BLOCK.measures(run(warm, "ideal"))["hold_s"] == pytest.approx(HOLD * 300.15 / 333.15, rel=0.02)
    drifted = BLOCK.measures(run(warm))["hold_s"]
    assert drifted is not None
    assert drifted < 0.5 * HOLD


def test_dies_differ() -> None:
    a, b = (
        BLOCK.measures(run(Silicon(AMI_1500_IDEAL, die=Die(number=n)), "ideal"))["hold_s"] for n in (1, 2)
    )
    assert a != b


def test_what_cannot_be_is_refused() -> None:
    with pytest.raises(ParameterError, match=r"membrane_capacitance: -1 F, must be > 0"):
        Params(membrane_capacitance=-1.0)
    with pytest.raises(ParameterError, match=r"end: 1e-05 s, must be after the start's event"):
        run(end=10e-6)
