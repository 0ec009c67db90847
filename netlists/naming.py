"""How a dialect writes our names and node references, and how they are read back.

Two different names never become the same one. A reference is a name with an index, `v_mem[3]`. Our names have
letters, digits and `_`. There are three styles:

    style         reference      index       reserved word    part of a device    other text
    hash          v_mem[1,2]     v_mem#1#2   gnd#             m1#gb               a#x20b
    underscore    v_mem[1,2]     v_mem__1__2 gnd__r           m1__gb              a__x20xb
    angle         v_mem[1,2]     v_mem<1><2> gnd<>            m1<gb>              a<x20>b

`hash` is for ngspice, where `#` is a letter. `underscore` is for dialects whose names are letters, digits and
`_` everywhere: there a `_` of ours before another `_` or at the end of the name is written `__u`, so that
`__` has one meaning. `angle` is the bus of CDL.
"""

from __future__ import annotations

import functools
import re
from collections.abc import Callable
from typing import NamedTuple

from circuits.circuit import GROUND, Shape, split_reference
from circuits.errors import TopologyError

_CACHED = 1 << 16  # names that are kept; more are made again


class Naming(NamedTuple):
    """How a dialect writes our names.

    Attributes
    ----------
    node
        Writes a reference to a node; ground stays `0`. Raises `TopologyError` for what is no reference.
    reference
        Reads a reference back that `node` wrote.
    plain
        Writes the name of a device, which has its type's letter before it, so that no name is reserved.
    part
        Writes the name of a part of a device, such as a capacitance of a transistor, from its tag.
    text
        Writes a reference, or any other text that is none.
    """

    node: Callable[[str], str]
    reference: Callable[[str], str]
    plain: Callable[[str], str]
    part: Callable[[str, str], str]
    text: Callable[[str], str]


class _Style(NamedTuple):
    """How a style writes the pieces of a name; `pieces` finds them again."""

    plain: Callable[[str], str]
    unplain: Callable[[str], str]
    mark: str  # format of what stands behind a name: an index, `r`, a part
    reserved: str
    odd: str  # format of a character's code
    indices: re.Pattern[str]


_HASH = _Style(str, str, "#{}", "#", "#x{:02x}", re.compile(r"#([0-9]+)"))
_ANGLE = _Style(str, str, "<{}>", "<>", "<x{:02x}>", re.compile(r"<([0-9]+)>"))
_UNDERSCORE = _Style(
    lambda name: re.sub(r"_(?=_|$)", "__u", name),
    lambda name: name.replace("__u", "_"),
    "__{}",
    "__r",
    "__x{:02x}x",
    re.compile(r"__([0-9]+)"),
)
_STYLES = {"hash": _HASH, "underscore": _UNDERSCORE, "angle": _ANGLE}


def make_naming(style: str, reserved: frozenset[str] = frozenset()) -> Naming:
    """Make the naming of a style.

    Parameters
    ----------
    style
        `hash`, `underscore` or `angle`; the module has a table of them.
    reserved
        Names, in lower case, that mean something else in the dialect.

    Returns
    -------
    The naming; its `node` raises `TopologyError` for a name that is no reference.
    """
    form = _STYLES[style]

    @functools.lru_cache(_CACHED)
    def node(reference: str) -> str:
        if reference == GROUND:
            return reference
        name, index = split_reference(reference)
        if not index and name.lower() in reserved:
            return form.plain(name) + form.reserved
        return form.plain(name) + "".join(form.mark.format(i) for i in index)

    def part(name: str, tag: str) -> str:
        return form.plain(name) + form.mark.format(tag)

    def text(name: str) -> str:
        try:
            return node(name)
        except TopologyError:
            return _text(form, name)

    return Naming(node, lambda name: _reference(form, name), form.plain, part, text)


def element(name: str, index: Shape) -> str:
    """Reference to one element of an array, `spike[3]`; the name alone for an index ()."""
    return f"{name}[{','.join(map(str, index))}]" if index else name


def _reference(form: _Style, name: str) -> str:
    if name == GROUND:
        return name
    bare = name.removesuffix(form.reserved)
    first = form.indices.search(bare)
    end = first.start() if first else len(bare)
    index = tuple(int(i) for i in form.indices.findall(bare[end:]))
    return element(form.unplain(bare[:end]), index)


def _text(form: _Style, name: str) -> str:
    letters = (c if c.isascii() and (c.isalnum() or c == "_") else "\0" + c for c in name)
    pieces = re.split("(\0.)", "".join(letters), flags=re.DOTALL)
    return "".join(form.odd.format(ord(p[1])) if p[:1] == "\0" else form.plain(p) for p in pieces)
