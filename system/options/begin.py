"""The state in which the runs of a block begin, as the command line asks for it.

The options are `--ic`, `--uic` and `--at-rest`. Nothing here is slow to import.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from circuits.errors import ParameterError

if TYPE_CHECKING:
    from circuits.testbench import Begin


@dataclass(frozen=True, slots=True)
class BeginChoice:
    """The state in which runs begin.

    held : nodes with the voltages at which they are held until time 0, as texts `NODE=V`.
    begin : how a run finds the voltages of the other nodes (`circuits.testbench.Testbench.begin`).
    """

    held: tuple[str, ...] = ()
    begin: Begin = "disturbed"


FREE = BeginChoice()


def begin_choice(held: Iterable[str], *, uic: bool = False, at_rest: bool = False) -> BeginChoice:
    """Give the state that the options ask for; raises `ParameterError` where they contradict each other."""
    texts = tuple(held)
    if at_rest and (uic or texts):
        given = "uic" if uic else "ic"
        raise ParameterError(f"at_rest: together with `{given}`, which begins elsewhere; leave one out")
    return BeginChoice(texts, "uic" if uic else "at_rest" if at_rest else "disturbed")


def refuse_beginning(begin: BeginChoice, what: str) -> None:
    """Raise `ParameterError` where an option says how runs begin of `what`, which has no testbench."""
    given = {"ic": begin.held, "uic": begin.begin == "uic", "at_rest": begin.begin == "at_rest"}
    for option, value in given.items():
        if value:
            raise ParameterError(f"{option}: of a block's testbench, not of {what}; leave it out")
