"""Reading the tables of a scene file: keys, and how the values of each are checked.

A table is described by its keys: how to read the value, and what it is where none is given.
"""

from __future__ import annotations

import difflib
import math
from collections.abc import Callable, Mapping
from typing import Any

from circuits.errors import ParameterError
from system.worlds.arena.scene import COLOURS, Point

LARGEST = 1e9  # of a scene's numbers, in SI units; ours: geometry overflows far beyond
Convert = Callable[[Any, str], Any]  # (value, path of its key) to the value inside, or `ParameterError`
Keys = Mapping[str, tuple[Convert, Any]]
REQUIRED = object()


def taken(content: Any, path: str, keys: Keys) -> dict[str, Any]:
    """Values of a table by key, converted; unknown keys and missing ones are refused."""
    if not isinstance(content, dict):
        raise ParameterError(f"{path}: {content!r}, must be a table of {', '.join(keys)}")
    for name in content:
        if name not in keys:
            near = difflib.get_close_matches(name, keys, n=1)
            guess = f"; did you mean {near[0]}?" if near else f"; known are {', '.join(keys)}"
            raise ParameterError(f"{joined(path, name)}: unknown key{guess}")
    found = {}
    for name, (convert, default) in keys.items():
        if name in content:
            found[name] = convert(content[name], joined(path, name))
        elif default is REQUIRED:
            raise ParameterError(f"{joined(path, name)}: missing, must be given")
        else:
            found[name] = default
    return found


def joined(path: str, name: str) -> str:
    """Path of a key in a table."""
    return f"{path}.{name}" if path else name


def number(low: float, high: float = math.inf, *, above: bool = False) -> Convert:
    """Read a number from `low` (or above it) to `high`."""
    rule = f"{'above' if above else 'at least'} {low:g}" if math.isfinite(low) else "finite"
    rule += f" and at most {high:g}" if math.isfinite(high) else ""

    def read(value: Any, path: str) -> float:
        number = not isinstance(value, bool) and isinstance(value, int | float)
        if number and LARGEST < abs(value) < math.inf:
            raise ParameterError(f"{path}: must be within {LARGEST:g} either way; correct it")
        if not number or not math.isfinite(value) or not low <= value <= high or (above and value == low):
            raise ParameterError(f"{path}: {value!r}, must be a number, {rule}")
        return float(value)

    return read


def whole(value: Any, path: str) -> int:
    """Read a whole number of at least 0."""
    if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value < 2**31:
        raise ParameterError(f"{path}: {value!r}, must be a whole number of at least 0")
    return value


def text(value: Any, path: str) -> str:
    """Read text."""
    if not isinstance(value, str):
        raise ParameterError(f"{path}: {value!r}, must be text")
    return value


def degrees(value: Any, path: str) -> float:
    """Read degrees as radians."""
    return math.radians(number(-math.inf)(value, path))


def light(value: Any, path: str) -> str | float:
    """Read the name of a light condition, or lux."""
    return value if isinstance(value, str) else float(number(0.0, above=True)(value, path))


def colour(value: Any, path: str) -> float:
    """Read a colour's name or a reflectance."""
    if isinstance(value, str):
        if value not in COLOURS:
            raise ParameterError(f"{path}: {value}, must be one of {', '.join(COLOURS)}, or a reflectance")
        return COLOURS[value]
    return float(number(0.0, 1.0, above=True)(value, path))


def pair(of: Convert) -> Convert:
    """Read two values."""

    def read(value: Any, path: str) -> tuple[Any, Any]:
        if not isinstance(value, list) or len(value) != 2:
            raise ParameterError(f"{path}: {value!r}, must be two numbers [x, y]")
        return of(value[0], f"{path}[0]"), of(value[1], f"{path}[1]")

    return read


def points(fewest: int) -> Convert:
    """Read a list of at least so many points."""

    def read(value: Any, path: str) -> tuple[Point, ...]:
        if not isinstance(value, list) or len(value) < fewest:
            raise ParameterError(f"{path}: {value!r}, must be a list of at least {fewest} points [x, y]")
        return tuple(pair(number(-math.inf))(p, f"{path}[{k}]") for k, p in enumerate(value))

    return read


def many(keys: Keys) -> Convert:
    """Read an array of tables."""

    def read(value: Any, path: str) -> list[dict[str, Any]]:
        if not isinstance(value, list):
            raise ParameterError(f"{path}: must be written as [[{path}]], one table each")
        return [taken(v, f"{path}[{k}]", keys) for k, v in enumerate(value)]

    return read


def one(keys: Keys) -> Convert:
    """Read a table."""
    return lambda value, path: taken(value, path, keys)


def count(value: Any, path: str) -> tuple[int, int]:
    """Read a number of at least 1, or the ends of a range."""
    low, high = pair(whole)(value, path) if isinstance(value, list) else (whole(value, path),) * 2
    if not 1 <= low <= high:
        raise ParameterError(f"{path}: {value}, must be a number of at least 1, or [from, to]")
    return low, high


def colours(value: Any, path: str) -> list[float]:
    """Read a list of colours."""
    if not isinstance(value, list) or not value:
        raise ParameterError(f"{path}: {value!r}, must be a list of colours")
    return [colour(v, f"{path}[{k}]") for k, v in enumerate(value)]
