"""What a result says of a foundry's process: whether its cards were taken, and whose statistics a die has."""

from __future__ import annotations

from circuits.catalogue import loaded
from circuits.silicon.silicon import Silicon
from system.meaning import meanings

NGSPICE = "ngspice"
"""The engine, and the dialect, that takes a foundry's cards."""

CARDS_KEYS = meanings("""
cards       string?  -  foundry's process whose own cards were taken in the place of our law; null for our law
statistics  string?  -  whose statistics its dies have; null under our law, whose file states them
""")


def describe_cards(silicon: Silicon, engine: str) -> dict[str, str | None]:
    """The cards and the statistics that a result is of, by the names that JSON has for them.

    Parameters
    ----------
    silicon
        On what it was made.
    engine
        The engine, or the dialect, by its name.
    """
    cards = silicon.process.cards
    if not cards or engine != NGSPICE:
        return {"cards": None, "statistics": None}
    foundry = loaded("netlists.foundry.process:read_foundry")(cards)
    return {"cards": cards, "statistics": loaded("netlists.foundry.die:statistics_text")(foundry)}


def cards_lines(silicon: Silicon, engine: str) -> list[str]:
    """The same in lines for a reader; none for a process of our own."""
    said = describe_cards(silicon, engine)
    if said["cards"] is not None:
        die = silicon.die
        drawn = die.number is not None
        return [f"on the cards of {said['cards']}" + (f"; dies: {said['statistics']}" if drawn else "")]
    if silicon.process.cards:
        fitted = f"{silicon.process.name}: our law, fitted to the cards of {silicon.process.cards}"
        return [f"{fitted}; ngspice has the cards themselves"]
    return []
