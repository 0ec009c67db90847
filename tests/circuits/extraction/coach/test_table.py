"""Measurements are read with their columns, and what is none is refused with its file and line."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from circuits.errors import DataError
from circuits.extraction.coach.conditions import read_conditions
from circuits.extraction.coach.table import columns_of, format_table, read_folder, read_table

CONDITIONS = read_conditions()
TEXT = "v_g_V,v_s_V\n" + "\n".join(f"{0.06 * k:.4g},{0.04 * k:.4g}" for k in range(30)) + "\n"


def test_the_package_has_29_measurements_to_fit_and_43_to_predict() -> None:
    fit, predict = read_folder(None, "fit"), read_folder(None, "predict")
    assert (len(fit), len(predict)) == (29, 43)
    for condition, table in fit.values():
        assert all(np.isfinite(table[name]).all() for name in columns_of(condition)[1])
    for condition, table in predict.values():
        given, measured = columns_of(condition)
        assert all(np.isfinite(table[name]).all() for name in given)
        assert all(np.isnan(table[name]).all() for name in measured)


def test_a_table_comes_back_from_its_text(tmp_path: Path) -> None:
    condition = CONDITIONS["fet_n_backgate"]
    file = tmp_path / "fet_n_backgate.csv"
    file.write_text(TEXT)
    table = read_table(file, condition)
    file.write_text(format_table(table))
    again = read_table(file, condition)
    assert all(np.array_equal(table[name], again[name]) for name in table)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (TEXT.replace("v_s_V", "v_s_mV"), "line 1: column v_s_mV, must be in V as v_s_V"),
        (TEXT.replace(",v_s_V", ",other_V"), "line 1: no column v_s_V"),
        (TEXT.replace("0.06,", "much,"), "line 3: v_g_V: 'much', must be a finite number"),
        (TEXT.replace("0.06,0.04", "0.06"), "line 3: 1 fields, must be 2"),
        (TEXT.replace("0.06,", "2.4,"), "line 3: v_g_V: 2.4 V, must be within 0 V and the supply of 1.8 V"),
        (TEXT.replace("0.06,", ","), "line 3: v_g_V: empty, must be what was set"),
        (TEXT + "1.8,1.0\n", "31 rows, must be 30"),
        ("", "line 1: no column v_g_V"),
    ],
)
def test_what_is_no_measurement_is_refused(text: str, said: str, tmp_path: Path) -> None:
    file = tmp_path / "fet_n_backgate.csv"
    file.write_text(text)
    with pytest.raises(DataError) as error:
        read_folder(tmp_path, "fit")
    assert said in str(error.value)
    assert str(file) in str(error.value)
    assert "\n" not in str(error.value)


def test_a_file_without_a_condition_and_a_folder_without_files_are_refused(tmp_path: Path) -> None:
    with pytest.raises(DataError, match="no CSV files"):
        read_folder(tmp_path, "fit")
    (tmp_path / "new.csv").write_text("a_V\n1\n")
    with pytest.raises(DataError, match="no condition of that name"):
        read_folder(tmp_path, "fit")
    (tmp_path / "new.csv").rename(tmp_path / "bab_runA.csv")
    with pytest.raises(DataError, match="is of predict, must be of fit"):
        read_folder(tmp_path, "fit")
