"""Files of codes, in TOML: one chip on one die a file."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import msgspec

from chips.codes import Codes
from circuits.errors import DataError
from circuits.generator.code import CODES
from system.files.document import converted, document_bytes, from_toml, plain
from system.files.writing import write_bytes_atomic

_REMEDY = "must be what noctule calibrate writes"
_CODE = re.compile(r"([0-7]):([0-9]{1,3})")  # coarse and fine, as `--bias` has them


def read_codes(path: Path) -> Codes:
    """Read a file of codes; raises `DataError` for one that is none."""
    try:
        found = from_toml(document_bytes(path, _REMEDY), dict[str, Any], str(path), _REMEDY)
    except FileNotFoundError:
        raise DataError(f"{path}: no such file, must be a file of codes; run noctule calibrate") from None
    biases = found.get("biases")
    if isinstance(biases, dict):
        found["biases"] = {name: _read(path, name, lines) for name, lines in biases.items()}
    return converted(found, Codes, str(path), _REMEDY)


def _read(path: Path, name: str, lines: object) -> list[tuple[int, int]]:
    """Codes of a bias's lines of their texts."""
    texts = lines if isinstance(lines, list) else [lines]
    codes = [_CODE.fullmatch(str(text)) for text in texts]
    known = [(int(found[1]), int(found[2])) for found in codes if found is not None]
    if len(known) < len(texts) or any(fine >= CODES for _, fine in known):
        raise DataError(f"{path}: biases.{name}, must be codes as 5:120, fine ones up to {CODES - 1}")
    return known


def write_codes(path: Path, codes: Codes) -> None:
    """Write a file of codes, whole or not at all; raises `DataError` where it cannot be."""
    document = plain(codes)
    document["biases"] = {
        name: [f"{coarse}:{fine}" for coarse, fine in lines] for name, lines in codes.biases.items()
    }
    write_bytes_atomic(path, msgspec.toml.encode(document))
