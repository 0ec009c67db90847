"""Codes of the ROLLS biases."""

from __future__ import annotations

import pytest

from circuits.blocks.rolls.bias import DEFAULT_CODES, OFF_CURRENT, current_of, default_current
from circuits.errors import ParameterError, UnknownNameError


def test_current_is_the_coarse_one_in_256_parts() -> None:
    # facts/ROLLS: IF_TAU1_N = 15 pA * 40 / 256 = 2.34 pA, IF_TAU2_N = 820 pA * 20 / 256 = 64 pA
    assert default_current("IF_TAU1_N") == pytest.approx(2.34e-12, rel=2e-3)
    assert default_current("IF_TAU2_N") == pytest.approx(64e-12, rel=2e-3)
    assert current_of((0, 255)) == pytest.approx(24e-6 * 255 / 256)


def test_code_zero_is_below_every_other_current() -> None:
    assert default_current("IF_AHW_P") == OFF_CURRENT
    assert min(current_of((c, f)) for c in range(8) for f in range(256)) == OFF_CURRENT
    assert len({current_of((7, f)) for f in range(1, 256)}) == 255


@pytest.mark.parametrize("code", [(8, 0), (-1, 3), (0, 256), (0, -1)])
def test_code_that_the_generator_does_not_have(code: tuple[int, int]) -> None:
    with pytest.raises(ParameterError, match="coarse 0 to 7 and fine 0 to 255"):
        current_of(code)


def test_unknown_bias_is_named() -> None:
    assert "IF_RST_N" not in DEFAULT_CODES
    with pytest.raises(UnknownNameError, match="IF_RST_N"):
        default_current("IF_RST_N")
