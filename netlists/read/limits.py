"""Limits on how much a netlist may ask of its reader.

An error names the limit before memory or time runs out.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Limits:
    """The most of each thing that one netlist may have, its included files counted.

    Attributes
    ----------
    size, lines
        Bytes and lines of text.
    cards
        Cards of a netlist without our notes.
    card, word
        Characters of a card, its continuations joined, and of a name.
    files, include_depth
        Files, and files inside files.
    call_depth
        Calls inside calls.
    expression, expression_depth
        Characters of an expression, and its brackets inside brackets.
    function_calls
        Calls of a netlist's own functions in one expression, those inside them counted.
    arithmetic
        Characters of all expressions together, or 40 a card of the netlist if that is more; an expression
        that is evaluated again counts an eighth.
    calls
        Cards that are read again for sub-circuits which the netlist's own cards call with other parameter
        values.
    expansion
        Cards that are read again for sub-circuits called from others that are themselves read again: these
        multiply from level to level.
    vertices
        Corners of all sources' waveforms.
    elements
        Devices, each instance of a sub-circuit counted, where they must be listed.

    Notes
    -----
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
    function_calls: int = 1_000
    arithmetic: int = 1_000_000
    calls: int = 250_000
    expansion: int = 20_000
    vertices: int = 1_000_000
    elements: int = 1_000_000


DEFAULT_LIMITS = Limits()
