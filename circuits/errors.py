"""The tree of errors that a user can cause or meet.

Every one is a `CircuitError` and also the built-in error that fits it. Its text is one line, of the form
`instance.path.attribute: value unit, rule; what to try`.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable

_LISTED = 20  # names at most that an error lists; ours
_LONGEST_NAME = 80  # characters of an unknown name that an error repeats; ours


class CircuitError(Exception):
    """Root of every error that is raised on purpose; its text is a single line, whatever its input was."""

    def __str__(self) -> str:
        return " ".join(super().__str__().split())


class ParameterError(CircuitError, ValueError):
    """A value breaks a rule: a negative size, a unit that does not fit, a temperature out of range."""


class TopologyError(CircuitError, ValueError):
    """A circuit is wired wrongly: a gate floats, a name stands twice, supplies form a loop."""


class UnknownNameError(CircuitError, LookupError):
    """Nothing in the registry or the circuit has the name that was asked for."""


class DataError(CircuitError, ValueError):
    """The contents of a file cannot be used; the text names the file and the row."""


class SolverError(CircuitError, ArithmeticError):
    """A solver ended without an answer; the text says how it ended and what to try."""


class SimulatorError(CircuitError, RuntimeError):
    """An outside simulator is missing or failed."""


def unknown_name(kind: str, name: str, known: Iterable[str]) -> UnknownNameError:
    """An error for an unknown `name`, with the nearest known one and, unless they are many, all of them."""
    names = sorted(set(known))
    name = _shown_name(name)
    if not names:
        return UnknownNameError(f"{kind} {name}: unknown; there is none to choose")
    guess = meant(name, names) or ";"
    more = f" and {len(names) - _LISTED} more" if len(names) > _LISTED else ""
    return UnknownNameError(f"{kind} {name}: unknown{guess} known are {', '.join(names[:_LISTED])}{more}")


def nearest(name: str, known: Iterable[str]) -> str | None:
    """Return the known name that is spelled most like `name`, else one that has it as a part, else None."""
    names, name = list(known), _shown_name(name)
    near = difflib.get_close_matches(name, names, n=1)  # in quadratic time
    return near[0] if near else next((each for each in names if name and name in each), None)


def meant(name: str, known: Iterable[str]) -> str:
    """Return `; did you mean delay?` for the nearest known name, the end of a refusal; empty without one."""
    near = nearest(name, known)
    return f"; did you mean {near}?" if near else ""


def _shown_name(name: str) -> str:
    """A name as a user gave it, cut short where it is too long to be a name."""
    return name if len(name) <= _LONGEST_NAME else f"{name[:_LONGEST_NAME]}..."
