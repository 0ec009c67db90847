"""The wide-range amplifier reaches both rails, and its gain is what the Early voltage lets it be."""

import pytest

from circuits.blocks.bench.wide_range_transamp import BLOCK, Params
from circuits.errors import ParameterError
from circuits.silicon.process import ROLLS_180
from circuits.silicon.silicon import Silicon
from circuits.solver.transient import simulate

SIZES = Params()


def numbers(params: Params = SIZES, **knobs: float) -> dict[str, float | None]:
    return BLOCK.measures(simulate(BLOCK.bench(BLOCK.build(params), **knobs), Silicon(ROLLS_180)))


@pytest.mark.parametrize("v_minus", [0.4, 0.9, 1.2])
def test_the_output_reaches_both_rails_and_switches_at_the_other_input(v_minus: float) -> None:
    found = numbers(v_minus=v_minus)
    assert found["low_V"] < 0.01
    assert found["high_V"] > 1.79
    assert found["switch_V"] == pytest.approx(v_minus, abs=0.03)  # systematic: unequal drains of the mirrors


def test_the_gain_follows_the_length() -> None:
    short = numbers()["gain"]
    long = numbers(Params(1.0, 2.0, 3.4, 2.0))["gain"]
    # kappa / 2 U_T over 1 / V_E,n + 1 / V_E,p of 1 um: 14 x 2.4 = 34 for equal currents; a step of 5 mV
    # resolves 2 um's twice that
    assert 20.0 < short < 120.0
    assert 1.5 < long / short < 2.3


def test_an_input_beyond_the_supply_is_refused() -> None:
    with pytest.raises(ParameterError, match=r"v_minus: 2 V, must be within 0 V and the supply"):
        numbers(v_minus=2.0)
