"""The operational amplifier: derivatives, rails, conservation of current, the unpowered state."""

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from circuits.arrays import F64
from circuits.devices.operational_amplifier import OperationalAmplifier, amplifier_currents
from circuits.errors import ParameterError

GAIN, RESISTANCE = 40.0, 100.0


def evaluate(v: F64, gain: float = GAIN, offset: float = 0.0) -> tuple[F64, F64]:
    """Currents into (positive, negative, output, vdd, vss), A, and their derivatives, S."""
    terminal = np.arange(5, dtype=np.int32)[:, None]
    current, slope = np.zeros((5, 1)), np.zeros((5, 5, 1))
    amplifier_currents(terminal, np.array([[gain], [RESISTANCE], [offset]]), v, current, slope)
    return current[:, 0], slope[:, :, 0]


def test_derivatives_are_exact() -> None:
    # Richardson's differences, h = 0.1 mV: error (h A / headroom)^4 / 5, below 2e-9 of the largest slope
    rng = np.random.default_rng(5)
    h = 1e-4
    for _ in range(100):
        v = np.array([*rng.uniform(2.0, 2.2, 2), *rng.uniform(0.0, 5.0, 1), 5.0, rng.uniform(-1.0, 0.5)])
        _, slope = evaluate(v)
        for j in range(5):
            numeric = np.zeros(5)
            for step, weight in ((1, 8), (-1, -8), (2, -1), (-2, 1)):
                moved = v.copy()
                moved[j] += step * h
                numeric += weight * evaluate(moved)[0] / (12 * h)
            assert np.abs(numeric - slope[:, j]).max() <= 1e-7 * np.abs(slope).max()


@given(st.lists(st.floats(min_value=-5.0, max_value=5.0), min_size=5, max_size=5))
@example([0.0, 0.0, 0.0, 0.0, 2.2250738585e-313])
def test_what_flows_in_flows_out(voltages: list[float]) -> None:
    current, slope = evaluate(np.array(voltages))
    assert np.isfinite(current).all()
    assert np.isfinite(slope).all()
    assert abs(current.sum()) <= 1e-15 * np.abs(current).max() * 10
    # only differences of voltages matter, and no current enters the inputs; rounding is 1e-16 of the slopes
    scale = np.abs(slope).max()
    assert np.abs(slope.sum(axis=0)).max() <= 1e-14 * scale
    if voltages[3] - voltages[4] > 1e-3:
        assert np.abs(slope.sum(axis=1)).max() <= 1e-12 * scale
    assert (current[:2] == 0.0).all()


def test_gain_offset_and_rails() -> None:
    def open_output(difference: float, offset: float = 0.0) -> float:
        v = np.array([2.5 + difference, 2.5, 0.0, 5.0, 0.0])
        return float(-evaluate(v, offset=offset)[0][2] * RESISTANCE)  # v_out is 0, so all of v_t drops

    assert open_output(0.0) == pytest.approx(2.5, rel=1e-14)
    assert open_output(1e-4) - 2.5 == pytest.approx(GAIN * 1e-4, rel=1e-6)  # tanh x = x - x^3 / 3, x = 1.6e-3
    assert open_output(0.0, offset=1e-4) == pytest.approx(open_output(1e-4), rel=1e-12)
    assert open_output(1.0) == pytest.approx(5.0, rel=1e-12)  # tanh 16 is 1 within 1e-13
    assert open_output(-1.0) == pytest.approx(0.0, abs=1e-12)


def test_the_supply_on_the_output_s_side_carries_its_current() -> None:
    sourcing, _ = evaluate(np.array([3.5, 2.5, 4.0, 5.0, 0.0]))
    assert sourcing[2] == pytest.approx(-1.0 / RESISTANCE)  # 5 V into 4 V
    assert sourcing[3] == pytest.approx(1.0 / RESISTANCE)
    assert sourcing[4] == pytest.approx(0.0, abs=1e-9)
    sinking, _ = evaluate(np.array([1.5, 2.5, 1.0, 5.0, 0.0]))
    assert sinking[4] == pytest.approx(-1.0 / RESISTANCE)
    assert sinking[3] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("supply", [0.0, -3.0])
def test_unpowered_it_stays_finite(supply: float) -> None:
    current, slope = evaluate(np.array([1.0, 0.0, 0.5, supply, 0.0]))
    assert np.isfinite(current).all()
    assert np.isfinite(slope).all()
    assert current[2] == pytest.approx((0.5 - 0.5 * supply) / RESISTANCE, rel=1e-5)  # 1 uV of headroom


@pytest.mark.parametrize("bad", [{"gain": 0.0}, {"output_resistance": -1.0}, {"offset": float("nan")}])
def test_bad_parameters_are_named(bad: dict[str, float]) -> None:
    with pytest.raises(ParameterError, match=rf"a1\.{next(iter(bad))}: "):
        OperationalAmplifier("a1", "p", "n", "o", "vdd", "0", **bad).check()
