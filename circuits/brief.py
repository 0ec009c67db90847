"""Text of a dataclass that leaves out optional fields at their default values.

Measured records and studies are looked up by hashes of such texts. A field that is added later and marked as
optional leaves the text, and so the hash, of every older object as it was.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import MISSING, Field, fields
from functools import cache
from typing import Any

OPTIONAL: Mapping[str, bool] = {"optional": True}  # metadata of a field that is left out at its default


def brief(value: Any) -> str:
    """The dataclass's `repr` without those optional fields that have their default value."""
    shown = (f"{name}={getattr(value, name)!r}" for name in stated(value))
    return f"{type(value).__qualname__}({', '.join(shown)})"


def stated(value: Any) -> list[str]:
    """Names of a dataclass's fields without those optional ones that have their default value."""
    kind: Any = type(value)
    found = _shown(kind)
    return [name for name, field in found if field is None or not _is_left_out(field, getattr(value, name))]


@cache
def _shown(kind: type[Any]) -> tuple[tuple[str, Field[Any] | None], ...]:
    """Fields of a dataclass that its `repr` has: the name, and what is optional of it."""
    return tuple((f.name, f if f.metadata.get("optional") else None) for f in fields(kind) if f.repr)


def _is_left_out(field: Field[Any], value: object) -> bool:
    return bool(value == (field.default if field.default_factory is MISSING else field.default_factory()))
