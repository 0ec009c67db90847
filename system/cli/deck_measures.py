"""The cards `.measure tran` of a deck, as what a command measures of it besides what it is asked for."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from circuits.checks import implausible_allowed
from circuits.errors import ParameterError
from system.cli.block_choice import read_with
from system.notice import say
from system.options.block import Choice
from system.options.code import Code
from system.options.silicon import SiliconChoice
from system.options.target import deck_of
from system.study.metrics.measure import measures_of


def own_measures(
    target: str, silicon: SiliconChoice, chosen: Callable[[], Choice], moved: Sequence[str] = ()
) -> tuple[str, ...]:
    """Give the measures of a whole deck's cards as texts; none of any other target.

    A card that names what the circuit does not have is told and left out.

    Parameters
    ----------
    target : what the command is about.
    silicon : what is asked for, which says whether implausible values are let through.
    chosen : gives the deck's circuit with what is asked for; only a whole deck is chosen.
    moved : parameters that are swept; a card that follows one is told and left out.
    """
    deck = deck_of(target)
    if deck is None or deck.name:
        return ()
    choice = chosen()
    with implausible_allowed(silicon.allow_implausible):
        texts = _texts(deck, choice)
        for name in moved if texts else ():
            with implausible_allowed():  # of a deck that is read for its cards, and never run
                there = _texts(deck, choice, {name: 1.0 + 1.1 * getattr(choice.params, name)})
            for text in (each for each in texts if each not in there):
                say(f"{text}: follows {name}, which is swept; this .measure card is left out")
            texts = [text for text in texts if text in there]
    return _taken(choice, texts) if texts else ()


def _texts(deck: Code, choice: Choice, moved: Mapping[str, float] | None = None) -> list[str]:
    found = read_with(deck, choice, moved)
    return [each.text for each in found.measures if each.analysis == "tran"]


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
