"""Where runs begin, as `--ic`, `--uic` and `--at-rest` say it; nothing here is slow to import."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from circuits.errors import ParameterError

if TYPE_CHECKING:
    from circuits.testbench import Begin


@dataclass(frozen=True, slots=True)
class BeginChoice:
    """Voltages held at time 0, as texts `NODE=V`, and how a run begins (`Testbench.begin`)."""

    held: tuple[str, ...] = ()
    begin: Begin = "disturbed"


FREE = BeginChoice()


def begin_choice(held: Iterable[str], *, uic: bool = False, at_rest: bool = False) -> BeginChoice:
    """What the options say; raises `ParameterError` where they contradict each other."""
    texts = tuple(held)
    if at_rest and (uic or texts):
        given = "uic" if uic else "ic"
        raise ParameterError(f"at_rest: together with `{given}`, which begins elsewhere; leave one out")
    return BeginChoice(texts, "uic" if uic else "at_rest" if at_rest else "disturbed")


def refuse_beginning(begin: BeginChoice, what: str) -> None:
    """Raise `ParameterError` where an option says how runs begin of something that has no testbench."""
    given = {"ic": begin.held, "uic": begin.begin == "uic", "at_rest": begin.begin == "at_rest"}
    for option, value in given.items():
        if value:
            raise ParameterError(f"{option}: of a block's testbench, not of {what}; leave it out")
