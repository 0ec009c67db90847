"""A digest at the end of a file, so that damaged contents are noticed before they are read.

It is meant for formats whose libraries hang or crash on damaged bytes. It stands at the end, where HDF5 and
pickle do not look, so that other programs can read the file as usual. It protects from damage, not from
somebody who changes a file on purpose and seals it again.
"""

from __future__ import annotations

import io
import os
from hashlib import sha256
from typing import BinaryIO

_MARK = b"\nsealed sha256 "
_LENGTH = len(_MARK) + sha256().digest_size  # bytes of a seal
_PIECE = 2**20  # bytes that are read at once; ours


def sealed(data: bytes | memoryview) -> bytes:
    """The contents followed by their digest."""
    return b"".join((data, _MARK, sha256(data).digest()))


def unsealed(data: bytes) -> bytes:
    """The contents that `sealed` was given; raises `ValueError` where they have changed since."""
    check_sealed(io.BytesIO(data))
    return data[:-_LENGTH]


def check_sealed(file: BinaryIO) -> None:
    """Raise `ValueError` for a file without a digest at its end, or with one of other contents."""
    end = max(file.seek(0, os.SEEK_END) - _LENGTH, 0)
    file.seek(end)
    seal = file.read(_LENGTH)
    if not seal.startswith(_MARK):
        raise ValueError("no digest of its contents at its end: it was cut or edited, or is of old")
    file.seek(0)
    found = sha256()
    for start in range(0, end, _PIECE):
        found.update(file.read(min(_PIECE, end - start)))
    if found.digest() != seal[len(_MARK) :]:
        raise ValueError("it was changed since it was written")
