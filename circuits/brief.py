"""Text of a dataclass that leaves out optional fields at their default values.

Measured records and studies are looked up by hashes of such texts. A field that is added later and marked as
optional leaves the text, and so the hash, of every older object as it was.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import MISSING, Field, fields
from typing import Any

OPTIONAL: Mapping[str, bool] = {"optional": True}  # metadata of a field that is left out at its default


def brief(value: Any) -> str:
    """The dataclass's `repr` without those optional fields that have their default value."""
    shown = (f"{name}={getattr(value, name)!r}" for name in stated(value))
    return f"{type(value).__qualname__}({', '.join(shown)})"


def stated(value: Any) -> list[str]:
    """Names of a dataclass's fields without those optional ones that have their default value."""
    return [f.name for f in fields(value) if f.repr and not _is_left_out(f, getattr(value, f.name))]


def _is_left_out(field: Field[Any], value: object) -> bool:
    if not field.metadata.get("optional"):
        return False
    return bool(value == (field.default if field.default_factory is MISSING else field.default_factory()))
