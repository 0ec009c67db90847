"""The bump has the height, the width and the place of its closed form."""

import math

import pytest

from circuits.bias import rebias
from circuits.blocks.bench.bump_antibump import BLOCK, Params
from circuits.errors import ParameterError
from circuits.silicon.process import ROLLS_180, ROLLS_180_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.transient import simulate

SIZES = Params()


def numbers(params: Params = SIZES, tail: float = 0.5e-9) -> dict[str, float | None]:
    weak = rebias(BLOCK.build(params), {"i_tail": tail})  # in weak inversion, as the closed form asks
    return BLOCK.measures(simulate(BLOCK.bench(weak), Silicon(ROLLS_180_IDEAL)))


@pytest.mark.parametrize("ratio", [4.0, 16.0])
def test_height_and_width_are_those_of_the_closed_form(ratio: float) -> None:
    found = numbers(Params(middle_width=ratio))
    assert found["peak_share"] == pytest.approx(1.0 / (1.0 + 4.0 / ratio), rel=0.01)
    u_t, kappa = Silicon(ROLLS_180_IDEAL).thermal_voltage, ROLLS_180.n.kappa
    width = 4.0 * u_t / kappa * math.acosh(math.sqrt(2.0 + 0.25 * ratio))
    assert found["width_V"] == pytest.approx(width, rel=0.02)  # and the tail's share of the slope
    assert found["centre_V"] == pytest.approx(0.0, abs=1e-4)
    assert found["tail_A"] == pytest.approx(0.5e-9, rel=0.02)


def test_a_narrow_sweep_shows_a_flank_or_nothing() -> None:
    result = simulate(BLOCK.bench(span=0.02), Silicon(ROLLS_180))
    assert BLOCK.outcome(result) == "flank"
    assert BLOCK.measures(result)["width_V"] is None
    assert BLOCK.outcome(simulate(BLOCK.bench(), Silicon(ROLLS_180))) == "bump"


def test_what_leaves_the_supply_is_refused() -> None:
    with pytest.raises(ParameterError, match=r"out: 2.5 V, must be within 0 V and the supply of 1.8 V"):
        BLOCK.bench(out=2.5)
    with pytest.raises(ParameterError, match=r"middle_width: 0 um, must be > 0"):
        Params(middle_width=0.0)
