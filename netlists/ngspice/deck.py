"""A user's deck in ngspice as it stands: its own cards, with one of its analyses.

The deck is read into its cards, files that it includes in place, within the limits of the reader and its root
folder. What stands between `.control` and `.endc` is never run: a command there could run anything. An
analysis there is taken as a card (`netlists.read.text.lines`).
"""

from __future__ import annotations

from pathlib import Path
from typing import Literal

from circuits.errors import DataError, SimulatorError
from netlists.ngspice.deadline import DEADLINE
from netlists.ngspice.run import Waveforms, run
from netlists.read.card import Card
from netlists.read.limits import DEFAULT_LIMITS
from netlists.read.note import Notes
from netlists.read.text.lines import read_text

Ran = Literal["tran", "op", "dc"]

_ANALYSES = {".tran", ".op", ".dc", ".ac", ".noise", ".disto", ".pz", ".sens", ".tf", ".sp", ".pss"}
_OUTPUT = {".print", ".plot", ".probe", ".save", ".four", ".meas", ".measure", ".end"}


def run_deck(
    path: Path, analysis: Ran, *, root: Path | None = None, deadline_s: float | None = DEADLINE
) -> Waveforms:
    """Run a deck's own analysis in ngspice.

    Parameters
    ----------
    path
        The deck.
    analysis
        `tran` or `dc` for its first card of that kind; `op` for its operating point, whether it asks or not.
    root
        Folder that files which it includes must lie in; the deck's own unless given.
    deadline_s
        Wall-clock time after which the run is halted, s; None for as long as it takes.

    Raises
    ------
    DataError
        The deck cannot be read, or asks for no such analysis.
    SimulatorError
        ngspice is missing, refuses the deck, gives up, or is not done in time.
    """
    try:
        return run(deck_text(path, analysis, root), deadline_s=deadline_s)
    except SimulatorError as error:
        raise SimulatorError(f"{path.name}: {error}") from error


def deck_text(path: Path, analysis: Ran, root: Path | None = None) -> str:
    """Give the deck as one text with one analysis; raises `DataError` as `run_deck`."""
    text = read_text(path, root, DEFAULT_LIMITS, Notes(keeps=True))
    if text.language != "spice":
        raise DataError(f"{path.name}: {text.language}, must be SPICE to run in ngspice; write it as SPICE")
    kept = [c for c in text.cards if c.name() not in _ANALYSES | _OUTPUT and not c.text.startswith("*")]
    chosen = ".op" if analysis == "op" else _first(path, text.cards, f".{analysis}").text
    return "\n".join([text.title or "*", *(card.text for card in kept), chosen, ".end"]) + "\n"


def _first(path: Path, cards: list[Card], word: str) -> Card:
    found = {card.name(): card for card in reversed(cards) if card.name() in _ANALYSES}
    if word not in found:
        asks = ", ".join(sorted(found)) or "nothing"
        raise DataError(
            f"{path.name}: no {word} card, it asks for {asks}; add one, or choose another analysis"
        )
    return found[word]
