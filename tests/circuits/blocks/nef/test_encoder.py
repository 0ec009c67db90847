"""Codes weigh the signal, the sign turns it, the other bank counts against it."""

import pytest

from circuits.blocks.nef.encoder import BLOCK, UNIT, Params, bits_of, build
from circuits.errors import ParameterError
from circuits.silicon.die import NOMINAL, Die
from circuits.silicon.process import ROLLS_180_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.transient import simulate


def current(code: float, die: Die = NOMINAL, temperature: float = 27.0) -> float:
    bench = BLOCK.testbench(build(), {"code": code, "step": None}, ROLLS_180_IDEAL.v_dd)
    found = BLOCK.measures(simulate(bench, Silicon(ROLLS_180_IDEAL, temperature, die)))["current_A"]
    assert found is not None
    return found


@pytest.mark.parametrize("code", [1.0, 2.0, 50.0, 255.0, -3.0, -255.0])
def test_the_current_is_the_codes(code: float) -> None:
    # the signal's bank at its unit, the other at a twentieth of it; switches that are off leak 1e-4 of that
    assert current(code) == pytest.approx(0.95 * code * UNIT, rel=2e-3)


def test_nothing_for_code_0_and_a_word_for_each() -> None:
    assert abs(current(0.0)) < 0.01 * UNIT
    bench = BLOCK.testbench(build(), {"code": -7.0, "step": None}, ROLLS_180_IDEAL.v_dd)
    assert BLOCK.outcome(simulate(bench, Silicon(ROLLS_180_IDEAL))) == "sink"


def test_mismatch_falls_with_the_number_of_units() -> None:
    dies = [Die(number=k, process=False) for k in range(1000, 1012)]
    spread = []
    for code in (1.0, 128.0):
        shares = [current(code, die) / (0.95 * code * UNIT) - 1.0 for die in dies]
        spread.append((sum(s * s for s in shares) / len(shares)) ** 0.5)
    assert 0.03 < spread[0] < 0.2  # one device of 1 um^2: 8 %
    assert spread[1] < 0.4 * spread[0]  # 128 of them: a tenth, on twelve dies


def test_codes_that_cannot_be() -> None:
    with pytest.raises(ParameterError, match=r"code: 256, must be a whole number from -255 to 255"):
        bits_of(256.0, 1.8)
    with pytest.raises(ParameterError, match=r"unit_width: 0 um, must be > 0"):
        Params(unit_width=0.0)
