"""A netlist read from a file or a text: the circuit and the testbench that it describes.

The command `noctule import` reads with it.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import inf, isclose
from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np

from circuits.circuit import GROUND, Circuit, references
from circuits.devices import Source
from circuits.errors import DataError, unknown_name
from circuits.measure.branch import is_followed
from circuits.silicon.silicon import Change, Deviation, Silicon
from circuits.testbench import Begin, Testbench
from netlists.read.analysis import (
    Analysis,
    Controls,
    NoiseSpectrum,
    Stepped,
    read_controls,
    stepped_parameters,
)
from netlists.read.card import Card, shown
from netlists.read.elaboration import Elaboration, Top
from netlists.read.element import NOMINAL_C
from netlists.read.expression.expression import Functions, bare
from netlists.read.expression.scope import Expressions, Scope
from netlists.read.limits import DEFAULT_LIMITS, Limits
from netlists.read.measure import Measured, Place, asked_of
from netlists.read.note import Foreign, Note, Notes, drop_names
from netlists.read.notes.annotated import header_card, read_annotated
from netlists.read.notes.syntax import syntax_of
from netlists.read.number import MIL_OF_EXPRESSION, read_number
from netlists.read.text.lines import ANNOTATION, Text, read_text
from netlists.read.text.name import circuit_name, is_ground, original_name
from netlists.read.text.section import Deck, declare, read_deck, sections

DIALECTS = ("spice", "ngspice", "hspice", "xyce", "cdl")  # that a netlist without our notes may be in


@dataclass(frozen=True, slots=True)
class Imported:
    """What a netlist says.

    Attributes
    ----------
    testbench
        Circuit, sources and stop time.
    analyses
        Transients, operating points and sweeps in the order of their cards.
    deviations
        Deviations of the transistors that deviate, and changes of the capacitors and resistors that a die
        changes, by instance path.
    notes
        What was not taken over and changes no circuit.
    names
        The netlist's own name, in lower case, of each name that had to be changed.
    temperature_c
        Temperature of `.temp` or of the options, degC; None where the netlist states none.
    dialect
        The dialect as which it was read.
    models
        What the transistors of a netlist that we wrote are, `ekv` or `bsim3`; None for other netlists.
    silicon
        Process, die and temperature that such a netlist was written for; None for other netlists.
    parasitics
        Capacitances to ground, F, by node path, that were merged into such a netlist and are no part of the
        circuit.
    dropped
        What would have changed the circuit, and was left out because `drop` names it.
    foreign
        Cards for ngspice only, which the circuit lacks; none unless `foreign="kept"` was asked for.
    measures
        Measures that it asks for, as expressions of `circuits.measure`.
    turned
        Sources whose sign is turned, since the circuit has them from ground to a node.
    moved
        AC value, V or A, of each source that has one, into its node, by the source's name.
    steps
        What the netlist steps, in the order of its cards.
    parameters
        Value of each `.param` of the whole netlist that is given as a number, and of each that it steps.
    """

    testbench: Testbench
    analyses: tuple[Analysis, ...] = ()
    deviations: Mapping[str, Deviation | Change] = field(default_factory=dict)
    notes: tuple[Note, ...] = ()
    names: Mapping[str, str] = field(default_factory=dict)
    temperature_c: float | None = None
    dialect: str = "spice"
    models: str | None = None
    silicon: Silicon | None = None
    parasitics: Mapping[str, float] = field(default_factory=dict)
    dropped: tuple[Note, ...] = ()
    foreign: tuple[Foreign, ...] = ()
    measures: tuple[Measured, ...] = ()
    turned: frozenset[str] = frozenset()
    moved: Mapping[str, complex] = field(default_factory=dict)
    steps: tuple[Stepped, ...] = ()
    parameters: Mapping[str, float] = field(default_factory=dict)

    @property
    def circuit(self) -> Circuit:
        """The testbench's circuit."""
        return self.testbench.circuit


