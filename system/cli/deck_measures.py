"""The cards `.measure tran` of a deck, as what a command measures of it besides what it is asked for."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from circuits.checks import implausible_allowed
from circuits.errors import ParameterError
from netlists.read import read_netlist
from system.notice import say
from system.options.block import Choice
from system.options.silicon import SiliconChoice
from system.options.target import deck_of
from system.study.metrics.measure import measures_of


def own_measures(target: str, silicon: SiliconChoice, chosen: Callable[[], Choice]) -> tuple[str, ...]:
    """Give the measures of a whole deck's cards as texts; none of any other target.

    A card that names what the circuit does not have is told and left out.

    Parameters
    ----------
    target : what the command is about.
    silicon : what is asked for, which says whether implausible values are let through.
    chosen : gives the deck's circuit with what is asked for; only a deck with such cards is chosen.
    """
    deck = deck_of(target)
    if deck is None or deck.name:
        return ()
    with implausible_allowed(silicon.allow_implausible):
        texts = [each.text for each in read_netlist(deck.path).measures if each.analysis == "tran"]
    return _taken(chosen(), texts) if texts else ()


def _taken(choice: Choice, texts: Sequence[str]) -> tuple[str, ...]:
    found: tuple[str, ...] = ()
    for text in texts:
        try:
            measures_of(choice, (*found, text))
        except ParameterError as error:
            say(f"{error}; this .measure card is left out")
        else:
            found = (*found, text)
    return found
