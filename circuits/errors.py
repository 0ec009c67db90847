"""The error tree.

Every error that a user can cause or meet is a `CircuitError` and also the builtin that fits it.
Its text is one line: `instance.path.attribute: value unit, rule; what to try`.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable

_LISTED = 20  # names at most that an error lists; ours
_LONGEST_NAME = 80  # characters of an unknown name that an error repeats; ours


class CircuitError(Exception):
    """Root of every error raised on purpose; its text is one line, whatever it repeats of an input."""

    def __str__(self) -> str:
        return " ".join(super().__str__().split())


class ParameterError(CircuitError, ValueError):
    """A value breaks a rule: a negative size, a unit that does not fit, a temperature outside the laws."""


class TopologyError(CircuitError, ValueError):
    """A circuit is wired wrongly: a floating gate, a duplicate name, a loop of supplies."""


class UnknownNameError(CircuitError, LookupError):
    """A name that nothing in the registry or the circuit carries."""


class DataError(CircuitError, ValueError):
    """A file's contents cannot be used; the text names file and row."""


class SolverError(CircuitError, ArithmeticError):
    """A solve ended without an answer; the text names the outcome and its remedy."""


class SimulatorError(CircuitError, RuntimeError):
    """An outside simulator is missing or failed."""


def unknown_name(kind: str, name: str, known: Iterable[str]) -> UnknownNameError:
    """Build the error for `name`: the nearest known name, then all of them unless they are many, sorted."""
    names = sorted(known)
    name = shown_name(name)  # near names are sought in quadratic time
    if not names:
        return UnknownNameError(f"{kind} {name}: unknown; there is none to choose")
    near = difflib.get_close_matches(name, names, n=1, cutoff=0.6) or [n for n in names if name in n]
    guess = f"; did you mean {near[0]}?" if near else ";"
    more = f" and {len(names) - _LISTED} more" if len(names) > _LISTED else ""
    return UnknownNameError(f"{kind} {name}: unknown{guess} known are {', '.join(names[:_LISTED])}{more}")


def shown_name(name: str) -> str:
    """A name that a user gave, its beginning where it is too long to be one."""
    return name if len(name) <= _LONGEST_NAME else f"{name[:_LONGEST_NAME]}..."