def read_netlist(
    source: Path | str,
    *,
    root: Path | None = None,
    dialect: str | None = None,
    limits: Limits = DEFAULT_LIMITS,
    drop: Iterable[str] = (),
    foreign: Literal["refused", "kept"] = "refused",
    parameters: Mapping[str, float] | None = None,
) -> Imported:
    """Read a netlist from a file, or from a text; no code in it is run.

    Parameters
    ----------
    source
        A file's `Path`, or the netlist itself as text of several lines.
    root
        Folder that all files must lie in, links resolved; the file's own by default. A text includes files
        only where it is given.
    dialect
        Of a netlist without our notes: one of `DIALECTS`, `spice` by default. Notes say it themselves.
    limits
        How much a netlist may ask for.
    drop
        What may go of all that cannot be honoured and would change the circuit: names of models whose
        parameters are left out (`.model` for all), cards as `.step`, options as `scale`, parameters of
        elements as `tc1`. What went is in `dropped`.

    foreign
        Whether cards that ngspice has and a circuit of ours cannot hold are refused, or kept as text for
        ngspice; the circuit then lacks them.
    parameters
        Values in the place of those of the netlist's own `.param` cards, by name in lower case, in the units
        that the netlist has them in.

    Raises
    ------
    DataError
        `file:line: what is wrong; what to try`, for anything that cannot be read in full; a text of one line.
    UnknownNameError
        A dialect that is not known.
    """
    if dialect is not None and dialect not in DIALECTS:
        raise unknown_name("dialect", dialect, DIALECTS)
    if isinstance(source, str) and "\n" not in source:
        raise DataError(
            f'netlist:1: "{shown(source)}", a netlist has a title and cards in lines below it; of a file give'
            " its Path, read_netlist(Path(...))"
        )
    with np.errstate(all="ignore"):  # what overflows is refused where it is used, not warned of
        notes = Notes(drop_names(drop), foreign == "kept")
        return _read(source, root, dialect, limits, notes, parameters or {})


def _read(
    source: Path | str,
    root: Path | None,
    dialect: str | None,
    limits: Limits,
    notes: Notes,
    parameters: Mapping[str, float],
) -> Imported:
    text = read_text(source, root, limits, notes, has_title=dialect != "cdl")
    header = header_card(text.cards)
    if header is not None:
        return _annotated(header, text, limits, notes)
    if text.language != "spice":
        place = text.cards[0].place if text.cards else "netlist:1"
        raise DataError(f"{place}: {text.language} without our notes is not read; write it as SPICE")
    cards = [card for card in text.cards if not card.text.startswith(ANNOTATION)]
    if len(cards) < len(text.cards):
        first = next(card for card in text.cards if card.text.startswith(ANNOTATION))
        notes.add(
            "structured comment without a noctule note first", first.place, len(text.cards) - len(cards)
        )
    if len(cards) > limits.cards:
        raise cards[limits.cards].error(f"more than {limits.cards} cards, the limit; split the netlist")
    deck = read_deck(text.title, cards, notes)
    expressions = Expressions(limits, deck.size, functions=Functions(deck.functions))
    scope = Scope(limits, values=dict(parameters), expressions=expressions)
    own = _parameters(deck, scope, cards)
    scope.define(deck.top.parameters, notes)
    _declare_conditional(deck, scope, notes)
    controls = read_controls(deck.controls, scope, notes)
    uses_ic = controls.uic or dialect == "xyce"  # which takes them without uic, too
    nominal_c = NOMINAL_C if controls.nominal_c is None else controls.nominal_c
    asked = asked_of([*deck.controls, *(c for each in sections(deck.top) for c in each.voltages)])
    is_cdl = dialect == "cdl"
    elaboration = Elaboration(deck, scope, controls.span, limits, notes, is_cdl, uses_ic, nominal_c, asked)
    top = elaboration.top()
    if top.part.elements > limits.elements:
        raise deck.top.card.error(f"{top.part.elements} elements, the limit is {limits.elements}; split it")
    separator = ":" if dialect == "xyce" else "."  # in the name of a node of an instance
    bench = _testbench(text.title, top, controls, limits, notes, separator)
    driven = {source.name for source in bench.sources}
    path_of = _place(top, bench.sources)
    return Imported(
        bench,
        tuple(_placed(each, path_of) for each in controls.analyses),
        dict(top.part.all_deviations()),
        notes.all(),
        _names(bench.circuit),
        controls.temperature_c,
        dialect or "spice",
        dropped=notes.dropped(),
        foreign=notes.foreign(),
        measures=tuple(each.placed(path_of, top.turned) for each in controls.measures),
        turned=top.turned,
        moved={name: top.moved[name] for name in top.moved if name in driven},
        steps=tuple(controls.steps),
        parameters=own,
    )


