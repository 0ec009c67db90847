"""The card `.measure` of a netlist as an expression of `circuits.measure`.

    .measure tran t trig v(a) val=0.9 rise=1 targ v(b) val=0.9 fall=2
    t = cross(v(b), 0.9, fall, 2) - cross(v(a), 0.9, rise, 1)

Kinds: trig and targ, when, find at and find when, avg, max, min, pp, rms, integ, max_at, min_at, deriv, and
param over measures before it. A card of another kind is noted and not taken over: it changes no circuit.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass

from circuits.errors import DataError
from netlists.read.card import Card, shown
from netlists.read.expression.scope import Scope
from netlists.read.number import MIL_OF_EXPRESSION, read_number
from netlists.read.text.name import circuit_name

ANALYSES = ("tran", "dc", "ac")
_OVER = {
    "avg": "mean", "max": "max", "min": "min", "pp": "swing", "rms": "rms", "integ": "integral",
    "integral": "integral", "max_at": "max_at", "min_at": "min_at",
}  # fmt: skip
_DERIVATIVE = ("deriv", "derivative")
_EDGES = {"rise": "rise", "fall": "fall", "cross": "either"}
_OF_VECTORS = {"v": "", "vm": "mag", "vdb": "db", "vp": "phase", "i": ""}
_VECTOR = re.compile(r"\b([vi])\(\s*([^\s(),]+)\s*\)")
_NAMING = (".meas", ".ic", ".nodeset", ".noise")
_ASKED = re.compile(r"\b([vi])\w*\s*\(([^()]*)\)")
# a vector or a number, which stay, or a name, which may be a parameter
_NAMED = re.compile(
    r"[vi]\w*\s*\([^()]*\)|(?<![\w.])[\d.]+(?:e[+-]?\d+)?(?P<suffix>[a-z]\w*)?|(?P<name>[a-z_]\w*)(?!\w|\s*\()"
)
_PLACED = re.compile(r"\b([vi])\(([^()]*)\)")
Place = Callable[[str, str], str]  # kind of a name, `v` of a node or `i`, and the name -> its path
_WINDOW = {"from": "from", "to": "to", "td": "from"}


class Untranslated(Exception):  # noqa: N818 - no error: the card is noted
    """A card that no expression stands for; the text says why."""


@dataclass(frozen=True, slots=True)
class Measured:
    """A measure that a netlist asks for.

    Attributes
    ----------
    analysis : str
        Of which analysis: `tran`, `dc` or `ac`.
    text : str
        `NAME = EXPRESSION`, as `circuits.measure` reads it.
    """

    analysis: str
    text: str

    def placed(self, place: Place, turned: frozenset[str] = frozenset()) -> Measured:
        """Give the measure with the paths that `place` has for its names.

        turned: sources that the circuit sees from their other end, whose currents change their sign.
        """

        def moved(found: re.Match[str]) -> str:
            names = [place(found[1], name.strip()) for name in found[2].split(",")]
            told = f"{found[1]}({', '.join(names)})"
            return f"(-{told})" if found[1] == "i" and names[0] in turned else told

        return Measured(self.analysis, _PLACED.sub(moved, self.text))


@dataclass(frozen=True, slots=True)
class Asked:
    """What the cards of a netlist name: `nodes` and sources of `currents`, without the paths before."""

    nodes: frozenset[str] = frozenset()
    currents: frozenset[str] = frozenset()


def asked_of(cards: Iterable[Card]) -> Asked:
    """Give what the cards `.measure`, `.ic`, `.nodeset` and `.noise` among others name."""
    text = " ".join(card.text.lower() for card in cards if card.name().startswith(_NAMING))
    found: dict[str, set[str]] = {"v": set(), "i": set()}
    for kind, names in _ASKED.findall(text):
        found[kind].update(name.rpartition(".")[2] for name in names.replace(",", " ").split())
    return Asked(frozenset(found["v"]), frozenset(found["i"]))


def measured_of(card: Card, scope: Scope, begin: float = 0.0) -> Measured:
    """Translate a card; raises `Untranslated`, and `DataError` for a number that is none.

    begin: time from which a transient is kept, s; what is before is not measured.
    """
    words = _Words(card, scope, card.words()[1:])
    analysis, name = words.next("an analysis"), words.next("a name")
    words.begin = begin if analysis == "tran" else 0.0
    if analysis not in ANALYSES:
        raise Untranslated(f"of analysis {shown(analysis)}")
    if not name.isidentifier():
        raise Untranslated(f"the name {shown(name)} has other characters than letters, digits and _")
    kind = words.next("a kind")
    if kind in _OVER:
        vector = words.vector()
        text = f"{_OVER[kind]}({', '.join([vector, *words.options().window])})"
    elif kind in _DERIVATIVE:
        text = f"slope({words.vector()}, at={words.place()})"
    elif kind == "find":
        text = f"value({words.vector()}, at={words.place()})"
    elif kind == "when":
        text = words.crossing()
    elif kind == "trig":
        text = words.difference()
    elif kind == "param":
        words.expect("=")
        text = words.formula()
    else:
        raise Untranslated(f"kind {shown(kind)}")
    if words.left:
        raise Untranslated(f"{shown(words.left[0])} at its end")
    return Measured(analysis, f"{name} = {text}")


@dataclass(slots=True)
class _Options:
    """Named values of a part of a card."""

    window: list[str]
    edge: str = ""
    level: str = ""
    at: str = ""


@dataclass(slots=True)
class _Words:
    """What is left of a card's words."""

    card: Card
    scope: Scope
    left: list[str]
    begin: float = 0.0

    def next(self, wanted: str) -> str:
        """Take a word."""
        if not self.left:
            raise Untranslated(f"{wanted} is missing")
        return self.left.pop(0)

    def expect(self, word: str) -> None:
        """Take this word."""
        if self.next(word) != word:
            raise Untranslated(f"{word} is missing")

    def number(self) -> str:
        """Take a number, a parameter or an expression, and give its value."""
        return repr(self.scope.number(self.card, self.card.name(), self.next("a number")))

    def formula(self) -> str:
        """Take an expression of measures before it and parameters; its value where it is a number."""
        word = self.next("an expression")
        try:
            return repr(self.scope.number(self.card, self.card.name(), word))
        except DataError:
            return self._bare(word)

    def _bare(self, word: str) -> str:
        """An expression without its quotes, with the circuit's names of its nodes and parameters' values."""
        text = word[1:-1] if word[0] in "'\"{" else word

        def valued(found: re.Match[str]) -> str:
            value = self.scope.lookup(found["name"]) if found["name"] else None
            if found["suffix"]:
                value = read_number(found[0], MIL_OF_EXPRESSION)
            return found[0] if value is None else f"({value!r})" if value < 0.0 else repr(value)

        paths = {"v": _path, "i": _device_path}
        known = _NAMED.sub(valued, text.strip())
        return _VECTOR.sub(lambda found: f"{found[1]}({paths[found[1]](found[2])})", known)

    def vector(self) -> str:
        """Take `v(a)`, `v(a,b)`, `vdb(a)`, `i(device)`, or an expression in quotes."""
        word = self.next("a vector")
        if word == "par" and self.left[:1] == ["("]:
            self.expect("(")
            word = self.next("an expression")
            self.expect(")")
        if word[0] in "'\"{":
            return self._bare(word)
        if word not in _OF_VECTORS or self.left[:1] != ["("]:
            raise Untranslated(f"vector {shown(word)}")
        self.expect("(")
        names = list(self._until(")"))
        path = ", ".join(_device_path(name) if word == "i" else _path(name) for name in names)
        plain = f"i({path})" if word == "i" else f"v({path})"
        outer = _OF_VECTORS[word]
        return f"{outer}({plain})" if outer else plain

    def _until(self, end: str) -> Iterator[str]:
        while True:
            word = self.next(end)
            if word == end:
                return
            yield word

    def options(self) -> _Options:
        """Take `name=value` as long as they come."""
        found, window = _Options([]), dict[str, float]()
        while len(self.left) > 1 and self.left[1] == "=":
            name = self.next("a name")
            self.expect("=")
            if name in _EDGES:
                count = self.left[0] if self.left[:1] == ["last"] else None
                number = self.next("last") if count else f"{float(self.number()):g}"
                found.edge = f"{_EDGES[name]}, {number}"
            elif name in _WINDOW:
                window[_WINDOW[name]] = float(self.number())
            elif name == "val":
                found.level = self.number()
            elif name == "at":
                found.at = self.number()
            else:
                raise Untranslated(f"option {shown(name)}")
        if self.begin > 0.0:
            window = {"from": max(self.begin, window.pop("from", self.begin)), **window}
        found.window = [f"{name}={value!r}" for name, value in window.items()]
        return found

    def place(self) -> str:
        """Take `at=...` or `when ...`."""
        if self.left[:1] == ["when"]:
            self.next("when")
            return self.crossing()
        found = self.options()
        if not found.at:
            raise Untranslated("neither at nor when")
        return found.at

    def crossing(self) -> str:
        """Take `v(a)=level` or `v(a)=v(b)` with its options."""
        vector = self.vector()
        self.expect("=")
        if self.left[1:2] == ["("]:
            return _crossing(f"{vector} - {self.vector()}", "0", self.options())
        level = self.number()
        return _crossing(vector, level, self.options())

    def edge(self) -> str:
        """Take what follows `trig` or `targ`: a vector with its level, or a place."""
        if self.left[:2] == ["at", "="]:
            return self.options().at
        vector = self.vector()
        found = self.options()
        if not found.level:
            raise Untranslated("val is missing")
        return _crossing(vector, found.level, found)

    def difference(self) -> str:
        """Take what follows `trig`."""
        begin = self.edge()
        self.expect("targ")
        return f"{self.edge()} - {begin}"


def _crossing(vector: str, level: str, found: _Options) -> str:
    parts = [vector, level, *([found.edge] if found.edge else []), *found.window]
    return f"cross({', '.join(parts)})"


def _path(name: str) -> str:
    """Path in a circuit of a node or device by its name in a run."""
    return "0" if name == "0" else ".".join(map(circuit_name, name.split(".")))


def _device_path(name: str) -> str:
    """Path of a device by its name in a run of ngspice, `v.x1.vm`, or as it is."""
    kind, dot, rest = name.partition(".")
    is_kind = dot and len(kind) == 1 and rest.rpartition(".")[2].startswith(kind) and "." in rest
    return _path(rest if is_kind else name)
