"""Text of a dataclass in which an optional field stands only where it says something.

Keys of records and studies are hashes of such texts: an optional field that says nothing leaves them alone.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import MISSING, Field, fields
from typing import Any

OPTIONAL: Mapping[str, bool] = {"optional": True}  # metadata of a field that is left out at its default


def brief(value: Any) -> str:
    """What `repr` of the dataclass is, without its optional fields that stand at their default."""
    shown = (f"{name}={getattr(value, name)!r}" for name in stated(value))
    return f"{type(value).__qualname__}({', '.join(shown)})"


def stated(value: Any) -> list[str]:
    """Names of a dataclass's fields, without its optional ones that stand at their default."""
    return [f.name for f in fields(value) if f.repr and not _is_left_out(f, getattr(value, f.name))]


def _is_left_out(field: Field[Any], value: object) -> bool:
    if not field.metadata.get("optional"):
        return False
    return bool(value == (field.default if field.default_factory is MISSING else field.default_factory()))
