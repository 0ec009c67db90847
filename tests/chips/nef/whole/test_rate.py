"""Rates in kernels are those of the formula, and spikes are counted at currents of signals."""

import numpy as np
import pytest

from chips.nef.whole.rate import Law, count_spikes, fill_rates

N = 37
_RANDOM = np.random.default_rng(5)
LEAK, CHARGE = _RANDOM.uniform(0.8, 1.2, N), _RANDOM.uniform(0.01, 0.03, N)
REFRACTORY, RISE = _RANDOM.uniform(1e-3, 3e-3, N), _RANDOM.uniform(0.02, 0.2, N)
BENT = Law(LEAK, CHARGE, REFRACTORY, RISE, 0.05)
STRAIGHT = Law(LEAK, CHARGE, REFRACTORY, np.zeros(N), 0.0)


@pytest.mark.parametrize("law", [BENT, STRAIGHT])
def test_rates_are_those_of_a_current_that_falls(law: Law) -> None:
    current, sunk = _RANDOM.uniform(-1.0, 4.0, (200, N)), _RANDOM.uniform(0.0, 3.0, (200, N))
    current[:, 0] = law.leak[0] + np.linspace(-0.01, 0.2, 200)  # about where it begins to fire
    found = np.empty_like(current)
    fill_rates(law, current, sunk, found)
    rise = law.rise + law.mirrored * sunk
    end = current - law.leak - 0.5 * rise
    over = np.where(end > 0.0, end, 1.0)
    above = np.where(rise > 0.0, rise / np.log1p(np.where(rise > 0.0, rise, 1.0) / over), over)
    expected = np.where(end > 0.0, 1.0 / (law.refractory + law.charge / above), 0.0)
    assert (expected == 0.0).any()
    assert found == pytest.approx(expected, rel=1e-13, abs=0.0)


def test_spikes_are_counted_of_what_signals_draw() -> None:
    standing = np.stack([_RANDOM.uniform(0.0, 2.0, N), _RANDOM.uniform(0.0, 0.5, N)])
    shares = np.array([[0.4, 0.0, 0.0, 0.7], [0.0, 0.2, 0.1, 0.0], [0.0, 0.0, 0.0, 0.0]])
    stages = _RANDOM.normal(size=(4, N))
    phase = _RANDOM.random((3, N))
    counted = phase.copy()
    count_spikes(BENT, standing, shares, stages, 2.0, np.empty((3, N)), counted)
    drawn = shares @ stages
    sunk = standing[1] + shares @ np.maximum(-stages, 0.0)
    rates = np.empty((3, N))
    fill_rates(BENT, standing[0] + drawn, sunk, rates)
    assert (rates > 0.0).any()
    assert counted == pytest.approx(np.floor(2.0 * rates + phase) / 2.0)
