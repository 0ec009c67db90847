"""Slopes by the deviations of devices."""

import numpy as np
import pytest

from chips.measured.perturbation import deviations_of, slopes


def test_both_deviations_of_each_device_are_named() -> None:
    assert deviations_of(("m1", "n")) == ("m1.v_t0", "m1.beta", "n.v_t0", "n.beta")


def test_slopes_are_central_differences_with_the_step_of_their_kind() -> None:
    asked: list[tuple[str, float]] = []

    def value(parameter: str, amount: float) -> float:
        asked.append((parameter, amount))
        return {"m1.v_t0": 2.0, "m1.beta": -3.0}[parameter] * amount + amount**2

    found = slopes(value, ("m1.v_t0", "m1.beta"), {"v_t0": 1e-3, "beta": 0.1})
    assert found == pytest.approx(np.array([2.0, -3.0]))
    assert [abs(amount) for _, amount in asked] == [1e-3, 1e-3, 0.1, 0.1]
