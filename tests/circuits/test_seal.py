"""Contents are believed only as they were written."""

from __future__ import annotations

import io
from pathlib import Path

import h5py
import numpy as np
import pytest

from circuits.seal import check_sealed, sealed, unsealed

CONTENTS = bytes(range(256)) * 3


@pytest.mark.parametrize("contents", [b"", b"a", CONTENTS, memoryview(CONTENTS)])
def test_what_is_sealed_comes_back(contents: bytes | memoryview) -> None:
    assert unsealed(sealed(contents)) == contents


@pytest.mark.parametrize("length", [2**20 - 1, 2**20, 2**20 + 1])
def test_long_files_are_checked_to_their_end(length: int) -> None:
    data = bytearray(sealed(bytes(length)))
    check_sealed(io.BytesIO(data))
    data[length - 1] = 1
    with pytest.raises(ValueError, match="was changed since it was written"):
        check_sealed(io.BytesIO(data))


def test_no_changed_byte_is_believed() -> None:
    data = sealed(CONTENTS)
    for k in range(len(data)):
        with pytest.raises(ValueError, match=r"changed since|no digest"):
            unsealed(data[:k] + bytes([data[k] ^ 1]) + data[k + 1 :])


@pytest.mark.parametrize("data", [b"", CONTENTS, sealed(CONTENTS)[:-1], sealed(CONTENTS) + b"x"])
def test_what_has_no_digest_at_its_end_is_told(data: bytes) -> None:
    with pytest.raises(ValueError, match="no digest of its contents at its end"):
        unsealed(data)


def test_a_piece_put_in_or_left_out_is_told() -> None:
    data = sealed(CONTENTS)
    for other in (data[1:], b"x" + data):
        with pytest.raises(ValueError, match="was changed since it was written"):
            unsealed(other)


def test_hdf5_reads_a_sealed_file_as_any_other(tmp_path: Path) -> None:
    made = io.BytesIO()
    with h5py.File(made, "w") as file:
        file["a"] = np.arange(5.0)
    (tmp_path / "a.nc").write_bytes(sealed(made.getvalue()))
    with h5py.File(tmp_path / "a.nc", "r") as file:
        np.testing.assert_array_equal(file["a"], np.arange(5.0))
