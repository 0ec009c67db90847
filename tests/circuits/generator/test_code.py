"""Codes are the nearest ones, and say how far off they are."""

import numpy as np
import pytest

from circuits.errors import ParameterError
from circuits.generator.code import COARSE, CODES, codes_of, currents_of, nearest_currents


def test_the_nearest_code_is_near() -> None:
    wanted = np.geomspace(1e-12, 1e-6, 50)
    found = currents_of(codes_of(wanted))
    # ranges are a factor of 8 apart, so that the fine code is at least 31: half a step is 1.6 %
    assert np.abs(found / wanted - 1.0).max() < 0.017
    assert codes_of(np.array(100e-12)).tolist() == [6, 244]
    assert currents_of(codes_of(np.array(1e-17))) == pytest.approx(15e-12 / 256.0)
    with pytest.raises(ParameterError, match=r"bias code: 1 A, must be > 0 and at most"):
        codes_of(np.array([1e-9, 1.0]))


@pytest.mark.parametrize("coarse", range(len(COARSE)))
@pytest.mark.parametrize("fine", [200, 255])
def test_the_code_of_a_code_s_current_is_itself(coarse: int, fine: int) -> None:
    assert codes_of(np.array(COARSE[coarse] * fine / CODES)).tolist() == [coarse, fine]


def test_currents_of_codes_rise_and_are_what_their_own_codes_have() -> None:
    found = nearest_currents()
    assert (np.diff(found) > 0.0).all()
    assert currents_of(codes_of(found)) == pytest.approx(found, rel=1e-15)
    coded = currents_of(codes_of(np.geomspace(1e-12, 20e-6, 200)))
    # but for the code at the foot of a range, which is the top of the finer one
    assert np.abs(coded / found[:, None] - 1.0).min(axis=0).max() < 1e-3
