"""The diode's law: derivatives, the joints of its pieces, charge, temperature, refusals."""

import math
from dataclasses import replace

import numpy as np
import pytest

from circuits.arrays import F64
from circuits.devices.diode import FAR_CURRENT, Diode, DiodeArrays, diode_arrays, diode_currents
from circuits.errors import ParameterError

DIODE = Diode(
    "d", "a", "c", 2.0, 7e-9, 1.8, 10e-12, 0.7, 0.42, 0.5, 100e-9, 6.2, 5e-3, 1.3, 1.06, 5.0, 40.0,
)  # fmt: skip


def arrays(diode: Diode = DIODE, temperature_c: float = 27.0) -> DiodeArrays:
    parameters = {name: np.array([value]) for name, value in diode.parameters().items()}
    return diode_arrays(np.array([[0], [1]]), np.array([0]), parameters, temperature_c)


def evaluate(v: float, at: DiodeArrays) -> F64:
    """Current, A, charge, C, conductance, S, and capacitance, F, at a voltage."""
    current, slope = np.zeros((2, 1)), np.zeros((2, 1))
    diode_currents(at, np.array([v, 0.0]), current, slope)
    return np.concatenate([current[:, 0], slope[:, 0]])


def test_derivatives_are_exact_and_the_pieces_join() -> None:
    at, h = arrays(), 1e-6
    joints = [-3.0 * at.slope[0], -at.breakdown[0], at.bend[0], at.slope[0] * at.highest[0]]
    for v in (-7.0, -6.3, -4.0, -0.2, -0.05, 0.0, 0.3, 0.6, 1.1, 20.0):
        ahead, behind = evaluate(v + h, at), evaluate(v - h, at)
        # error of the difference: h^2 / 6 U^2 of the slope, rounding 1e-16 / h of what it is of
        rounding = 1e-9 * np.abs(evaluate(v, at)[:2])
        assert np.all(
            np.abs((ahead - behind)[:2] / (2 * h) - evaluate(v, at)[2:])
            <= 1e-6 * np.abs(evaluate(v, at)[2:]) + rounding
        )
    for v in joints:
        below, above = evaluate(np.nextafter(v, -9.0), at), evaluate(np.nextafter(v, 9.0), at)
        # at breakdown SPICE leaves out the (3 U / B e)^3 that it has up to there
        np.testing.assert_allclose(below[:2], above[:2], rtol=1e-6)
    assert np.isfinite(evaluate(1e3, at)).all()
    assert np.isfinite(evaluate(-1e3, at)).all()


def test_a_diode_carries_ibv_at_bv_and_no_more_than_a_tangent_far_out() -> None:
    at = arrays()
    wanted = 5e-3 + at.saturation[0] * (1.0 - at.breakdown[0] / 0.0258649)
    assert evaluate(-6.2, at)[0] == pytest.approx(-wanted, rel=1e-8)
    assert evaluate(float(at.slope[0] * at.highest[0]), at)[0] == pytest.approx(FAR_CURRENT, rel=1e-9)
    low = arrays(replace(DIODE, breakdown_current=1e-12))
    assert low.breakdown[0] == 6.2  # below the saturation current, as SPICE has it


def test_saturation_current_and_capacitance_follow_temperature() -> None:
    """At the nominal temperature the figures are as given; silicon's I_S doubles about every 5 K."""
    plain = Diode("d", "a", "c", junction_capacitance=1e-12, junction_potential=0.8)
    here, there = arrays(plain), arrays(plain, 85.0)
    assert here.saturation[0] == pytest.approx(1e-14, rel=1e-12)
    assert here.potential[0] == pytest.approx(0.8, rel=1e-12)
    assert here.capacitance[0] == pytest.approx(1e-12, rel=1e-12)
    ratio = (358.15 / 300.15) ** 3 * math.exp(1.11 / 8.617333e-5 * (1 / 300.15 - 1 / 358.15))
    assert there.saturation[0] / here.saturation[0] == pytest.approx(ratio, rel=1e-6)
    assert there.potential[0] < 0.71
    assert there.capacitance[0] > 1.04e-12
    with pytest.raises(ParameterError, match=r"^diode.junction_potential: -0.\d+ V at 200 degC, must be > 0"):
        arrays(replace(plain, junction_potential=0.3), 200.0)


@pytest.mark.parametrize(
    ("figures", "text"),
    [
        ({"saturation_current": 0.0}, "d.saturation_current: 0 A, must be > 0"),
        ({"junction_capacitance": -1e-12}, "d.junction_capacitance: -1e-12 F, must be >= 0"),
        ({"grading": 0.9}, "d.grading: 0.9, must be below 0.9"),
        ({"emission": math.nan}, "d.emission: nan, must be > 0"),
        ({"transit_time": "1ns"}, "d.transit_time: '1ns', must be a number in s"),
        ({"junction_potential": 2.5}, "d.junction_potential: 2.5 V, must be at most 1 V / forward_coeff"),
    ],
)
def test_figures_outside_of_the_law_are_refused(figures: dict[str, float], text: str) -> None:
    with pytest.raises(ParameterError, match=f"^{text}") as caught:
        Diode("d", "a", "c", **figures)
    assert "\n" not in str(caught.value)
