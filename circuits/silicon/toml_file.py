"""What stands in a TOML file, or the one error that says why it cannot be read."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from circuits.catalogue import later
from circuits.errors import DataError

tomllib = later("tomllib")  # many a run reads no file


def read_toml(path: Path, wanted: str) -> dict[str, Any]:
    """Read a TOML file.

    wanted: what the file is, as the error of one that cannot be opened asks for it. Raises `DataError` for a
    file that cannot be read, or is no TOML.
    """
    try:
        found: dict[str, Any] = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise DataError(f"{path}: {error.strerror}; name {wanted}") from None
    except (UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise DataError(f"{path}: no TOML ({error}); correct it") from None
    return found
