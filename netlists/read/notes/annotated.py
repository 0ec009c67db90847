"""Netlists that were written here, read back by their structured comments.

They give the circuit, the testbench and the silicon. The notes (`netlists.write.annotation`) say what circuit
each definition writes, down to arrays and kinds of
biases; resistors, capacitors and linear controlled sources are read from their lines. What was read is then
written again, and card after card must be the same text but for the last digits of numbers (1e-9), so that a
line that was edited under its note is refused with its place instead of being believed. Cards about the run
(`.tran`, `.options`, `.save`) may differ, as long as stop time and temperature are those of the notes.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from circuits.circuit import Bias, Circuit, Node, Port
from circuits.devices import Capacitor, Device, Diode, Source
from circuits.errors import CircuitError, DataError, ParameterError
from circuits.silicon.silicon import Change, Deviation, Silicon
from circuits.testbench import Testbench
from netlists.naming import element
from netlists.read.card import Card, shown
from netlists.read.limits import Limits
from netlists.read.notes.rebuild import Build, Called, Definition
from netlists.read.notes.syntax import Syntax
from netlists.read.notes.verify import verify
from netlists.read.text.lines import ANNOTATION
from netlists.write.annotation import (
    Annotation,
    ArrayNote,
    BenchNote,
    Biased,
    ChangeNote,
    CircuitName,
    Header,
    InstanceNote,
    LocalDeviation,
    ParameterNote,
    Parasitic,
    SourceNote,
    parse_annotation,
    to_silicon,
    to_source,
)

_SILICON = {"process", "variation", "components", "diodes", "nmos", "pmos", "silicon", "die", "plan"}
_WAVEFORMS = {"constant", "pulse", "polyline", "sampled", "driven"}


@dataclass(frozen=True, slots=True)
class Annotated:
    """A netlist with notes: header, testbench, silicon, deviations and parasitics by path, the run."""

    header: Header
    testbench: Testbench
    silicon: Silicon
    deviations: dict[str, Deviation | Change]
    parasitics: dict[str, float]
    controls: tuple[Card, ...]


@dataclass(slots=True)
class _Contents:
    """What has been read so far; `here` is the definition at hand, `shift` waits for its device."""

    syntax: Syntax
    header: Header | None = None
    silicon: list[Annotation] = field(default_factory=list)
    definitions: dict[str, Definition] = field(default_factory=dict)
    here: Definition | None = None
    shift: Deviation | Change | None = None
    as_made: bool = False  # whether what comes next says again a device that a note said as drawn
    is_parasitic: bool = False  # the next device
    bench: BenchNote | None = None
    top: str | None = None
    source: SourceNote | None = None
    sources: list[Source] = field(default_factory=list)
    controls: list[Card] = field(default_factory=list)


def header_card(cards: Sequence[Card]) -> Card | None:
    """Card of our header, the first or, after Spectre's choice of language, the second; None without one."""
    for card in cards[:2]:
        if card.text.split()[:2] == [ANNOTATION, "noctule"]:
            return card
    return None


def read_annotated(cards: Sequence[Card], syntax: Syntax, limits: Limits) -> Annotated:
    """Read cards with notes; raises `DataError` for a note or line that is not as we write it."""
    contents = _Contents(syntax)
    for card in cards:
        if card.text.startswith(ANNOTATION):
            _note(contents, card)
        else:
            _line(contents, card)
    if contents.here is not None:
        raise contents.here.card.error(f"{shown(contents.here.name)}: definition not closed; write .ends")
    silicon, bench = _bench(contents, cards[0], limits)
    header, parasitics = contents.header, _parasitics(contents, limits)
    if header is None:
        raise cards[0].error("no noctule note; write the netlist again")
    try:
        written = syntax.write(bench, silicon, header.models, parasitics)
    except (ArithmeticError, LookupError, TypeError, ValueError) as error:  # figures that no law takes
        raise cards[0].error(
            f"its notes cannot be written again ({shown(str(error))}); correct them"
        ) from None
    verify(cards, written, syntax)
    top = contents.definitions[contents.top or ""]
    deviations = dict(_deviations(contents, top, ""))
    return Annotated(header, bench, silicon, deviations, parasitics, tuple(contents.controls))


def _note(contents: _Contents, card: Card) -> None:
    try:
        note = parse_annotation(card.text.removeprefix(ANNOTATION))
    except CircuitError as error:
        raise card.error(str(error)) from None
    if contents.source is not None and note.kind not in _WAVEFORMS:
        raise card.error("a source note without its waveform before this; write the netlist again")
    if note.kind in _SILICON:
        contents.silicon.append(note)
    elif not _taken_at_top(contents, card, note):
        if contents.here is None:
            raise card.error(f"note {note.kind} outside a definition; write the netlist again")
        _definition_note(contents, contents.here, card, note.value)


def _taken_at_top(contents: _Contents, card: Card, note: Annotation) -> bool:
    try:
        return _top_note(contents, card, note)
    except ParameterError as error:
        raise card.error(str(error)) from None


def _top_note(contents: _Contents, card: Card, note: Annotation) -> bool:
    """Take a note of the top level; returns whether it is one."""
    match note.value:
        case Header() as header:
            contents.header = header
        case BenchNote() as bench:
            contents.bench = bench
        case SourceNote() as source:
            contents.source = source
        case Biased():
            pass
        case waveform if note.kind in _WAVEFORMS:
            if contents.source is None:
                raise card.error("a waveform without its source before it; write the netlist again")
            contents.sources.append(to_source(contents.source, waveform))
            contents.source = None
        case _:
            return False
    return True


