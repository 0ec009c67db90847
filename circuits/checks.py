"""Checks of what a user gives: words that are not known, values that are no numbers, implausible sizes.

A length, capacitance, current, resistance or voltage outside of `LIMITS` is most likely a slip of a unit or a
prefix, such as 3 m of channel where 3 um was meant. It is refused unless the user says that it is meant, in
one of two ways:

    Capacitor("c", "a", "0", 0.1, allow_implausible=True)
    with implausible_allowed():
        circuit = build(params)

The second is for circuits whose devices somebody else constructs, such as those of a block. It holds for its
own thread until the end of the `with`, as `decimal.localcontext` does; a device that was constructed within
it remembers that it was allowed.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import fields
from math import isfinite
from typing import Any

import numpy as np

from circuits.errors import ParameterError
from circuits.units import format_quantity

# Lengths, capacitances and currents of silicon, of the boards beside it and of their measurement; those of
# resistances and voltages are ours.
LIMITS = {
    "m": (10e-9, 10e-3),
    "F": (1e-18, 1e-3),
    "A": (1e-15, 1.0),
    "Ohm": (1e-6, 1e15),
    "V": (0.0, 1e3),
}

_ALLOWED: ContextVar[bool] = ContextVar("implausible sizes are allowed", default=False)


@contextmanager
def implausible_allowed(allowed: bool = True) -> Iterator[None]:  # noqa: FBT001, FBT002 - as an option gives it
    """Let sizes outside of `LIMITS` pass within the `with`; where `allowed` is false nothing changes."""
    token = _ALLOWED.set(_ALLOWED.get() or allowed)
    try:
        yield
    finally:
        _ALLOWED.reset(token)


def keep_allowance(thing: object) -> None:
    """Mark a frozen object as allowed where it is constructed within `implausible_allowed`."""
    if _ALLOWED.get():
        object.__setattr__(thing, "allow_implausible", True)


def require_plausible(label: str, value: float, unit: str, *, allowed: bool) -> None:
    """Raise `ParameterError` for a magnitude outside of `LIMITS` for its unit, unless it is allowed."""
    low, high = LIMITS[unit]
    if low <= abs(value) <= high or (allowed and isfinite(value)):
        return
    ends = f"at most {format_quantity(high, unit)}"
    ends = f"{format_quantity(low, unit)} to {format_quantity(high, unit)}" if low else ends
    raise ParameterError(
        f"{label}: {value:g} {unit}, must be {ends}; give it in {unit}, or `allow_implausible`"
        " where it is meant"
    )


def require_real(label: str, value: object, unit: str) -> None:
    """Raise `ParameterError` unless `value` is a number, finite or not; text and truth values are refused."""
    if isinstance(value, bool) or not isinstance(value, int | float | np.integer | np.floating):
        of = f" in {unit}" if unit else ""
        raise ParameterError(f"{label}: {value!r:.60}, must be a number{of}; write as in 1e-6")


def require_reals(label: str, values: object, unit: str) -> None:
    """Raise `ParameterError` unless `values` is a number, or an array or a sequence of numbers."""
    try:
        kind = np.asarray(values).dtype.kind
    except ValueError:  # rows of different lengths
        kind = "O"
    if kind not in "iuf":
        of = f" in {unit}" if unit else ""
        raise ParameterError(f"{label}: {values!r:.60}, must be a number{of}, or several; write as in 1e-6")


def require_positive(params: Any, *names: str) -> None:
    """Raise `ParameterError` unless the named fields of a dataclass are above zero.

    The text of the error has the unit that the field states (`circuits.units.quantity`).
    """
    for each in fields(params):
        value = getattr(params, each.name)
        if each.name in names and not value > 0.0:
            unit = each.metadata.get("unit", "")
            raise ParameterError(f"{each.name}: {value:g}{' ' if unit else ''}{unit}, must be > 0")


def require_no_less(params: Any, *names: str, least: float = 0.0) -> None:
    """Raise `ParameterError`, with the field's unit, unless the named fields of a dataclass reach `least`."""
    for each in fields(params):
        value = getattr(params, each.name)
        if each.name in names and not value >= least:
            unit = f" {each.metadata['unit']}" if each.metadata.get("unit") else ""
            raise ParameterError(f"{each.name}: {value:g}{unit}, must be {least:g}{unit} or more")


def require_choice(label: str, value: object, known: Iterable[object]) -> None:
    """Raise `ParameterError`, which lists what is known, unless `value` is one of `known`."""
    names = list(known)
    if not any(value is name or (isinstance(value, str) and value == name) for name in names):
        words = [str(name) for name in names]
        raise ParameterError(f"{label}: {value!r}, must be {', '.join(words[:-1])} or {words[-1]}")


def require_type(label: str, value: object, kind: type | tuple[type, ...], noun: str) -> None:
    """Raise `ParameterError` unless `value` is an instance of `kind`, which the text calls `noun`."""
    if not isinstance(value, kind):
        raise ParameterError(f"{label}: {value!r:.60}, must be {noun}")
