"""Numbers of a model: the check of a dataclass whose fields are quantities in SI units."""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import fields
from typing import Any

from circuits.errors import ParameterError


def check_numbers(
    owner: str, numbers: Any, *, from_zero: Collection[str] = (), signed: Collection[str] = ()
) -> None:
    """Raise `ParameterError` for a number of a dataclass that is out of range.

    Every field that holds a number must be finite and above 0.

    Parameters
    ----------
    owner : what errors call the dataclass, such as `bat`.
    from_zero : names of fields that may be 0 too.
    signed : names of fields that may be any finite number.
    """
    for each in fields(numbers):
        value = getattr(numbers, each.name)
        if isinstance(value, bool) or not isinstance(value, int | float):
            continue
        rule = "must be finite"
        if each.name not in signed:
            rule = f"must be {'>=' if each.name in from_zero else '>'} 0 and finite"
        within = value > 0.0 or each.name in signed or (each.name in from_zero and value == 0.0)
        if not (math.isfinite(value) and within):
            raise ParameterError(f"{owner}.{each.name}: {value:g}, {rule}; see its default")
