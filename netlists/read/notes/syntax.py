"""What a reader of notes must see in a dialect: definitions, calls, plain devices, and the cards about a run.

The SPICE family differs in its names only (`netlists.naming`), which the dialect itself reads back. A
plain device, which needs no note, is a resistor, capacitor or linear controlled source whose name is no part
of another device's.
"""

from __future__ import annotations

import functools
import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from circuits.devices import Capacitor, ControlledSource, Device, Resistor
from circuits.errors import ParameterError
from circuits.silicon.silicon import Silicon
from circuits.testbench import Testbench
from netlists.read.analysis import Controls, OperatingPoint, Transient, read_controls, read_option
from netlists.read.card import Card, shown
from netlists.read.expression.scope import Scope
from netlists.read.limits import DEFAULT_LIMITS, Limits
from netlists.read.note import Notes
from netlists.read.number import read_number
from netlists.read.text.lines import joined, spectre_line, spice_line, verilog_line
from netlists.registry import Dialect, Settings, dialect_names, load_dialect

_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
_READ_OF_SPECTRE = {"stop", "maxstep", "temp", "lang", "skipdc"}
_CIRCUIT_CARDS = {".subckt", ".ends", ".nodeset", ".ic", ".model"}
_MODULE = re.compile(r"module ([A-Za-z_]\w*)\(")  # the testbench's has no ports
_MODULE_INSTANCE = re.compile(r"([A-Za-z_]\w*) (x\w+)\(")

_Make = Callable[[str, list[str], float], Device]
_MAKERS: dict[str, tuple[int, _Make]] = {
    "r": (2, lambda name, n, value: Resistor(name, n[0], n[1], value)),
    "c": (2, lambda name, n, value: Capacitor(name, n[0], n[1], value)),
    "g": (4, lambda name, n, value: ControlledSource(name, n[0], n[1], n[2], n[3], value)),
}


def _charged(card: Card, device: Device, begin: str) -> Device:
    """The capacitor with its initial voltage."""
    voltage = read_number(begin)
    if voltage is None or not isinstance(device, Capacitor):
        raise card.error(f"{shown(card.text)}: ic must be a number, of a capacitor; write the netlist again")
    return replace(device, ic=voltage)


@dataclass(frozen=True, slots=True)
class Syntax(ABC):
    """A dialect as a reader of notes sees it."""

    dialect: Dialect

    def write(
        self, testbench: Testbench, silicon: Silicon, models: str, parasitics: Mapping[str, float]
    ) -> Iterator[Card]:
        """Cards of the netlist that would be written."""
        settings = Settings(models=models, nodes=(), parasitics=parasitics)
        return self.cards(self.dialect.write(testbench, silicon, settings))

    def plain_name(self, name: str) -> str | None:
        """Our name of a device by its name without its letter, None for a part of one."""
        own = self.dialect.naming.reference(name)
        return own if _NAME.fullmatch(own) and self.dialect.naming.plain(own) == name else None

    @abstractmethod
    def cards(self, text: str) -> Iterator[Card]:
        """Cards of a netlist in this dialect."""

    @abstractmethod
    def opened(self, card: Card) -> str | None:
        """Name of the definition that a card opens, in lower case."""

    @abstractmethod
    def closes(self, card: Card) -> bool:
        """Whether a card closes a definition."""

    @abstractmethod
    def is_control(self, card: Card) -> bool:
        """Whether a card is about the run and not about the circuit."""

    @abstractmethod
    def called(self, card: Card) -> tuple[str, str] | None:
        """Name and definition of a call, None for a card that is none."""

    @abstractmethod
    def simple(self, card: Card) -> Device | None:
        """Device of a card that needs no note, None for a card that is none."""

    @abstractmethod
    def run(self, cards: Sequence[Card], limits: Limits, notes: Notes) -> Controls:
        """What the cards about the run say."""

    def _device(
        self, card: Card, name: str, nodes: Sequence[str], value: str, begin: str | None
    ) -> Device | None:
        own = self.plain_name(name[1:])
        if own is None:
            return None
        count, make = _MAKERS[name[0].lower()]
        number = read_number(value)
        if number is None or len(nodes) != count:
            raise card.error(
                f"{shown(card.text)}: must be {count} nodes and a number; write the netlist again"
            )
        try:
            made = make(own, [self.dialect.naming.reference(node) for node in nodes], number)
        except ParameterError as error:
            raise card.error(str(error)) from None
        return made if begin is None else _charged(card, made, begin)


