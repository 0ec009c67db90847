"""The filter is a linear low-pass with a bent output; the line splits about its reference."""

import pytest

from circuits.bias import rebias
from circuits.blocks.nef.synapse import BLOCK, GAIN_CURRENT, REFERENCE, Params, build
from circuits.errors import ParameterError
from circuits.silicon.die import NOMINAL, Die
from circuits.silicon.process import ROLLS_180, ROLLS_180_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.transient import simulate

IDEAL, DEFAULT = Silicon(ROLLS_180_IDEAL), Params()
TRIMMED = 67e-12  # A, of I_th: at it the output's middle is the reference under the full law
POWER = ROLLS_180_IDEAL.p.kappa / ROLLS_180_IDEAL.n.kappa


def measured(
    step: float, silicon: Silicon = IDEAL, i_thr: float = GAIN_CURRENT, params: Params = DEFAULT
) -> dict[str, float]:
    circuit = rebias(build(params), {"i_thr": i_thr})
    bench = BLOCK.testbench(circuit, {"step": step, "duration": 0.04}, ROLLS_180_IDEAL.v_dd)
    result = simulate(bench, silicon)
    found = {name: value for name, value in BLOCK.measures(result).items() if value is not None}
    return found | {"up": float(BLOCK.outcome(result) == "up")}


@pytest.mark.parametrize("step", [-0.5, 0.3, 1.0])
def test_a_step_takes_the_time_constant_and_ends_on_the_bent_curve(step: float) -> None:
    found = measured(step)
    assert found["up"] == float(step > 0.0)
    # S is 48 at the middle, and the output's gate adds to C_syn; strong inversion bends by some per cent more
    share = 1.0 + 1.0 / (48.0 * (1.0 + step))
    assert found["time_constant_s"] == pytest.approx(share * 5.2e-3, rel=0.03)
    assert found["current_A"] / found["middle_A"] == pytest.approx((1.0 + step) ** POWER, rel=0.02)


@pytest.mark.parametrize("step", [-0.4, 0.4])
def test_the_line_takes_the_reference_away(step: float) -> None:
    found = measured(step)
    assert found["middle_A"] == pytest.approx(REFERENCE, rel=0.01)  # the design's I_th
    # what is above goes through one mirror, what is below through two, each off weak inversion by a per cent
    assert found["signal_A"] == pytest.approx(found["current_A"] - REFERENCE, rel=0.03)


@pytest.mark.parametrize("step", [-0.4, 0.4])
@pytest.mark.parametrize("die", [NOMINAL, Die(number=1001, process=False)])
def test_cascodes_keep_the_difference_under_the_full_law(step: float, die: Die) -> None:
    found = measured(step, Silicon(ROLLS_180, die=die), TRIMMED)
    # mirrors of 32 um^2 deviate by 2 % of the reference
    assert found["signal_A"] == pytest.approx(found["current_A"] - REFERENCE, abs=0.05 * REFERENCE)


def test_without_cascodes_the_early_effect_takes_the_difference() -> None:
    full, plain = Silicon(ROLLS_180), Params(cascode_width=0.0)
    off = [measured(0.1, full, TRIMMED, p) for p in (DEFAULT, plain)]
    above = [found["current_A"] - REFERENCE for found in off]
    assert off[0]["signal_A"] == pytest.approx(above[0], rel=0.03)
    assert off[1]["signal_A"] < 0.5 * above[1]
    # under the ideal law either line is as good
    assert measured(0.4, params=plain)["signal_A"] == pytest.approx(measured(0.4)["signal_A"], rel=1e-3)


def test_values_that_cannot_be_are_refused() -> None:
    with pytest.raises(ParameterError, match=r"step: -1, must be above -1"):
        BLOCK.testbench(build(), {"step": -1.0, "duration": 0.01}, 1.8)
    with pytest.raises(ParameterError, match=r"synapse_capacitance: 0 F, must be > 0"):
        Params(synapse_capacitance=0.0)
