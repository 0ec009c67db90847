"""A pulse is as long as the charge between the supply and its end over the current."""

import pytest

from circuits.bias import rebias
from circuits.blocks.bench.bias import MASTERS, code_current
from circuits.blocks.bench.pulse_extender import BLOCK, Params
from circuits.errors import ParameterError
from circuits.silicon.process import ROLLS_180, ROLLS_180_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.transient import Result, simulate

SIZES = Params()


def run(fine: int, params: Params = SIZES, **knobs: float) -> Result:
    circuit = rebias(BLOCK.build(params), {"i_tau": code_current(MASTERS[0], fine, 4.0, 4.0)})
    return simulate(BLOCK.bench(circuit, **knobs), Silicon(ROLLS_180_IDEAL))


@pytest.mark.parametrize("fine", [6, 14])
def test_the_width_is_the_charge_over_the_current(fine: int) -> None:
    found = BLOCK.measures(run(fine, duration=0.3))
    current = code_current(MASTERS[0], fine, 4.0, 4.0)
    # m3 is a square that is off, and gives 0.5 pA back; gates of 0.5 um add a percent to C_ext
    assert found["discharge_V_per_s"] == pytest.approx((current - 0.5e-12) / 0.40e-12, rel=0.03)
    closed = (1.8 - found["end_V"]) / found["discharge_V_per_s"]
    assert found["pulse_width_s"] == pytest.approx(closed, rel=0.03)


def test_the_diode_lowers_the_end() -> None:
    low = BLOCK.measures(run(14))["end_V"]
    high = BLOCK.measures(run(14, Params(diode_width=200.0)))["end_V"]
    assert low < high - 0.02
    assert high < 0.8


def test_a_run_that_is_too_short_tells() -> None:
    result = run(6, duration=0.05)
    assert BLOCK.outcome(result) == "long"
    assert BLOCK.measures(result)["pulse_width_s"] is None
    assert BLOCK.outcome(simulate(BLOCK.bench(), Silicon(ROLLS_180))) == "pulse"


def test_a_capacitor_of_nothing_is_refused() -> None:
    with pytest.raises(ParameterError, match=r"extender_capacitance: 0 F, must be > 0"):
        Params(extender_capacitance=0.0)