@dataclass(frozen=True, slots=True)
class SpiceSyntax(Syntax):
    """The SPICE family: cards that begin with a letter or a dot."""

    def cards(self, text: str) -> Iterator[Card]:
        """Cards behind the title line."""
        return joined(text.partition("\n")[2], self.dialect.name, 2, DEFAULT_LIMITS.size, spice_line)

    def opened(self, card: Card) -> str | None:
        """See `Syntax`."""
        words = card.text.split(maxsplit=2)
        return words[1].lower() if words[0].lower() == ".subckt" and len(words) > 1 else None

    def closes(self, card: Card) -> bool:
        """See `Syntax`."""
        return card.text[:5].lower() == ".ends"

    def is_control(self, card: Card) -> bool:
        """See `Syntax`."""
        return card.text[0] == "." and card.text.split(maxsplit=1)[0].lower() not in _CIRCUIT_CARDS

    def called(self, card: Card) -> tuple[str, str] | None:
        """See `Syntax`."""
        words = [word for word in card.text.split() if "=" not in word]
        return (words[0], words[-1].lower()) if card.text[0] in "xX" else None

    def simple(self, card: Card) -> Device | None:
        """See `Syntax`."""
        name, *words = card.text.split()
        if name[0].lower() not in _MAKERS or not words or set("'{") & set(card.text):
            return None
        begin = words.pop().partition("=")[2] if words[-1].lower().startswith("ic=") else None
        return self._device(card, name, words[:-1], words[-1] if words else "", begin)

    def run(self, cards: Sequence[Card], limits: Limits, notes: Notes) -> Controls:
        """See `Syntax`."""
        return read_controls(cards, Scope(limits), notes)


@dataclass(frozen=True, slots=True)
class SpectreSyntax(Syntax):
    """Spectre: `name (nodes) master parameter=value`."""

    def cards(self, text: str) -> Iterator[Card]:
        """See `Syntax`."""
        return joined(text, self.dialect.name, 1, DEFAULT_LIMITS.size, spectre_line)

    def opened(self, card: Card) -> str | None:
        """See `Syntax`."""
        words = card.text.split(maxsplit=2)
        return words[1].lower() if words[0] == "subckt" and len(words) > 1 else None

    def closes(self, card: Card) -> bool:
        """See `Syntax`."""
        return card.text.split(maxsplit=1)[0] == "ends"

    def is_control(self, card: Card) -> bool:
        """See `Syntax`."""
        words = card.text.split(maxsplit=2)
        return words[0] in {"simulator", "save"} or (len(words) > 1 and words[1] in {"options", "tran", "dc"})

    def called(self, card: Card) -> tuple[str, str] | None:
        """See `Syntax`."""
        words = card.text.split()
        return (words[0], words[-1].lower()) if card.text[0] == "x" else None

    def simple(self, card: Card) -> Device | None:
        """See `Syntax`."""
        name, *words = card.text.replace("(", " ( ").replace(")", " ) ").split()
        begin = words.pop().partition("=")[2] if words and words[-1].startswith("ic=") else None
        if name[0] not in _MAKERS or len(words) < 3 or words[0] != "(" or words[-3] != ")":
            return None
        return self._device(card, name, words[1:-3], words[-1].partition("=")[2], begin)

    def run(self, cards: Sequence[Card], limits: Limits, notes: Notes) -> Controls:
        """See `Syntax`."""
        controls, scope = Controls(), Scope(limits)
        for card in cards:
            kind = [*card.text.split(maxsplit=2), ""][1]
            pairs = (word.partition("=") for word in card.text.split())
            given = {name: value for name, sign, value in pairs if sign}
            if kind == "tran" and {"stop", "maxstep"} <= set(given):
                step, stop = (scope.number(card, key, given[key]) for key in ("maxstep", "stop"))
                uic = given.get("skipdc") == "yes"
                controls.analyses.append(Transient(step, stop, uic=uic))
            elif kind == "dc":
                controls.analyses.append(OperatingPoint())
            elif kind == "options" and "temp" in given:
                controls.temperature_c = scope.number(card, "temp", given["temp"])
            elif card.text.split(maxsplit=1)[0] != "simulator":
                notes.add(f"{shown(card.text.split(maxsplit=1)[0])} statement", card.place)
            for name in given:
                if name not in _READ_OF_SPECTRE:
                    read_option(name.lower(), card, notes)
        return controls


@dataclass(frozen=True, slots=True)
class VerilogSyntax(Syntax):
    """Verilog-A: a line a card; every device has its note, and the module `testbench` is none of ours."""

    def cards(self, text: str) -> Iterator[Card]:
        """See `Syntax`."""
        return joined(text, self.dialect.name, 1, DEFAULT_LIMITS.size, verilog_line)

    def opened(self, card: Card) -> str | None:
        """See `Syntax`."""
        found = _MODULE.match(card.text)
        return found.group(1).lower() if found else None

    def closes(self, card: Card) -> bool:
        """See `Syntax`."""
        return card.text == "endmodule"

    def is_control(self, card: Card) -> bool:
        """See `Syntax`: there is nothing about a run."""
        return False

    def called(self, card: Card) -> tuple[str, str] | None:
        """See `Syntax`."""
        found = _MODULE_INSTANCE.match(card.text)
        return (found.group(2), found.group(1).lower()) if found else None

    def simple(self, card: Card) -> Device | None:
        """See `Syntax`: none is without its note."""
        return None

    def run(self, cards: Sequence[Card], limits: Limits, notes: Notes) -> Controls:
        """See `Syntax`."""
        return Controls()


@functools.cache
def syntax_of(dialect: str) -> Syntax | None:
    """Syntax of a dialect that can be read by its notes, None for others."""
    if dialect not in dialect_names():
        return None
    found = load_dialect(dialect)
    syntax: Syntax = (found.syntax or SpiceSyntax)(found)
    return syntax