def _parameters(deck: Deck, scope: Scope, cards: Sequence[Card]) -> dict[str, float]:
    """Parameters that can be given other values: those that are numbers, and those that are stepped.

    A parameter that is stepped and given nowhere gets its first value in `scope`. Raises `DataError` for one
    that no card uses.
    """
    texts = {name: text for name, (text, _) in deck.top.parameters.items()}
    numbers = {name: read_number(bare(text), MIL_OF_EXPRESSION) for name, text in texts.items()}
    stepped = stepped_parameters(deck.controls, scope)
    for name in sorted(stepped.keys() - texts.keys()):
        _require_use(name, cards)
        scope.values.setdefault(name, stepped[name])
    found = {name: value for name, value in numbers.items() if value is not None}
    return found | {name: value for name, value in stepped.items() if name not in texts}


def _require_use(name: str, cards: Sequence[Card]) -> None:
    """Raise `DataError` for a stepped parameter that stands behind the first word of no other card."""
    steps = [card for card in cards if card.name() == ".step"]
    word = re.compile(rf"\b{re.escape(name)}\b")
    if not any(word.search(c.text.lower().partition(" ")[2]) for c in cards if c not in steps):
        own = next(card for card in steps if name in card.words())
        raise own.error(f".step param {shown(name)}: nothing uses it; write {{{shown(name)}}} in an element")


def _declare_conditional(deck: Deck, scope: Scope, notes: Notes) -> None:
    """Take the declarations under `.if` whose conditions hold, one after the other."""
    for card, conditions in deck.conditional:
        if scope.holds(conditions):
            declare(deck, deck.top, card, notes)
            scope.define(deck.top.parameters, notes)


def _annotated(header: Card, text: Text, limits: Limits, notes: Notes) -> Imported:
    words = header.text.split()
    dialect = next((w.removeprefix("dialect=") for w in words if w.startswith("dialect=")), "")
    syntax = syntax_of(dialect)
    if syntax is None:
        raise header.error(f"dialect {shown(dialect)}: unknown; write the netlist again")
    found = read_annotated(text.cards, syntax, limits)
    bench, temperature_c = found.testbench, found.silicon.temperature_c
    controls = syntax.run(found.controls, limits, notes)
    stop, degrees = controls.span.stop, controls.temperature_c
    last = (found.controls or text.cards)[-1]
    if stop is not None and not isclose(stop, bench.stop, rel_tol=1e-9):
        raise last.error(f".tran: stops at {stop:g} s, by the testbench note at {bench.stop:g} s; edit both")
    if controls.transient is not None and controls.uic != (bench.begin == "uic"):
        raise last.error(f"uic of .tran: {controls.uic}, by the testbench note {bench.begin}; edit both")
    if degrees is not None and not isclose(degrees, temperature_c, abs_tol=1e-9):
        raise last.error(f"temp: {degrees:g} degC, by the silicon note {temperature_c:g} degC; edit both")
    return Imported(
        bench,
        tuple(controls.analyses),
        found.deviations,
        notes.all(),
        temperature_c=temperature_c,
        dialect=dialect,
        models=found.header.models,
        silicon=found.silicon,
        parasitics=found.parasitics,
        dropped=notes.dropped(),
        measures=tuple(controls.measures),
    )


def _testbench(
    title: str, top: Top, controls: Controls, limits: Limits, notes: Notes, separator: str
) -> Testbench:
    circuit, stop = top.part.circuit, controls.span.stop
    known: dict[int, _Inside] = {}
    starts, held = (
        given | {name.replace(".", separator): stated for name, stated in inside.items()}
        for given, inside in ((controls.starts, top.starts), (controls.held, top.held))
    )
    for node, (_, card) in (*starts.items(), *held.items()):
        for part in node.split(separator):
            card.check_name(part, limits.word)
    start, initial = (_voltages(top, given, separator, known, notes) for given in (starts, held))
    if controls.uic:
        for _, card in list(starts.values())[:1]:
            notes.add(".nodeset with uic, taken as .ic as ngspice does", card.place, len(start))
        start, initial = {}, start | initial
    begin: Begin = "uic" if controls.uic else "disturbed"
    return Testbench(
        title, circuit, top.sources, inf if stop is None else stop, start=start, initial=initial, begin=begin
    )


