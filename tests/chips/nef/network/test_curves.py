"""Ideal tuning curves: the formula's limits, and their inverse."""

from __future__ import annotations

import math

import numpy as np
import pytest

from chips.nef.network.curves import TAU_RC, TAU_REF, IdealCurves

CURVES = IdealCurves()


def test_rates() -> None:
    found = CURVES.rates(0, np.array([[-1.0, 0.5, 1.0, 2.0, 1e9]]))
    assert found[0, :3].tolist() == [0.0, 0.0, 0.0]
    assert found[0, 3] == pytest.approx(1.0 / (TAU_REF + TAU_RC * math.log(2.0)))
    assert found[0, 4] == pytest.approx(1.0 / TAU_REF, rel=1e-6)  # 1 / J is left of the membrane's time


def test_currents_are_the_inverse() -> None:
    rate = np.array([10.0, 50.0, 200.0, 400.0])
    # rounding, amplified where 1 / J is small
    assert CURVES.rates(0, CURVES.currents(0, rate)[None])[0] == pytest.approx(rate, rel=1e-9)
    assert CURVES.currents(0, np.zeros(1)).tolist() == [1.0]


def test_no_current_beats_the_refractory_period() -> None:
    assert np.isnan(CURVES.currents(0, np.array([1.01 / TAU_REF]))).all()
