"""The filter is a linear low-pass with a bent output; the line splits about its reference."""

import pytest

from circuits.blocks.nef.synapse import BLOCK, REFERENCE, Params, build
from circuits.errors import ParameterError
from circuits.silicon.process import ROLLS_180
from circuits.silicon.silicon import Silicon
from circuits.solver.transient import simulate

POWER = ROLLS_180.p.kappa / ROLLS_180.n.kappa


def measured(step: float) -> dict[str, float]:
    bench = BLOCK.testbench(build(), {"step": step, "duration": 0.04}, ROLLS_180.v_dd)
    result = simulate(bench, Silicon(ROLLS_180))
    found = {name: value for name, value in BLOCK.measures(result).items() if value is not None}
    return found | {"up": float(BLOCK.outcome(result) == "up")}


@pytest.mark.parametrize("step", [-0.5, 0.3, 1.0])
def test_a_step_takes_the_time_constant_and_ends_on_the_bent_curve(step: float) -> None:
    found = measured(step)
    assert found["up"] == float(step > 0.0)
    # 5 ms, and 1 / S = 0.4 %; strong inversion of output and pair at the middle bends by a per cent more
    assert found["time_constant_s"] == pytest.approx(5.1e-3, rel=0.03)
    assert found["current_A"] / found["middle_A"] == pytest.approx((1.0 + step) ** POWER, rel=0.02)


@pytest.mark.parametrize("step", [-0.4, 0.4])
def test_the_line_takes_the_reference_away(step: float) -> None:
    found = measured(step)
    assert found["middle_A"] == pytest.approx(REFERENCE, rel=0.01)  # the design's I_th
    # what is above goes through one mirror, what is below through two, each off weak inversion by a per cent
    assert found["signal_A"] == pytest.approx(found["current_A"] - REFERENCE, rel=0.03)


def test_values_that_cannot_be_are_refused() -> None:
    with pytest.raises(ParameterError, match=r"step: -1, must be above -1"):
        BLOCK.testbench(build(), {"step": -1.0, "duration": 0.01}, 1.8)
    with pytest.raises(ParameterError, match=r"synapse_capacitance: 0 F, must be > 0"):
        Params(synapse_capacitance=0.0)
