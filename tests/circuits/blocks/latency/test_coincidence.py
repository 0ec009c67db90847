"""Two of three within 3 ms make a spike, and nothing else does."""

import pytest

from circuits.blocks.latency.coincidence import BLOCK, Params, build
from circuits.errors import ParameterError
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.transient import Result, simulate

DEFAULTS = BLOCK.defaults


def run(die: int | None = None, **stimuli: float | None) -> Result:
    return simulate(
        BLOCK.testbench(build(), DEFAULTS | stimuli, 5.0), Silicon(AMI_1500_IDEAL, die=Die(number=die))
    )


@pytest.mark.parametrize(
    ("second", "third", "spikes"),
    [
        (None, None, 0),
        (0.0, None, 1),
        (2.95e-3, None, 1),
        (3.05e-3, None, 0),
        (None, 1e-3, 1),
        (4e-3, 6e-3, 1),  # of the second and third
        (3.5e-3, 7e-3, 0),
        (1e-3, 2e-3, 1),  # one spike of all three
    ],
)
def test_two_of_three_within_the_window_spike(second: float | None, third: float | None, spikes: int) -> None:
    assert run(second=second, third=third).spikes["spike"].size == spikes


def test_the_spike_comes_with_the_second_input() -> None:
    found = BLOCK.measures(run(second=2e-3))
    # its node is charged within some 15 us
    assert found["latency_s"] == pytest.approx(2e-3, abs=30e-6)
    # the timer's parasitics are 1 %
    assert found["window_s"] == pytest.approx(3e-3, rel=0.02)
    assert BLOCK.outcome(run(second=None)) == "none"


def test_dies_have_windows_of_their_own() -> None:
    windows = [BLOCK.measures(run(die))["window_s"] for die in (1, 2)]
    assert windows[0] != windows[1]


def test_sizes_that_cannot_be_are_refused() -> None:
    with pytest.raises(ParameterError, match=r"sum_capacitance: -1 F, must be > 0"):
        Params(sum_capacitance=-1.0)
