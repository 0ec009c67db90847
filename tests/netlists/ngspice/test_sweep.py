"""Sweeps in ngspice against the native solver's: a five-transistor amplifier, a Schmitt trigger, currents."""

from typing import Any

import numpy as np
import pytest
import xarray as xr

from circuits.silicon.die import Die
from circuits.silicon.process import ROLLS_180
from circuits.silicon.silicon import Silicon
from circuits.sweep.axis import Way
from circuits.sweep.sweep import Plan, run_points
from circuits.testbench import Testbench
from netlists.ngspice.sweep import solve_line
from tests.circuits.sweep.amplifier import amplifier
from tests.circuits.sweep.test_sweep import ladder, schmitt

pytestmark = pytest.mark.usefixtures("ngspice_library")


def both(
    bench: Testbench, over: dict[str, Any], silicon: Silicon, way: Way = "up"
) -> tuple[xr.Dataset, xr.Dataset]:
    """By the native solver and by ngspice."""
    plan = Plan(lambda: bench, {}, over, silicon, way=way)
    return run_points(plan), run_points(Plan(lambda: bench, {}, over, silicon, way=way, solve=solve_line))


@pytest.mark.parametrize("celsius", [-20.0, 27.0, 85.0])
def test_an_amplifier_has_the_curve_that_ngspice_finds(celsius: float) -> None:
    silicon = Silicon(ROLLS_180, temperature_c=celsius, die=Die(number=1000))
    ours, theirs = both(amplifier(), {"plus": np.linspace(0.7, 1.1, 101), "vb": [0.3, 0.4]}, silicon)
    # ngspice ends an iteration below vntol = 1 uV, and 1e-15 S from every node to ground stays
    np.testing.assert_allclose(ours.voltage, theirs.voltage, atol=5e-6)
    supply = {"device": "vdd"}
    np.testing.assert_allclose(ours.current.sel(supply), theirs.current.sel(supply), rtol=1e-4, atol=2e-15)


def test_hysteresis_is_that_of_ngspice() -> None:
    ours, theirs = both(schmitt(), {"a": np.linspace(0.0, 5.0, 101)}, Silicon(), "both")
    np.testing.assert_allclose(ours.voltage, theirs.voltage, atol=1e-5)
    assert float(abs(ours.voltage.sel(direction="up") - ours.voltage.sel(direction="down")).max()) > 4.0


def test_values_that_are_not_even_are_solved_one_by_one() -> None:
    ours, theirs = both(ladder(), {"i": [1e-6, 1e-5, 1e-3], "a": [0.0, 1.0]}, Silicon())
    np.testing.assert_allclose(ours.voltage, theirs.voltage, rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(
        ours.current.sel(device=["a", "i"]), theirs.current.sel(device=["a", "i"]), rtol=1e-6, atol=1e-12
    )
