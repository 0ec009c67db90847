"""A unit stores a coincidence, repeats it at each ping, and forgets it at a reset."""

import pytest

from circuits.bias import rebias
from circuits.blocks.latency.unit import BLOCK, FIRST, PERIOD, Params, build
from circuits.errors import ParameterError
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.transient import Result, simulate

DEFAULTS = BLOCK.defaults
NOMINAL = Silicon(AMI_1500_IDEAL)


def run(silicon: Silicon = NOMINAL, **stimuli: float | None) -> Result:
    return simulate(BLOCK.testbench(rebias(build(), {}, "ideal"), DEFAULTS | stimuli, 5.0), silicon)


@pytest.mark.parametrize("after", [-2.9e-3, 0.0, 2.9e-3])
def test_a_coincidence_is_repeated_at_the_taps_latency_until_the_reset(after: float) -> None:
    result = run(integrating=after)
    spikes = result.spikes["spike"]
    assert spikes.size == 2
    # the sum's node rises within some 15 us
    assert spikes[0] - FIRST == pytest.approx(max(after, 0.0), abs=30e-6)
    assert spikes[1] - FIRST - PERIOD == pytest.approx(0.0, abs=30e-6)
    assert BLOCK.outcome(result) == "remembered"


def test_without_a_reset_it_remembers_on() -> None:
    assert BLOCK.measures(run(reset=None))["recalls"] == 2.0


@pytest.mark.parametrize("after", [None, -3.2e-3, 3.2e-3])
def test_what_does_not_coincide_is_not_stored(after: float | None) -> None:
    assert BLOCK.outcome(run(integrating=after)) == "none"


@pytest.mark.parametrize("number", range(4))
def test_it_works_on_dies_hot_and_cold(number: int) -> None:
    silicon = Silicon(AMI_1500_IDEAL, temperature_c=(0.0, 60.0)[number % 2], die=Die(number=number))
    assert BLOCK.outcome(run(silicon)) == "remembered"


def test_what_cannot_be_is_refused() -> None:
    with pytest.raises(ParameterError, match=r"timer_capacitance: 0 F, must be > 0"):
        Params(timer_capacitance=0.0)
    with pytest.raises(ParameterError, match=r"integrating: -0\.03 s, must be above"):
        run(integrating=-30e-3)
    with pytest.raises(ParameterError, match=r"reset: 0 s, must be > 0 s after"):
        run(reset=0.0)
