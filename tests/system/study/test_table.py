"""Tables of samples and their files."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from circuits.errors import DataError
from circuits.seal import sealed
from system.study.table import Table, empty, join, read_table, select, to_csv, to_dataset, write_table

TABLE = Table(
    ("delay", "gain"),
    np.array([3, 4], dtype=np.int64),
    ("random", "ss"),
    np.array([27.0, 85.0]),
    np.array([0, 1], dtype=np.int64),
    ("works", "failed"),
    ("", "no, not really"),
    np.array([[1e-3, np.nan], [np.nan, np.nan]]),
)


def test_a_table_comes_back_from_its_file(tmp_path: Path) -> None:
    for table in (TABLE, empty(("delay", "gain")), join([TABLE, TABLE])):
        write_table(tmp_path / "a.nc", table, ("s", ""), "key")
        back = read_table(tmp_path / "a.nc", "key")
        assert back.metrics == table.metrics
        assert (back.corner, back.outcome, back.reason) == (table.corner, table.outcome, table.reason)
        for name in ("die", "temperature_c", "trial", "values"):
            np.testing.assert_array_equal(getattr(back, name), getattr(table, name))


def test_what_is_no_table_is_told_in_a_line(tmp_path: Path) -> None:
    path = tmp_path / "a.nc"
    with pytest.raises(DataError, match=r"a\.nc: cannot be read"):
        read_table(path, "key")
    path.write_bytes(b"CDF no")
    with pytest.raises(DataError, match=r"a\.nc: cannot be read"):
        read_table(path, "key")


@pytest.mark.parametrize(
    ("name", "column"),
    [
        ("die", np.array([1.0, np.nan])),
        ("die", np.array([[1, 2]])),
        ("trial", np.zeros(3, np.int64)),
        ("temperature_C", np.array(["27", "27"], dtype=object)),
        ("metric_gain", np.zeros(2, np.int64)),
        ("corner", np.zeros(2, np.int64)),
        ("outcome", np.array(["works"], dtype=object)),
    ],
)
def test_a_column_of_another_kind_or_length_is_refused(name: str, column: object, tmp_path: Path) -> None:
    written = to_dataset(TABLE, ("s", ""), "key").drop_vars(name)
    written[name] = (tuple(f"{name}{k}" for k in range(np.ndim(column))), column)
    (tmp_path / "a.nc").write_bytes(sealed(written.to_netcdf(engine="h5netcdf")))
    with pytest.raises(DataError, match=f"cannot be read, {name} is .*; measure it again"):
        read_table(tmp_path / "a.nc", "key")


def test_csv_has_a_row_a_sample_and_nothing_for_what_is_not_defined() -> None:
    assert to_csv(TABLE, ("s", "")).splitlines() == [
        "die,corner,temperature_C,trial,class,delay_s,gain,reason",
        "3,random,27.0,0,works,0.001,,",
        '4,ss,85.0,1,failed,,,"no, not really"',
    ]


def test_columns_and_selections() -> None:
    assert TABLE.column("delay")[0] == 1e-3
    assert select(TABLE, np.array([False, True])).outcome == ("failed",)
