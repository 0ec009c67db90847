"""What a chip makes of a network, item by item: exact, approximate with a number, or impossible."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from circuits.errors import ParameterError

How = Literal["exact", "approximate", "impossible"]
EXACT = 0.01  # relative error up to which a value counts as met: about a step of a bias's code; ours


@dataclass(frozen=True, slots=True)
class Finding:
    """One thing that was asked for.

    Attributes
    ----------
    where : str
        Population, connection, input or the whole network.
    what : str
        What of it.
    how : str
        `exact`, `approximate` or `impossible`.
    error : float
        By how much it is off, as a share: of one number, or root mean square over many.
    note : str
        What the error is of, or the limit and the remedy.
    asked, got : float or None
        What was asked for, and what the nominal die has, in `unit`; None where there is no one number.
    unit : str
        Their unit.
    """

    where: str
    what: str
    how: How
    error: float
    note: str = ""
    asked: float | None = None
    got: float | None = None
    unit: str = ""


def value(where: str, what: str, asked: float, got: float, unit: str, note: str = "") -> Finding:
    """Return the finding of one number."""
    error = got / asked - 1.0 if asked else float(got != 0.0)
    return Finding(where, what, _how(error), error, note, asked, got, unit)


def spread(where: str, what: str, error: float, note: str) -> Finding:
    """Return the finding of many numbers, whose root mean square is off by the share `error`."""
    return Finding(where, what, _how(error), error, note)


def impossible(where: str, what: str, asked: float, got: float, unit: str, note: str) -> Finding:
    """Return the finding of what cannot be; got: the limit; note: the remedy."""
    return Finding(where, what, "impossible", 1.0, note, asked, got, unit)


def check_possible(findings: Sequence[Finding]) -> None:
    """Raise `ParameterError` for the first thing that cannot be, and how many there are besides."""
    wrong = [each for each in findings if each.how == "impossible"]
    if wrong:
        one, unit = wrong[0], f" {wrong[0].unit}" if wrong[0].unit else ""
        more = f"; {len(wrong) - 1} more cannot be either" if len(wrong) > 1 else ""
        asked, got = one.asked or 0.0, one.got or 0.0
        sign = "<=" if asked > got else ">="
        raise ParameterError(
            f"{one.where}.{one.what}: {asked:.4g}{unit}, must be {sign} {got:.4g}{unit}; {one.note}{more}"
        )


def counted(findings: Sequence[Finding]) -> dict[str, int]:
    """Return how many findings are approximate, and how many exact."""
    return {how: sum(f.how == how for f in findings) for how in ("approximate", "exact")}


def _how(error: float) -> How:
    return "exact" if abs(error) <= EXACT else "approximate"
