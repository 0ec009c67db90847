"""Decks run in ngspice, and their results as arrays.

A deck is text: a title, elements, `.options`, one of `.op`, `.dc` and `.tran`, then `.end`. It is run in the
library of `netlists.ngspice.library`.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any

import numpy as np

from circuits.arrays import F64
from circuits.errors import SimulatorError, unknown_name
from netlists.ngspice.deadline import DEADLINE
from netlists.ngspice.library import MESSAGE_LIMIT, simulated

_READABLE = (".op", ".dc", ".tran")
_UNREADABLE = (".ac", ".noise", ".disto", ".pz", ".sens", ".tf", ".sp", ".pss", ".control")
_AXES = ("time", "v-sweep", "i-sweep", "res-sweep", "temp-sweep")
_SUFFIXES = {"t": 1e12, "g": 1e9, "meg": 1e6, "k": 1e3, "mil": 25.4e-6, "m": 1e-3, "u": 1e-6, "n": 1e-9,
             "p": 1e-12, "f": 1e-15, "a": 1e-18, "": 1.0}  # fmt: skip
_NUMBER = re.compile(r"([+-]?(?:\d+\.?\d*|\.\d+)(?:e[+-]?\d+)?)(meg|mil|[tgkmunpfa]?)[a-z]*", re.IGNORECASE)
_STEPPING = re.compile(r"trying gmin|supplies reduced", re.IGNORECASE)


@dataclass(frozen=True, slots=True)
class Waveforms:
    """What one run left behind; T points.

    Attributes
    ----------
    analysis : str
        `op`, `dc` or `tran`.
    axis_name : str
        `time`, `v-sweep`, `i-sweep`, `res-sweep` or `temp-sweep`; empty for `op`.
    axis : float64[T]
        Time in s, or the swept quantity in its own unit; float64[0] for `op`.
    values : dict of str to float64[T]
        Lower-case node name to voltage in V, `name#branch` or `@device[i]` to current in A; T is 1 for `op`.
    steps : int
        Points stored: accepted time steps, sweep points, or 1.
    messages : tuple of str
        ngspice's notes and warnings, without the progress of its gmin and source stepping.
    """

    analysis: str
    axis_name: str
    axis: F64
    values: dict[str, F64]
    steps: int
    messages: tuple[str, ...]


def run(
    deck: str, *, vectors: tuple[str, ...] | None = None, deadline_s: float | None = DEADLINE
) -> Waveforms:
    """Run a deck of one analysis (`.op`, `.dc` or `.tran`) to its end and copy its vectors out.

    Parameters
    ----------
    deck : str
        A complete deck: the first line is the title, the last is `.end`, the stop time of `.tran` a number.
    vectors : tuple of str, optional
        Names to read, as in `Waveforms.values`; all that were saved by default.
    deadline_s : float, optional
        Wall-clock time after which the run is halted, s; `netlists.ngspice.deadline.DEADLINE` unless given,
        None for as long as it takes.

    Raises
    ------
    SimulatorError
        The library is missing, ngspice refuses the deck or gives up, the run stops before the stop time, a
        value is not finite, or the deadline passes. The library can be used again afterwards.
    UnknownNameError
        A name in `vectors` that the run did not save.
    """
    analysis, stop = _read_analysis(deck)
    with simulated(deck, deadline_s) as library:
        waveforms = _read_plot(library, analysis, vectors)
    _check_complete(waveforms, stop)
    return waveforms


def run_for_pyspice(deck: str, simulation: Any, *, deadline_s: float | None = DEADLINE) -> Any:
    """Run a deck of any one analysis and return its results as PySpice's `Plot` of `simulation`.

    Raises
    ------
    SimulatorError
        As `run`; whether values are finite and the stop time was reached is not looked at.
    """
    with simulated(deck, deadline_s) as library:
        return library.plot(simulation, library.current_plot())


def _read_analysis(deck: str) -> tuple[str, float | None]:
    """Return the analysis' name and, of a transient, its stop time in s; refuse what cannot be checked."""
    cards = [card for card in _cards(deck) if card[0] in (*_READABLE, *_UNREADABLE)]
    if not deck.rstrip().lower().endswith("\n.end"):
        raise SimulatorError("deck: no .end, must be the last line; add it")
    if len(cards) != 1 or cards[0][0] not in _READABLE:
        names = ", ".join(card[0] for card in cards) or "none"
        raise SimulatorError(f"deck.analysis: {names}, must be one of .op, .dc, .tran; split the deck")
    name, *arguments = cards[0]
    if name != ".tran":
        return name[1:], None
    number = _NUMBER.fullmatch(arguments[1]) if len(arguments) > 1 else None
    if number is None:
        raise SimulatorError(f"deck.tran: {' '.join(cards[0])}, stop time must be a number; write its value")
    return name[1:], float(number.group(1)) * _SUFFIXES[number.group(2).lower()]


def _cards(deck: str) -> list[list[str]]:
    """Return the words of each card after the title, continuation lines folded in, comments dropped."""
    cards: list[list[str]] = []
    for line in deck.splitlines()[1:]:
        words = re.split(r";|\$ ", line, maxsplit=1)[0].lower().split()
        if not words or words[0].startswith("*"):
            continue
        if words[0].startswith("+") and cards:
            cards[-1] += " ".join(words)[1:].split()
        else:
            cards.append(words)
    return cards


def _read_plot(library: Any, analysis: str, vectors: tuple[str, ...] | None) -> Waveforms:
    plot = library.current_plot()
    if plot.rstrip("0123456789") != analysis:
        said = " ".join(" ".join(library.errors).split())[:MESSAGE_LIMIT]
        raise SimulatorError(f"ngspice: no {analysis} result ({said}); check .save and the analysis line")
    names = {node_name(name): name for name in reversed(library.vector_names(plot))}
    axis_name = next((name for name in _AXES if name in names), "") if analysis != "op" else ""
    axis = library.copy_vector(plot, names.pop(axis_name)) if axis_name else np.empty(0)
    chosen = names if vectors is None else vectors
    missing = [name for name in chosen if name not in names]
    if missing:
        raise unknown_name("vector", missing[0], names)
    values = {name: library.copy_vector(plot, names[name]) for name in chosen}
    return Waveforms(analysis, axis_name, axis, values, len(axis) if axis_name else 1, _messages(library))


def node_name(name: str) -> str:
    """Return `x` of `V(x)`, which ngspice writes for nodes that begin with a digit."""
    found = re.fullmatch(r"v\((.+)\)", name.lower())
    return found.group(1) if found else name.lower()


def _messages(library: Any) -> tuple[str, ...]:
    noted = [line for line in library.output if line.startswith(("Note", "Warning"))]
    told = [line.strip() for line in [*noted, *library.errors]]
    return tuple(line for line in told if line and not _STEPPING.match(line))


def _check_complete(waveforms: Waveforms, stop: float | None) -> None:
    for name, values in waveforms.values.items():
        if len(values) != waveforms.steps or not np.isfinite(values).all():
            raise SimulatorError(f"ngspice.{name}: not finite or cut short; check what drives it")
    if stop is None:
        return
    reached = float(waveforms.axis[-1]) if len(waveforms.axis) else 0.0
    if reached < stop * (1 - 1e-9):
        raise SimulatorError(f"ngspice: stopped at {reached} s, must reach {stop} s; check reltol and tmax")
