"""A digest behind contents, so that they are believed only as they were written.

For formats whose libraries hang or crash on damaged bytes: the digest is compared before they see any. It
stands at the end, where HDF5 and pickle look at nothing, so that other programs read such a file as any.
It keeps out what was damaged, not what somebody made to do harm and sealed.
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
    """The contents with their digest behind them."""
    return b"".join((data, _MARK, sha256(data).digest()))


def unsealed(data: bytes) -> bytes:
    """Contents that `sealed` sealed; raises `ValueError` where they are not what they were."""
    check_sealed(io.BytesIO(data))
    return data[:-_LENGTH]


def check_sealed(file: BinaryIO) -> None:
    """Raise `ValueError` for a file that has no digest at its end, or one of other contents."""
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
