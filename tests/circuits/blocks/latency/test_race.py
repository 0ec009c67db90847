"""Equation (10) by the circuit, and the recurrent inhibition that ends a race."""

import pytest

from circuits.blocks.latency.race import BLOCK, Params, build
from circuits.errors import ParameterError
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.transient import simulate

DEFAULTS: dict[str, float | None] = {s.name: None for s in BLOCK.stimuli}
CHARGE = 10e-12 * 2.0  # C_mem V_ref, C
PASSIVE, Q, INHIBITION = 345e-12, 800e-12 * 2e-3, 100e-12  # A, C, A


def latency(**stimuli: float) -> float | None:
    return BLOCK.measures(
        simulate(BLOCK.testbench(build(), DEFAULTS | stimuli, 5.0), Silicon(AMI_1500_IDEAL))
    )["latency_s"]


@pytest.mark.parametrize(
    ("excited", "inhibited"),
    [((), ()), ((5e-3,), ()), ((5e-3, 10e-3), (20e-3,)), ((5e-3, 10e-3), (15e-3, 40e-3)), ((), (30e-3,))],
)
def test_the_latency_is_that_of_equation_10(excited: tuple[float, ...], inhibited: tuple[float, ...]) -> None:
    stimuli = dict(zip(("goal", "direction"), excited, strict=False)) | dict(
        zip(("first", "second"), inhibited, strict=False)
    )
    charge = CHARGE - Q * len(excited) + INHIBITION * -sum(inhibited)
    expected = charge / (PASSIVE - INHIBITION * len(inhibited))
    # the requirement; parasitics of the membrane are 1 % of it
    assert latency(**stimuli) == pytest.approx(expected, rel=0.02)


def test_a_stopped_cell_starts_anew_and_too_much_inhibition_stops_it_for_long() -> None:
    assert latency(stop=40e-3) is None  # it would need 58 ms from there on, and the run ends at 90
    again = latency(stop=20e-3)
    assert again == pytest.approx(20e-3 + CHARGE / PASSIVE, rel=0.02)
    assert latency(first=0.0, second=0.0) is None  # 138 ms by the equation


def test_sizes_that_cannot_be_are_refused() -> None:
    with pytest.raises(ParameterError, match=r"timer_capacitance: 0 F, must be > 0"):
        Params(timer_capacitance=0.0)
