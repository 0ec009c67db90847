"""Syntax tree of a measure -> what finds it in a run, with its unit; names and units are checked here.

A number without a unit takes that of what it stands beside in a sum, and of its parameter in a call.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Literal

from circuits.catalogue import later
from circuits.errors import ParameterError, meant, unknown_name
from circuits.measure.function import FUNCTIONS, TAKES_TRANSFERS, Absent, Arguments, Function, Parameter
from circuits.measure.grammar import MeasureError, Node, column_of
from circuits.measure.scope import Record, Scope
from circuits.measure.signal import Signal
from circuits.measure.unit import AMPERE, PLAIN, SECOND, VOLT, Unit, read_number

if TYPE_CHECKING:
    import lark
else:
    lark = later("lark")

Run = Callable[[Record], Any]  # a `Signal` or a number; raises `Absent`


@dataclass(frozen=True, slots=True)
class Typed:
    """A part of a measure: what it is, its unit, whether it is a bare number, and how it is found."""

    kind: Literal["signal", "number"]
    unit: Unit
    run: Run
    bare: bool = False  # a number that was written without a unit
    transfer: bool = False


@dataclass(frozen=True, slots=True)
class Reader:
    """Reads the parts of one measure.

    Attributes
    ----------
    text : the measure.
    scope : names that it can use.
    known : measures before it, by name.
    """

    text: str
    scope: Scope
    known: Mapping[str, Typed]

    def read(self, node: Node) -> Typed:
        """Read a part; raises `MeasureError`."""
        readers: dict[str, Callable[[Any], Typed]] = {
            "number": lambda c: self._number(c[0]),
            "name": lambda c: self._name(c[0]),
            "voltage": lambda c: self._voltage([t for t in c if t.type == "NODE"]),
            "current": lambda c: self._current(c[1]),
            "call": lambda c: self._call(c[0], c[1:]),
            "negate": lambda c: self._negated(self.read(c[-1])),
            "raise": lambda c: self._raised(node, c[0], c[-1]),
        }
        found = readers.get(str(node.data), lambda c: self._joined(node, self.read(c[0]), self.read(c[-1])))
        return found(node.children)

    def _wrong(self, node: Node | lark.Token, what: str) -> MeasureError:
        return MeasureError(self.text, column_of(node), what)

    def _text(self, node: Node | lark.Token) -> str:
        low, high = (
            (node.start_pos, node.end_pos)
            if isinstance(node, lark.Token)
            else (node.meta.start_pos, node.meta.end_pos)
        )
        return self.text[low:high]

    def _number(self, token: lark.Token) -> Typed:
        try:
            value, unit = read_number(str(token))
        except ParameterError as error:
            raise self._wrong(token, str(error)) from None
        return Typed("number", unit, lambda _: value, bare=unit == PLAIN)

    def _name(self, token: lark.Token) -> Typed:
        name = str(token)
        if name in self.known:
            if name in self.scope.nodes:
                raise self._wrong(token, f"{name}: both a node and a measure; write v({name}), or rename it")
            return self.known[name]
        if name in self.scope.nodes:
            return self._voltage([token])
        if name in self.scope.currents:
            raise self._wrong(token, f"{name}: no node; write i({name}) for its current")
        raise self._unknown("node", token, {*self.scope.nodes, *self.known})

    def _unknown(self, kind: str, token: lark.Token, known: Sequence[str] | set[str]) -> MeasureError:
        name, names = str(token), sorted(known)
        near = meant(name, names)
        what = f"{kind} {name[:80]}: unknown{near}" if near else str(unknown_name(kind, name, names))
        return self._wrong(token, what)

    def _node(self, token: lark.Token) -> str:
        if str(token) not in self.scope.nodes:
            raise self._unknown("node", token, set(self.scope.nodes))
        return str(token)

    def _voltage(self, tokens: Sequence[lark.Token]) -> Typed:
        nodes = [self._node(token) for token in tokens]

        def run(record: Record) -> Signal:
            first = record.voltage(nodes[0])
            if len(nodes) == 1:
                return first
            return first.with_value(first.value - record.voltage(nodes[1]).value)

        transfer = self.scope.transfer
        return Typed("signal", self.scope.voltage, run, transfer=transfer)

    def _current(self, token: lark.Token) -> Typed:
        name = str(token)
        if name not in self.scope.currents:
            raise self._unknown("device or source", token, set(self.scope.currents))
        transfer = self.scope.transfer
        return Typed("signal", self.scope.current, lambda record: record.current(name), transfer=transfer)

    def _negated(self, part: Typed) -> Typed:
        return replace(part, run=lambda record: _apply(lambda x, _: -x, part.run(record), 0.0))

    def _raised(self, node: Node, base_node: Node, exponent_node: Node) -> Typed:
        base, exponent = self.read(base_node), self.read(exponent_node)
        if exponent.kind == "signal" or exponent.unit != PLAIN:
            raise self._wrong(exponent_node, "an exponent must be a plain number")
        unit = PLAIN
        if base.unit != PLAIN:
            value = exponent.run(_NOTHING) if exponent.bare else math.nan
            if value != value // 1 or not abs(value) <= 9:
                raise self._wrong(
                    exponent_node, f"exponent of a number in {base.unit}, must be whole; write ^2"
                )
            unit = base.unit ** int(value)
        return Typed(
            base.kind, unit, lambda record: _apply(_power, base.run(record), exponent.run(record)),
            bare=base.bare and exponent.bare, transfer=base.transfer,
        )  # fmt: skip

    def _joined(self, node: Node, a: Typed, b: Typed) -> Typed:
        kind: Literal["signal", "number"] = "signal" if "signal" in {a.kind, b.kind} else "number"
        if node.data in {"multiply", "divide"}:
            unit = a.unit * b.unit if node.data == "multiply" else a.unit / b.unit
        else:
            unit = self._common(node, a, b)
        apply = _OPERATORS[str(node.data)]
        return Typed(
            kind, unit, lambda record: _apply(apply, a.run(record), b.run(record)),
            bare=a.bare and b.bare, transfer=a.transfer or b.transfer,
        )  # fmt: skip

    def _common(self, node: Node, a: Typed, b: Typed) -> Unit:
        if a.bare and not b.bare:
            return b.unit
        if not (b.bare or a.unit == b.unit):
            sign = "+" if node.data == "add" else "-"
            raise self._wrong(
                node.children[-1],
                f"{_said(a)} {sign} {_said(b)}, must have one unit",
            )
        return a.unit

    def _call(self, token: lark.Token, given: Sequence[Node]) -> Typed:
        name = str(token)
        if name not in FUNCTIONS:
            raise self._unknown("function", token, set(FUNCTIONS))
        function = self._chosen(name, token, given)
        parts = self._bound(name, token, function, given)
        first = next(iter(parts.values()))
        unit = first.typed.unit if first.typed else SECOND * VOLT * AMPERE if name == "energy" else VOLT
        try:
            result = function.unit(unit, self.scope.axis)
        except ValueError as error:
            raise self._wrong(token, str(error)) from None
        texts = {key: part.text for key, part in parts.items()}
        axis = self.scope.axis

        def run(record: Record) -> Any:
            values = {
                key: part.word if part.typed is None else part.typed.run(record)
                for key, part in parts.items()
            }
            given = Arguments(record, axis, values, texts, unit)
            return record.call(name, given, function.find(given))

        return Typed(function.result, result, run)

    def _chosen(self, name: str, token: lark.Token, given: Sequence[Node]) -> Function:
        """The form of a function that takes such a first argument."""
        forms = FUNCTIONS[name]
        if len(forms) == 1:
            return forms[0]
        if not given or _is_keyword(given[0]):
            raise self._wrong(
                token, f"{name}(): must have a first argument; write {usage_of(name, forms[0])}"
            )
        return forms[0] if self.read(given[0]).kind == "signal" else forms[1]

    def _bound(
        self, name: str, token: lark.Token, function: Function, given: Sequence[Node]
    ) -> dict[str, _Part]:
        """Each parameter that is given, with what stands for it, in the order of the parameters."""
        usage, by_name = usage_of(name, function), {p.name: p for p in function.parameters}
        found: dict[str, _Part] = {}
        for k, node in enumerate(given):
            if _is_keyword(node):
                key, value = node.children[0], node.children[-1]
                if str(key) not in by_name:
                    what = f"{name}() has no {key}{meant(str(key), by_name)}; write {usage}"
                    raise self._wrong(key, what)
                parameter = by_name[str(key)]
            elif k >= len(function.parameters):
                raise self._wrong(node, f"{name}(): too many arguments; write {usage}")
            elif any(map(_is_keyword, given[:k])):
                raise self._wrong(
                    node, f"{name}(): an argument without its name after one with; write {usage}"
                )
            else:
                parameter, value = function.parameters[k], node
            if parameter.name in found:
                raise self._wrong(node, f"{name}(): {parameter.name} is there twice; write {usage}")
            found[parameter.name] = self._argument(name, parameter, value, found)  # type: ignore[arg-type]
        for parameter in function.parameters:
            if not parameter.optional and parameter.name not in found:
                raise self._wrong(token, f"{name}(): must have {parameter.name}; write {usage}")
        if name == "spikes" and "level" not in found and found["signal"].word not in self.scope.watched:
            node_name = found["signal"].word
            what = f"{node_name}: not watched for spikes; give a level, as spikes({node_name}, 0.9)"
            raise self._wrong(token, what)
        return {p.name: found[p.name] for p in function.parameters if p.name in found}

    def _argument(self, name: str, p: Parameter, node: Node, before: Mapping[str, _Part]) -> _Part:
        text = self._text(node)
        if p.kind in {"node", "source", "word"} or (p.words and text in p.words):
            return _Part(None, self._word(name, p, node, text), text)
        typed = self.read(node)
        if typed.kind != p.kind:
            must = "a waveform, as v(node)" if p.kind == "signal" else "a number"
            raise self._wrong(node, f"{name}(): {p.name} {text}, must be {must}")
        if typed.transfer and name not in TAKES_TRANSFERS:
            what = f"{text}: has magnitude and phase; write mag({text}), db({text}) or phase({text})"
            raise self._wrong(node, what)
        first = next((part.typed for part in before.values()), None)
        unit = VOLT if first is None else first.unit
        wanted = {"axis": self.scope.axis, "signal": unit, "plain": PLAIN, "any": typed.unit}[p.of]
        if typed.unit != wanted and not typed.bare:
            raise self._wrong(
                node, f"{name}(): {p.name} {text} in {_unit(typed.unit)}, must be in {_unit(wanted)}"
            )
        return _Part(typed, "", text)

    def _word(self, name: str, p: Parameter, node: Node, text: str) -> str:
        if p.kind == "source" and text not in self.scope.sources:
            near = meant(text, sorted(self.scope.sources)) or "; it takes a source of voltage"
            raise self._wrong(node, f"source {text[:80]}: unknown{near}")
        if p.kind == "node":
            plain = node.children[-1] if node.data in {"name", "voltage"} else None
            inner = [c for c in node.children if getattr(c, "type", "") in {"NODE", "NAME"}]
            if plain is None or len(inner) != 1:
                raise self._wrong(node, f"{name}(): {text}, must be a node")
            return self._node(inner[0])  # type: ignore[arg-type]
        if p.kind == "word" and text not in p.words:
            listed = ", ".join(p.words)
            raise self._wrong(
                node, f"{name}(): {p.name} {text}, must be one of {listed}{meant(text, p.words)}"
            )
        return text


@dataclass(frozen=True, slots=True)
class _Part:
    """What stands for a parameter: a part of the measure, or a word."""

    typed: Typed | None
    word: str
    text: str


class _Nothing:
    """Stands for a run where none is looked at."""


_NOTHING: Any = _Nothing()


def _is_keyword(node: Node | lark.Token) -> bool:
    return isinstance(node, lark.Tree) and node.data == "keyword"


def usage_of(name: str, function: Function) -> str:
    """How a function is called, as `cross(signal, level[, direction, n, from=, to=])`."""
    needed = [p.name for p in function.parameters if not p.optional]
    others = [f"{p.name}=" if p.of == "axis" else p.name for p in function.parameters if p.optional]
    rest = f"[, {', '.join(others)}]" if others else ""
    return f"{name}({', '.join(needed)}{rest})"


def _said(part: Typed) -> str:
    return "a plain number" if part.unit == PLAIN else f"a number in {part.unit}"


def _unit(unit: Unit) -> str:
    return str(unit) or "no unit"


def _apply(operator: Callable[[Any, Any], Any], a: Any, b: Any) -> Any:
    """Apply an operator to numbers, or to signals point by point."""
    x, y = (each.value if isinstance(each, Signal) else each for each in (a, b))
    found = operator(x, y)
    signal = next((each for each in (a, b) if isinstance(each, Signal)), None)
    return float(found) if signal is None else signal.with_value(found + 0.0 * signal.value)


def _divide(a: Any, b: Any) -> Any:
    if not _all_nonzero(b):
        raise Absent("division by 0")
    return a / b


def _power(a: Any, b: Any) -> Any:
    whole = b == b // 1
    if (b < 0.0 and not _all_nonzero(a)) or not (whole or _all_positive(a)):
        raise Absent("a power that is no number")
    try:
        return a**b
    except OverflowError:
        raise Absent("a power that is too large") from None


def _all_nonzero(value: Any) -> bool:
    return bool((value != 0.0).all()) if hasattr(value, "all") else value != 0.0


def _all_positive(value: Any) -> bool:
    return bool((value >= 0.0).all()) if hasattr(value, "all") else value >= 0.0


_OPERATORS: dict[str, Callable[[Any, Any], Any]] = {
    "add": lambda a, b: a + b,
    "subtract": lambda a, b: a - b,
    "multiply": lambda a, b: a * b,
    "divide": _divide,
}
