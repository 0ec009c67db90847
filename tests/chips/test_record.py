"""A record survives its file; what is no record is refused in one line."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from chips.law_lattice import law_of
from chips.model import model_names
from chips.record import (
    WITHOUT_BIASES,
    Record,
    Table,
    content,
    current_record,
    kept_record,
    matching_record,
    read_record,
    record_digest,
    record_key,
    recorded,
    write_record,
)
from chips.record_file import save_record, shipped_file
from circuits.blocks.sonar import rebound_neuron
from circuits.errors import DataError
from circuits.seal import unsealed
from circuits.silicon.process import AMI_1500_IDEAL

RECORD = Record(
    "some key",
    3,
    {"temperature": (-10.0, 27.0), "parameter": ("m1.v_t0", "m1.beta")},
    {
        "time_s": Table(("temperature", "side"), np.array([[0.1, 0.2, 0.3], [1.0, 1.0 / 3.0, np.nan]])),
        "slope": Table(("temperature", "parameter"), np.arange(4.0).reshape(2, 2)),
        "deadline_s": Table((), np.array(1e-3)),
    },
    {"time_rms_s": 1.0 / 3.0},
    {"threshold_V": (-0.2, 0.2)},
    law_of(AMI_1500_IDEAL),
)


def same(one: Record, other: Record) -> None:
    """Both are equal to the bit."""
    assert (one.key, one.version, dict(one.axes)) == (other.key, other.version, dict(other.axes))
    assert (dict(one.errors), dict(one.box)) == (dict(other.errors), dict(other.box))
    assert set(one.tables) == set(other.tables)
    for name, table in one.tables.items():
        assert table.axes == other.tables[name].axes
        np.testing.assert_array_equal(table.values, other.tables[name].values)
    assert one.law is not None
    assert other.law is not None
    assert (one.law.process, one.law.solver) == (other.law.process, other.law.solver)
    assert list(one.law.values) == list(other.law.values)
    for name, values in one.law.values.items():
        np.testing.assert_array_equal(values, other.law.values[name])


def test_a_record_survives_its_file(tmp_path: Path) -> None:
    write_record(RECORD, tmp_path / "a.nc")
    same(read_record(tmp_path / "a.nc"), RECORD)


@pytest.mark.parametrize("name", model_names())
def test_every_shipped_record_is_written_as_it_is_read(name: str, tmp_path: Path) -> None:
    shipped = read_record(shipped_file(name))
    write_record(shipped, tmp_path / "a.nc")
    same(read_record(tmp_path / "a.nc"), shipped)
    # one file of one kind: nothing is in the package's that writing leaves out
    with (
        xr.open_dataset(shipped_file(name), engine="h5netcdf") as before,
        xr.open_dataset(tmp_path / "a.nc", engine="h5netcdf") as after,
    ):
        assert set(before.attrs) == set(after.attrs)
        assert set(before.variables) == set(after.variables)


def test_axes_tables_and_box_are_asked_for_by_name() -> None:
    assert RECORD.numbers("temperature") == (-10.0, 27.0)
    assert RECORD.names("parameter") == ("m1.v_t0", "m1.beta")
    assert RECORD["temperature"].tolist() == [-10.0, 27.0]
    assert RECORD["slope"][1, 0] == 2.0
    assert RECORD.limits("temperature") == (-10.0, 27.0)
    assert RECORD.limits("threshold_V") == (-0.2, 0.2)


@pytest.mark.parametrize("name", ["current", "parameter"])
def test_what_is_not_in_a_record_is_told(name: str) -> None:
    with pytest.raises(DataError, match=rf"record\.{name}: no axis of numbers .*run noctule characterise"):
        RECORD[name]


@pytest.mark.parametrize(
    ("data", "reason"),
    [
        (xr.Dataset({"a": ("x", np.zeros(2))}), "it has no key"),
        (xr.Dataset({"a": ("x", ["one"])}, attrs={"key": "k"}), "must be of numbers"),
        (xr.Dataset({"a": ((), 1.0)}, attrs={"key": "k", "error_x": "many"}), "could not convert"),
        (xr.Dataset({"a": ((), 1.0)}, attrs={"key": "k", "box_x": 1.0}), "must have two"),
        (xr.Dataset({"law": ("x", np.zeros(2))}, attrs={"key": "k", "law": "{}"}), "law: 'process'"),
        (xr.Dataset({"law": ("x", np.zeros(2))}, attrs={"key": "k", "law": "[]"}), "law: list indices"),
    ],
)
def test_another_file_is_refused(data: xr.Dataset, reason: str, tmp_path: Path) -> None:
    path = tmp_path / "other.nc"
    save_record(data, path)
    with pytest.raises(DataError, match=rf"other\.nc: no record, .*{reason}.*; delete it, or run noctule"):
        read_record(path)


def test_outside_the_package_a_record_is_believed_as_it_was_written_alone(tmp_path: Path) -> None:
    path, shipped = tmp_path / "own.nc", shipped_file("rebound_neuron")
    path.write_bytes(unsealed(shipped.read_bytes()))
    with pytest.raises(DataError, match=r"own\.nc: no record, no digest of its contents .*delete it"):
        read_record(path)
    write_record(kept_record("rebound_neuron"), path)
    whole = path.read_bytes()
    for k in range(0, len(whole), 97):  # HDF5 reads some such files for ever
        path.write_bytes(whole[:k] + bytes([whole[k] ^ 1]) + whole[k + 1 :])
        with pytest.raises(DataError, match=r"own\.nc: no record, (it was changed|no digest)"):
            read_record(path)


def test_numbers_that_no_float_holds_are_refused(tmp_path: Path) -> None:
    signalling = np.array([0x7FA00000], dtype=np.uint32).view(np.float32)  # becomes another NaN as a float64
    save_record(xr.Dataset({"a": ("x", signalling)}, attrs={"key": "k"}), tmp_path / "a.nc")
    with pytest.raises(DataError, match=r"a\.nc: no record, invalid value .*; delete it"):
        read_record(tmp_path / "a.nc")


def test_a_block_without_a_record_is_named() -> None:
    with pytest.raises(DataError, match="no_such_block: no record"):
        kept_record("no_such_block")


def test_the_record_in_force_is_the_innermost() -> None:
    other = RECORD.extended({})
    with recorded("block", RECORD):
        with recorded("block", other):
            assert current_record("block") is other
        assert matching_record("block", lambda _: "some key") is RECORD
        with pytest.raises(DataError, match="block: its record is of another circuit or process"):
            matching_record("block", lambda _: "another key")
    with pytest.raises(DataError, match="no record"):
        current_record("block")


def test_the_digest_is_of_what_the_record_says() -> None:
    # what kept campaigns of spiking bats depend on: another one would ask them to be flown again
    record = kept_record("latency_chip")
    kept = "88d3b1447849f472c2f2af6e968ffdf0806a4fa33d22f569b5cad81257677207"
    assert record_digest(record) == record_digest(replace(record, law=None)) == kept
    name, table = next(iter(record.tables.items()))
    moved = record.extended({name: Table(table.axes, np.nextafter(table.values, np.inf))})
    others = [
        moved,
        replace(record, key="other"),
        replace(record, errors={}),
        replace(record, box={"a": (0.0, 1.0)}),
    ]
    assert len({record_digest(other) for other in (record, *others)}) == 5


def test_a_key_is_of_all_its_parts() -> None:
    neuron = rebound_neuron.build()
    whole, plain = content(neuron), content(neuron, WITHOUT_BIASES)
    assert len({record_key(whole), record_key(plain), record_key(plain, 1), record_key(plain, 2)}) == 4
