"""The cards `.measure tran` of a deck, as what a command measures of it besides what it is asked for."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

from circuits.checks import implausible_allowed
from circuits.errors import ParameterError
from netlists.read import read_netlist
from system.cli.block_choice import choose_block
from system.cli.shared_options import BlockValues
from system.notice import say
from system.options.begin import FREE, BeginChoice
from system.options.block import Choice
from system.options.silicon import SiliconChoice
from system.options.target import deck_of
from system.study.metrics.measure import measures_of


def own_measures(
    target: str,
    values: BlockValues,
    silicon: SiliconChoice,
    stimuli: Sequence[str] = (),
    begin: BeginChoice = FREE,
    steps: Literal["refused", "left"] = "refused",
) -> tuple[str, ...]:
    """Give the measures of a whole deck's cards as texts; none of any other target.

    A card that names what the circuit does not have is told and left out.

    Parameters
    ----------
    target : what the command is about.
    values, silicon, stimuli, begin, steps : as `system.cli.block_choice.choose_block` takes them.
    """
    deck = deck_of(target)
    if deck is None or deck.name:
        return ()
    with implausible_allowed(silicon.allow_implausible):
        texts = [each.text for each in read_netlist(deck.path).measures if each.analysis == "tran"]
    choice = choose_block(target, values, silicon, stimuli, begin, steps)
    return _taken(choice, texts) if texts else ()


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
