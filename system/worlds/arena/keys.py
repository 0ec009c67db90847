"""Fields that tables of a scene file have in common: each is an option (`system.option`) of one kind."""

from __future__ import annotations

import math
from typing import Any

from system.option import option, required


def length(usual: float, about: str) -> Any:
    """A length (m) above 0."""
    return option(usual, about, unit="m", above=0.0)


def from_zero(usual: float, about: str) -> Any:
    """A length (m) of 0 or more."""
    return option(usual, about, unit="m", least=0.0)


def share(usual: float, about: str) -> Any:
    """A number above 0 and at most 1, without unit."""
    return option(usual, about, unit="", above=0.0, most=1.0)


def whole(usual: int, about: str) -> Any:
    """A whole number of at least 0."""
    return option(usual, about, least=0, below=2**31)


def place() -> Any:
    """Where the middle of a thing stands, x and y in m; it must be given."""
    return required("Where its middle stands, [x, y]", unit="m")


def size() -> Any:
    """Length of a thing along its heading, and its width, in m; it must be given."""
    return required("Along its heading and across, [length, width]", unit="m", above=0.0)


def heading() -> Any:
    """Heading of a thing, in degrees in the file and in rad in the field."""
    about = "Counter-clockwise from x"
    return option(0.0, about, name="heading_deg", unit="deg", to_field=math.radians)
