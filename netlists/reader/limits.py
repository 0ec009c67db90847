"""How much a netlist may ask of its reader: an error names each limit before memory or time runs out."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Limits:
    """The most of each thing that one netlist, its included files counted, may have.

    `size`: bytes of text; `lines`: lines; `card`: characters of a card, its continuations joined; `word`:
    characters of a word; `files`: files read; `include_depth`: files inside files; `call_depth`: calls inside
    calls; `expression`: characters of an expression; `expression_depth`: brackets in brackets; `expansion`:
    cards read again for sub-circuits called with other parameter values (or 40 a card of the netlist, if that
    is more); `vertices`: corners of all sources' waveforms; `elements`: devices, each instance of a
    sub-circuit counted, where they must be listed.
    """

    size: int = 64 * 2**20
    lines: int = 400_000
    card: int = 4_000_000
    word: int = 400
    files: int = 200
    include_depth: int = 16
    call_depth: int = 64
    expression: int = 20_000
    expression_depth: int = 32
    expansion: int = 10_000
    vertices: int = 1_000_000
    elements: int = 1_000_000


DEFAULT_LIMITS = Limits()
