"""The kernel's laws: gains by the inversion, the time by its own differential equation, a compiled caller."""

import numba
import numpy as np
import pytest

from chips.selection import kernel as k
from chips.selection.model import decision, selection
from circuits.blocks.selection.winner_take_all import CELLS, STANDING
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon


def ekv(u: float) -> float:
    return float(np.logaddexp(0.0, 0.5 * u) ** 2)


@pytest.mark.parametrize("u", [-12.0, -1.0, 3.0, 15.0])
def test_the_inversion_has_the_derivatives_of_the_law(u: float) -> None:
    h, slope = k.inversion(ekv(u))
    step = 1e-3  # central differences: their own error is of the order of its square
    logs = [np.log(ekv(u + x)) for x in (-step, 0.0, step)]
    assert h == pytest.approx((logs[2] - logs[0]) / (2.0 * step), rel=1e-5)
    assert slope == pytest.approx((logs[2] - 2.0 * logs[1] + logs[0]) / step**2, abs=1e-5)
    assert k.inversion(0.0) == (1.0, 0.0)


def test_the_line_is_charged_by_the_excess_of_a_logistic_growth() -> None:
    chip = selection(Silicon(AMI_1500_IDEAL))
    growth = 0.01  # A/s
    found = k._charging(chip, 0, growth)
    x = chip.turn[0] / chip.tail
    pace = growth / (chip.tail * x * (1.0 - x))
    time = np.linspace(0.0, found, 10_001)
    share = 1.0 / (1.0 + (1.0 / x - 1.0) * np.exp(-pace * time))
    charge = chip.out_gain[0] * chip.tail * np.trapezoid(share - x, time)
    assert charge == pytest.approx(chip.line_charge, rel=1e-6)


def test_a_slower_growth_charges_later() -> None:
    chip = selection(Silicon(AMI_1500_IDEAL))
    times = [k._charging(chip, 0, g) for g in (1.0, 1e-2, 1e-4)]
    assert times[0] < times[1] < times[2]


def test_a_compiled_loop_calls_it() -> None:
    @numba.njit
    def winners(chip: k.Selection, excite: np.ndarray, risk: np.ndarray, found: np.ndarray) -> None:
        scratch = np.empty((4, excite.shape[1]))
        for p in range(excite.shape[0]):
            found[p] = k.decide(chip, excite[p], risk, scratch)[0]

    chip = selection(Silicon(AMI_1500_IDEAL, die=Die(number=1000)))
    excite = np.random.default_rng(1).uniform(30e-9, 60e-9, (5, CELLS))
    risk = np.full(CELLS, STANDING)
    found = np.zeros(5, dtype=np.int64)
    winners(chip, excite, risk, found)
    assert found.tolist() == [decision(chip, row, risk).winner for row in excite]
