"""Each metric on measurements that are there, and on curves whose numbers are known."""

from __future__ import annotations

import math

import numpy as np
import pytest

from circuits.errors import DataError
from circuits.extraction.coach.conditions import read_conditions
from circuits.extraction.coach.metrics import RELATIVE, U_T, metrics_of
from circuits.extraction.coach.table import Table, read_folder

CONDITIONS = read_conditions()
FIT = read_folder(None, "fit")


# what the notes of who collected the measurements read off the same files, and how far the reading may differ
NOTED = (
    ("ndp_run1", "kappa", 0.747, 0.003), ("ndp_run1", "offset_V", 8.1e-3, 1e-4),
    ("ndp_run1", "sum_at_balance_A", 5.86e-9, 6e-11), ("foi_step_small", "tau_s", 273e-6, 30e-6),
    ("dpi_base", "ramp_V_per_sample", 0.193, 0.004), ("dpi_base", "minimum_V", 1.320, 1e-3),
    ("dpi_base", "rest_V", 1.773, 1e-3), ("ahn_pw2", "jump_up_V", 0.344, 1e-3),
    ("ahn_pw2", "jump_down_V", -0.40, 5e-3), ("ahn_pw2", "threshold_up_V", 0.888, 1e-3),
    ("ahn_pw2", "threshold_down_V", 0.92, 5e-3), ("ahn_pw2", "rise_V_per_s", 0.387, 5e-3),
    ("ahn_pw2", "fall_V_per_s", -0.693, 5e-3), ("acn_dc10", "isi_samples", 53.11, 0.01),
)  # fmt: skip


@pytest.mark.parametrize(("name", "metric", "value", "within"), NOTED)
def test_metrics_of_the_fit_set_are_those_that_were_noted(
    name: str, metric: str, value: float, within: float
) -> None:
    assert metrics_of(*FIT[name])[metric].value == pytest.approx(value, abs=within)


def test_a_pair_of_known_kappa_and_offset() -> None:
    dv = np.linspace(-0.14, 0.14, 57)
    share = 1.0 / (1.0 + np.exp(-0.7 * (dv - 0.004) / U_T))
    table = Table(v1_V=0.9 + dv / 2, v2_V=0.9 - dv / 2, i1_A=5e-9 * share, i2_A=5e-9 * (1 - share))
    found = metrics_of(CONDITIONS["ndp_run3"], table)
    assert found["kappa"].value == pytest.approx(0.7, abs=1e-9)
    assert found["offset_V"].value == pytest.approx(4e-3, abs=1e-9)


def test_a_switch_point_is_what_lies_between_two_points() -> None:
    v1 = np.linspace(0.0, 1.75, 36)
    out = np.where(v1 < 0.9, 0.7 * v1, 1.78)
    found = metrics_of(CONDITIONS["nta_vout_2"], Table(v1_V=v1, v_out_V=out))
    assert found["slope"].value == pytest.approx(0.7)
    assert found["level_V"].value == pytest.approx(0.42)
    assert (found["jump_V"].low, found["jump_V"].high) == pytest.approx((0.85, 0.90))


def test_the_ring_switches_both_ways_and_its_width_has_its_own_interval() -> None:
    down = np.linspace(1.75, 1.55, 25)
    v = np.concatenate([down, down[::-1]])
    wins = np.concatenate([down < 1.64, down[::-1] < 1.66])
    table = Table(
        v_in0_V=v, v_out0_V=np.where(wins, 1.2, 0.2), v_out1_V=np.where(wins, 0.1, 1.1),
        n_iout0_counts=wins * 100.0, n_iout1_counts=~wins * 100.0,
    )  # fmt: skip
    found = metrics_of(CONDITIONS["wta_basic"], table)
    assert found["switch_down_V"].low < 1.64 < found["switch_down_V"].high
    assert found["switch_up_V"].low < 1.66 < found["switch_up_V"].high
    assert found["width_V"].low < 0.02 < found["width_V"].high
    assert (found["winner_0_V"].value, found["loser_0_V"].value) == (1.2, 0.2)
    assert (found["winner_1_V"].value, found["loser_1_V"].value) == (1.1, 0.1)


def test_a_sine_has_its_gain_and_phase() -> None:
    phase = np.arange(252) * 0.1
    table = Table(
        phase_rad=phase, v_in_V=0.9 + 0.1 * np.sin(phase), v_out_V=0.9 + 0.095 * np.sin(phase - 0.03)
    )
    found = metrics_of(CONDITIONS["foi_sine_slow"], table)
    assert found["gain"].value == pytest.approx(0.95)
    assert found["phase_rad"].value == pytest.approx(-0.03)


def test_a_bump_has_its_centre_width_and_share() -> None:
    dv = np.linspace(-0.5, 0.5, 100)
    inside = 1.0 / (1.0 + 0.25 * np.cosh((dv - 0.01) / 0.05) ** 2)
    side = 1.0 / (1.0 + np.exp((dv - 0.01) / 0.03))
    table = Table(
        v1_V=0.9 + dv / 2, v2_V=0.9 - dv / 2, nout_counts=3000 * inside, n1_counts=900.0 * (1.0 - side),
        n2_counts=900.0 * side, iout_A=4e-9 * inside, i1_A=4e-9 * (1 - inside) * (1 - side),
        i2_A=4e-9 * (1 - inside) * side,
    )  # fmt: skip
    found = metrics_of(CONDITIONS["bab_runA"], table)
    assert found["centre_V"].value == pytest.approx(0.01, abs=1e-3)
    # half the height is where cosh^2 is 6
    assert found["width_V"].value == pytest.approx(0.1 * math.acosh(math.sqrt(6.0)), abs=4e-3)
    assert found["peak_fraction"].value == pytest.approx(0.79, abs=0.02)


def test_a_neuron_has_its_interval_and_its_time_at_reset() -> None:
    one = np.concatenate([np.full(3, 0.01), np.linspace(0.2, 0.65, 22)])
    found = metrics_of(CONDITIONS["acn_dc32"], Table(t_nominal_s=np.arange(500.0), v_mem_V=np.tile(one, 20)))
    assert found["isi_samples"].value == pytest.approx(25.0)
    assert found["held_samples"].value == pytest.approx(3.0)


def test_a_curve_without_a_switch_has_none_and_an_empty_one_is_refused() -> None:
    v = np.linspace(1.75, 1.55, 50)
    flat = Table(
        v_in0_V=v, v_out0_V=np.ones(50), v_out1_V=np.zeros(50), n_iout0_counts=np.ones(50),
        n_iout1_counts=np.ones(50),
    )  # fmt: skip
    assert math.isnan(metrics_of(CONDITIONS["wta_basic"], flat)["switch_down_V"].value)
    blank = read_folder(None, "predict")["nta_vout_1"]
    with pytest.raises(DataError, match="no measured values"):
        metrics_of(*blank)


def test_numbers_that_are_put_in_relation_are_of_files_that_there_are() -> None:
    for name, _, other, how in RELATIVE:
        assert {name, other} <= set(CONDITIONS)
        assert how in ("ratio", "shift")
        assert CONDITIONS[name].circuit == CONDITIONS[other].circuit