def _definition_note(contents: _Contents, here: Definition, card: Card, value: Any) -> None:
    match value:
        case CircuitName():
            here.circuit = value.name
        case Port() | Node() | Bias():
            kept: dict[type, list[Any]] = {Port: here.ports, Node: here.nodes, Bias: here.biases}
            kept[type(value)].append(value)
        case LocalDeviation():
            contents.shift = Deviation(value.v_t0, value.beta)
        case ChangeNote():
            contents.shift = Change(value.value)
        case InstanceNote() | ArrayNote():
            here.called.append(Called(card, value))
        case ParameterNote() if here.called:
            here.called[-1].parameters.append(value)
        case Parasitic():
            contents.is_parasitic = True
        case Device():
            _simple(contents, here, value)
            if contents.shift is not None:
                here.deviations[value.name] = contents.shift
                # a diode's line is none that is read
                contents.as_made = isinstance(contents.shift, Change) and not isinstance(value, Diode)
            contents.shift = None
        case _:
            raise card.error("a note where it means nothing; write the netlist again")


def _line(contents: _Contents, card: Card) -> None:
    syntax, here = contents.syntax, contents.here
    opened = syntax.opened(card)
    if opened is not None:
        if here is not None:
            raise card.error("a definition inside another; write the netlist again")
        if opened in contents.definitions:
            raise card.error(f"{shown(opened)}: duplicate definition; rename one")
        contents.here = contents.definitions[opened] = Definition(card, opened)
    elif syntax.closes(card):
        contents.here = None
    elif syntax.is_control(card):
        contents.controls.append(card)
    elif (call := syntax.called(card)) is not None:
        _call(contents, card, call)
    elif here is not None:
        simple = syntax.simple(card)
        if simple is not None:  # any other line must be what a note writes, which writing it again shows
            _simple(contents, here, simple)


def _simple(contents: _Contents, here: Definition, device: Device) -> None:
    if contents.as_made:  # its line, or the dialect's own note, which say it as it is made
        contents.as_made = False
    elif contents.is_parasitic and isinstance(device, Capacitor):
        here.parasitics.append(device)
    else:
        here.devices.append(device)
    contents.is_parasitic = False


def _call(contents: _Contents, card: Card, call: tuple[str, str]) -> None:
    called = contents.definitions.get(call[1])
    if contents.here is not None and called is not None and not called.circuit:
        return  # a black box of the dialect's own, which stands for the device of the note before it
    if contents.here is None:
        if contents.top is not None:
            raise _unnoted(card)
        contents.top = call[1]
    elif not contents.here.called:
        raise _unnoted(card)
    else:
        contents.here.called[-1].calls.append(call)


def _unnoted(card: Card) -> DataError:
    remedy = "add its note, or remove the noctule note to read the netlist without notes"
    return card.error(f"{shown(card.text)}: not what the notes say that stands here; {remedy}")


def _bench(contents: _Contents, first: Card, limits: Limits) -> tuple[Silicon, Testbench]:
    """Silicon and testbench that the notes say, not yet held against the lines."""
    if contents.bench is None or contents.header is None or not contents.definitions:
        raise first.error("no testbench note, or no definition; write the netlist again")
    if contents.top is None:  # a dialect without sources calls nothing
        contents.top = list(contents.definitions)[-1]
    bench = contents.bench
    circuit = Build(contents.definitions, limits).circuit(contents.top, first)
    if _extent(circuit, {}) > limits.elements:
        raise first.error(f"more than {limits.elements} devices and nodes, the limit; split the netlist")
    try:
        silicon = to_silicon(contents.silicon)
        testbench = Testbench(
            bench.title, circuit, tuple(contents.sources), bench.stop, bench.watch, dict(bench.start),
            dict(bench.initial), bench.begin,
        )  # fmt: skip
    except CircuitError as error:
        raise first.error(str(error)) from None
    return silicon, testbench


def _extent(circuit: Circuit, known: dict[int, int]) -> int:
    """Devices and declared nodes of a circuit, each instance counted, without listing them."""
    if id(circuit) not in known:
        own = len(circuit.devices) + sum(math.prod(shape) for shape in circuit.shapes().values())
        inside = sum(math.prod(i.shape) * (1 + _extent(i.circuit, known)) for i in circuit.instances)
        known[id(circuit)] = own + inside
    return known[id(circuit)]


def _deviations(
    contents: _Contents, definition: Definition, prefix: str
) -> Iterator[tuple[str, Deviation | Change]]:
    """Deviations by instance path; the calls are known to be those of a circuit."""
    for name, deviation in definition.deviations.items():
        yield prefix + name, deviation
    for inner, name in _calls(definition, prefix):
        yield from _deviations(contents, contents.definitions[name], inner)


def _parasitics(contents: _Contents, limits: Limits) -> dict[str, float]:
    """Capacitances to ground by node path, from wherever their definitions are called."""
    found: dict[str, float] = {}
    if contents.top is None or not any(d.parasitics for d in contents.definitions.values()):
        return found
    waiting = [(contents.top, "")]
    seen = 0
    while waiting:
        name, prefix = waiting.pop()
        definition, seen = contents.definitions.get(name), seen + 1
        if definition is None or seen > limits.elements or prefix.count(".") > limits.call_depth:
            raise contents.definitions[contents.top].card.error(
                "its calls do not end; write the netlist again"
            )
        found |= {prefix + c.a: c.capacitance for c in definition.parasitics}
        waiting += [(called, inner) for inner, called in _calls(definition, prefix)]
    return found


def _calls(definition: Definition, prefix: str) -> Iterator[tuple[str, str]]:
    """Path with a dot at its end, and definition, of each call in a definition."""
    for called in definition.called:
        shape = () if isinstance(called.note, InstanceNote) else called.note.shape
        for index, (_, name) in zip(np.ndindex(shape), called.calls, strict=True):
            yield f"{prefix}{element(called.note.name, index)}.", name
