"""The shipped record is of today's circuit, and a record survives its file."""

from __future__ import annotations

from dataclasses import replace
from importlib.resources import files
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from chips.ranging.record import GRID, Grid, read_record, record_key, record_of, write_record
from chips.record_file import save_record, shipped_file
from circuits.blocks.sonar import rebound_neuron
from circuits.errors import DataError
from circuits.silicon.process import AMI_1500


def test_the_record_of_is_not_stale() -> None:
    key = record_key(rebound_neuron.build(), AMI_1500, GRID)
    assert record_of().key == key, "run: noctule characterise rebound-neuron --update-package"
    assert record_of().grid == GRID


def test_the_record_of_is_small_and_names_its_errors() -> None:
    record = record_of()
    assert Path(str(files("chips") / "records" / "rebound_neuron.nc")).stat().st_size < 1e6
    assert record.errors["dies"] >= 30
    assert record.errors["first_die"] < 1000  # dies from 1000 on are for reports
    assert 0.0 < record.margin == 2.0 * record.errors["margin_rms_V"] < 2e-3


def test_what_is_measured_anew_changes_the_key() -> None:
    neuron = rebound_neuron.build()
    keys = {
        record_key(neuron, AMI_1500, GRID),
        record_key(neuron, AMI_1500, Grid(GRID.current, (0.0, 27.0))),
        record_key(neuron, replace(AMI_1500, v_dd=3.3), GRID),
        record_key(rebound_neuron.build(rebound_neuron.Params(rebound_capacitance=500e-15)), AMI_1500, GRID),
    }
    assert len(keys) == 4
    rebiased = replace(neuron, biases=neuron.biases[:1])
    assert record_key(rebiased, AMI_1500, GRID) in keys


def test_a_record_survives_its_file(tmp_path: Path) -> None:
    record = record_of()
    write_record(record, tmp_path / "again.nc")
    again = read_record(tmp_path / "again.nc")
    assert (again.key, again.grid, again.box, again.margin) == (
        record.key, record.grid, record.box, record.margin,
    )  # fmt: skip
    assert again.errors == dict(record.errors)
    assert set(again.quantities) == set(record.quantities)
    for name, q in record.quantities.items():
        assert again.quantities[name].parameters == q.parameters
        assert np.array_equal(again.quantities[name].value, q.value)
        assert np.array_equal(again.quantities[name].gradient, q.gradient)


def test_another_file_is_refused(tmp_path: Path) -> None:
    save_record(xr.Dataset({"a": ("x", np.zeros(2))}), tmp_path / "other.nc")
    with pytest.raises(DataError, match=r"other\.nc: no record of version"):
        read_record(tmp_path / "other.nc")


def test_outside_the_package_a_record_is_believed_as_it_was_written_alone(tmp_path: Path) -> None:
    path, shipped = tmp_path / "own.nc", shipped_file("rebound_neuron")
    path.write_bytes(shipped.read_bytes())
    with pytest.raises(DataError, match=r"own\.nc: no record, no digest of its contents .*delete it"):
        read_record(path)
    write_record(record_of(), path)
    whole = path.read_bytes()
    for k in range(0, len(whole), 97):  # HDF5 reads some such files for ever
        path.write_bytes(whole[:k] + bytes([whole[k] ^ 1]) + whole[k + 1 :])
        with pytest.raises(DataError, match=r"own\.nc: no record, (it was changed|no digest)"):
            read_record(path)


def test_a_block_without_a_record_is_named() -> None:
    with pytest.raises(DataError, match="no_such_block: no record"):
        record_of("no_such_block")