def _voltages(
    top: Top,
    given: Mapping[str, tuple[float, Card]],
    separator: str,
    known: dict[int, _Inside],
    notes: Notes,
) -> dict[str, float]:
    """Voltages, V, by node path; those of nodes that only cards for ngspice have are left to it."""
    found: dict[str, float] = {}
    for node, (voltage, card) in given.items():
        try:
            found[_node_path(top, node.split(separator), card, known)] = voltage
        except DataError as error:
            if not notes.kept:
                raise
            notes.keep(card, card.foreign(str(error).removeprefix(f"{card.place}: ")))
    return found


def _place(top: Top, sources: Iterable[Source]) -> Place:
    """Path in the circuit of what a run calls by a name: of a node (`v`), or of a device or source (`i`).

    Where one call stands for the whole, a node is the port that it is at, and the call's name goes.
    """
    grounded = {s.name for s in sources if not is_followed(s.node)}

    def path(kind: str, name: str) -> str:
        lifted = name.replace(".", "_x2e_")  # a source inside a sub-circuit
        if kind == "i" and lifted in grounded:
            return lifted
        if kind == "i" and f"{lifted}[0]" in grounded:  # a current between two nodes, as it enters the second
            return f"{lifted}[0]"
        if top.call is None or (kind == "i" and name in grounded):
            return name
        instance, port = top.call
        return port[name] if kind == "v" and name in port else name.removeprefix(f"{instance}.")

    return path


def _placed(analysis: Analysis, place: Place) -> Analysis:
    """An analysis with the paths of its nodes in the circuit."""
    if not isinstance(analysis, NoiseSpectrum):
        return analysis
    output, reference = (
        GROUND if is_ground(node) else place("v", ".".join(map(circuit_name, node.split("."))))
        for node in (analysis.output, analysis.reference)
    )
    return replace(analysis, output=output, reference=reference)


def _node_path(top: Top, name: Sequence[str], card: Card, known: dict[int, _Inside]) -> str:
    """Path in the circuit of a node by the parts of its name in a run; `known` collects circuits."""
    *instances, node = map(circuit_name, name)
    if top.call is not None:
        instance, port = top.call
        if not instances and node in port:
            return port[node]
        instances = instances[1:] if instances and instances[0] == instance else ["", *instances]
    circuit: Circuit | None = top.part.circuit
    for each in instances:
        circuit = _inside(circuit, known).instances.get(each) if circuit else None
    found = _inside(circuit, known) if circuit else None
    lifted = circuit_name(".".join(name))  # a node that a source inside a sub-circuit drives
    if lifted in _inside(top.part.circuit, known).nodes:
        return lifted
    if found is None or node not in (found.own if instances else found.nodes):
        raise card.error(
            f"v({shown('.'.join(name))}): unknown node; name one of the netlist, as in v(x1.node)"
        )
    return ".".join([*instances, node])


class _Inside(NamedTuple):
    """Circuits of a circuit's instances, its nodes, and those that are no ports."""

    instances: dict[str, Circuit]
    nodes: set[str]
    own: set[str]


def _inside(circuit: Circuit, known: dict[int, _Inside]) -> _Inside:
    if id(circuit) not in known:
        nodes = {*circuit.shapes(), *(r for _, r in references(circuit))}
        instances = {i.name: i.circuit for i in circuit.instances}
        known[id(circuit)] = _Inside(instances, nodes, nodes - {p.name for p in circuit.ports})
    return known[id(circuit)]


def _names(circuit: Circuit) -> dict[str, str]:
    """Names that the netlist has otherwise, over all circuits inside `circuit`."""
    seen: dict[int, Circuit] = {}
    waiting = [circuit]
    while waiting:
        each = waiting.pop()
        if id(each) not in seen:
            seen[id(each)] = each
            waiting += [i.circuit for i in each.instances]
    found = {name: original_name(name) for each in seen.values() for name in sorted(_own_names(each))}
    return {name: original for name, original in found.items() if name != original}


def _own_names(circuit: Circuit) -> set[str]:
    own = {circuit.name, *(d.name for d in circuit.devices), *(i.name for i in circuit.instances)}
    return own | {p.name for p in circuit.ports} | {r for _, r in references(circuit) if r != GROUND}
