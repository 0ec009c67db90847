"""The cards `.measure` of a deck, as what a command measures of it besides what it is asked for."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING

from circuits.checks import implausible_allowed
from circuits.errors import ParameterError
from circuits.measure.measure import read_measures
from circuits.measure.scope import Scope
from system.cli.block_choice import read_with
from system.notice import say
from system.options.block import Choice
from system.options.code import Code
from system.options.silicon import SiliconChoice
from system.options.target import deck_of
from system.study.metrics.measure import measurable

if TYPE_CHECKING:
    from netlists.read import Imported


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
    return taken(texts, measurable(choice)) if texts else ()


def own_cards(target: str, choice: Choice, analysis: str) -> list[str]:
    """Give the measures of a whole deck's cards of an analysis, as `ac`; none of any other target."""
    deck = deck_of(target)
    return [] if deck is None or deck.name else _texts(deck, choice, analysis=analysis)


def own_moves(target: str, choice: Choice) -> Mapping[str, complex]:
    """Give the AC values, V or A, of a whole deck's sources by name; none of any other target."""
    deck = deck_of(target)
    return {} if deck is None or deck.name else read_with(deck, choice).moved


def own_turned(target: str, choice: Choice) -> frozenset[str]:
    """Give the sources of a whole deck that its circuit sees from their other end; none of others."""
    deck = deck_of(target)
    return frozenset() if deck is None or deck.name else read_with(deck, choice).turned


def _texts(
    deck: Code, choice: Choice, moved: Mapping[str, float] | None = None, analysis: str = "tran"
) -> list[str]:
    return of_analysis(read_with(deck, choice, moved), analysis)


def of_analysis(found: Imported, analysis: str) -> list[str]:
    """Give the measures of a deck that has been read, of an analysis."""
    return [each.text for each in found.measures if each.analysis == analysis]


def taken(texts: Iterable[str], scope: Scope) -> tuple[str, ...]:
    """Give the texts of cards that a scope has the names of; others are told and left out."""
    found: tuple[str, ...] = ()
    for text in texts:
        try:
            read_measures((*found, text), scope)
        except ParameterError as error:
            say(f"{error}; this .measure card is left out")
        else:
            found = (*found, text)
    return found
