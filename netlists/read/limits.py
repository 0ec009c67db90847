"""How much a netlist may ask of its reader: an error names each limit before memory or time runs out."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Limits:
    """The most of each thing that one netlist, its included files counted, may have.

    `size`: bytes of text; `lines`: lines; `cards`: cards of one without our notes; `card`: characters of
    a card, its continuations joined; `word`: characters of a name; `files`: files; `include_depth`: files
    inside files; `call_depth`: calls inside calls; `expression`: characters of an expression;
    `expression_depth`: brackets in brackets;
    `arithmetic`: characters of all expressions (or 40 a card of the netlist, if that is more), an eighth of
    them for one that is evaluated again; `calls`: cards read again for sub-circuits that the netlist's own
    cards call with other parameter values; `expansion`: the same for those called from sub-circuits that are
    themselves read again, which multiply from level to level; `vertices`: corners of all sources' waveforms;
    `elements`: devices, each instance of a sub-circuit counted, where they must be listed.

    The defaults keep memory below 500 MB: a card of a flat netlist takes 1.4 kB, a call with parameters of
    its own 2.7 kB, a line of a netlist with our notes 1 kB (measured).
    """

    size: int = 64 * 2**20
    lines: int = 400_000
    cards: int = 180_000
    card: int = 4_000_000
    word: int = 400
    files: int = 200
    include_depth: int = 16
    call_depth: int = 64
    expression: int = 20_000
    expression_depth: int = 32
    arithmetic: int = 1_000_000
    calls: int = 250_000
    expansion: int = 20_000
    vertices: int = 1_000_000
    elements: int = 1_000_000


DEFAULT_LIMITS = Limits()
