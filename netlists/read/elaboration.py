"""The third step of reading a netlist: its sections become circuits.

Every sub-circuit becomes a circuit once for each set of parameter values that it is called with or has from
where it is called. A circuit has no stimuli, so that a source inside a sub-circuit is lifted to the top: the
nodes that it drives become ports, which every call connects to nodes of their own, `x1.node`. The top level
becomes a circuit `top` whose ports are the nodes that sources drive, a `supply` under a constant voltage and
else `analog`. Where it is one call of a sub-circuit and sources at its ports, that sub-circuit is the
circuit, and its ports that nothing drives are outputs. Where it is empty, as in a library, the last
sub-circuit that no other calls is the circuit. A current source between two nodes becomes two, one at each; a
voltage source between two nodes drives a port of its own, which the circuit's voltage follows. Global nodes
become ports all the way up.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace

from circuits.circuit import GROUND, Circuit, Instance, Port
from circuits.devices import Device, Source
from circuits.devices.source import Constant, Quantity
from circuits.errors import CircuitError, DataError, ParameterError
from circuits.silicon.silicon import Deviation
from netlists.read.analysis import Given as Stated
from netlists.read.analysis import voltages_of
from netlists.read.branch.element import Branch, value_node
from netlists.read.branch.wire import sensed, wires
from netlists.read.card import Arguments, Card, ForeignError, element_arguments, element_words, shown
from netlists.read.element import NOMINAL_C, Context, read_element
from netlists.read.expression.scope import IDENTIFIER, Scope
from netlists.read.limits import Limits
from netlists.read.measure import Asked
from netlists.read.note import Notes
from netlists.read.text.name import circuit_name, is_ground, original_name
from netlists.read.text.section import Deck, Section, duplicate, sections
from netlists.read.waveform import Given, Span, read_waveform, small_signal, vertex_count


@dataclass(frozen=True, slots=True)
class Part:
    """A sub-circuit with its parameter values: the circuit, what it calls, and its transistors' deviations.

    `lifted`: global nodes among its ports, as written. `elements`: devices and instances, parts of parts
    counted. `sources`: sources inside it, each at a port. `moved`: AC values of sources inside it, V or A.
    `turned`: sources inside it that the circuit sees from their other end. `starts`, `held`: what its
    `.nodeset` and `.ic` cards state, by the node's name as written, below the names of calls.
    """

    circuit: Circuit
    parts: dict[str, Part]
    deviations: dict[str, Deviation]
    lifted: tuple[str, ...]
    elements: int
    sources: tuple[Source, ...] = ()
    moved: Mapping[str, complex] = field(default_factory=dict)
    turned: frozenset[str] = frozenset()
    starts: Stated = field(default_factory=dict)
    held: Stated = field(default_factory=dict)

    def all_deviations(self, prefix: str = "") -> Iterator[tuple[str, Deviation]]:
        """Yield deviations by instance path."""
        for name, deviation in self.deviations.items():
            yield prefix + name, deviation
        for name, part in self.parts.items():
            yield from part.all_deviations(f"{prefix}{name}.")


@dataclass(frozen=True, slots=True)
class Top:
    """The circuit with what drives it.

    `call`: instance that stands for the whole, with port by its node. `moved`: AC values of sources, V or A.
    `turned`: sources that the circuit sees from their other end. `starts`, `held`: what the `.nodeset` and
    `.ic` cards of sub-circuits state, V with the card, by the node's name as a run has it.
    """

    part: Part
    sources: tuple[Source, ...]
    call: tuple[str, dict[str, str]] | None = None
    moved: Mapping[str, complex] = field(default_factory=dict)
    turned: frozenset[str] = frozenset()
    starts: Stated = field(default_factory=dict)
    held: Stated = field(default_factory=dict)


@dataclass(slots=True)
class _Contents:
    """What the cards of one section become."""

    devices: list[Device] = field(default_factory=list)
    instances: list[Instance] = field(default_factory=list)
    sources: list[Source] = field(default_factory=list)
    parts: dict[str, Part] = field(default_factory=dict)
    deviations: dict[str, Deviation] = field(default_factory=dict)
    lifted: dict[str, None] = field(default_factory=dict)
    names: dict[str, Card] = field(default_factory=dict)
    moved: dict[str, complex] = field(default_factory=dict)
    turned: set[str] = field(default_factory=set)
    starts: Stated = field(default_factory=dict)
    held: Stated = field(default_factory=dict)


@dataclass(slots=True)
class Elaboration:
    """Circuits met so far by section and parameter values, and the chain of calls at hand."""

    deck: Deck
    scope: Scope
    span: Span
    limits: Limits
    notes: Notes
    is_cdl: bool = False
    uses_ic: bool = False
    nominal_c: float = NOMINAL_C
    asked: Asked = field(default_factory=Asked)
    built: dict[tuple[object, ...], Part] = field(default_factory=dict)
    used: dict[Section, frozenset[str]] = field(default_factory=dict)
    seen: set[Section] = field(default_factory=set)
    calls: list[Section] = field(default_factory=list)
    again: int = 0  # how many of the calls at hand are read again
    expanded: dict[bool, int] = field(default_factory=lambda: {False: 0, True: 0})
    vertices: int = 0
    models: set[Card] = field(default_factory=set)  # that transistors use

    def top(self) -> Top:
        """Build the whole netlist; raises `DataError` with file and line."""
        section = self.deck.top
        if not section.elements:
            library = self._library()
            whole = self._empty() if library is None else self._part(library, {}, library.card, self.scope)
            self._note_unused()
            return Top(whole, whole.sources, None, whole.moved, whole.turned, whole.starts, whole.held)
        contents = self._contents(section, self.scope)
        self._note_unused()
        called = _sole_call(contents)
        if called is not None:
            part, by_node = called
            sources = tuple(replace(s, node=by_node[s.node]) for s in contents.sources)
            circuit = replace(part.circuit, ports=_ports_driven(part.circuit.ports, sources))
            call = contents.instances[0].name, by_node
            moved, turned = contents.moved, frozenset(contents.turned)
            stated = contents.starts, contents.held
            return Top(replace(part, circuit=circuit), sources, call, moved, turned, *stated)
        self._leave_idle(contents)
        ports = _ports_of_sources(contents.sources)
        whole = self._finish("top", ports, contents, section.card)
        return Top(whole, whole.sources, None, whole.moved, whole.turned, whole.starts, whole.held)

    def _leave_idle(self, contents: _Contents) -> None:
        """Leave out sources at nodes that nothing else uses; cards for ngspice only may use any."""
        used = {n for device in contents.devices for n in device.terminals()}
        used |= {n for instance in contents.instances for n in instance.connections.values()}
        idle = [s for s in contents.sources if s.node not in used]
        if idle and not self.notes.kept:
            for source in idle:
                name = original_name(source.name)
                self.notes.add(
                    f"source {shown(name)}, at a node that nothing else uses", self.deck.top.card.place
                )
            contents.sources = [s for s in contents.sources if s.node in used]

    def _empty(self) -> Part:
        """The circuit of a netlist that only has commands."""
        return self._finish("top", (), _Contents(), self.deck.top.card)

    def _library(self) -> Section | None:
        """The last sub-circuit that no other calls, for a netlist without elements at its top.

        None for one that only has commands, where cards for ngspice only are kept.
        """
        every = list(sections(self.deck.top))
        if not every and self.notes.keeps and self.notes.found:
            return None
        if not every:
            raise DataError(
                f"{self.deck.top.card.place}: no elements; write one below the first line, the title"
            )
        called = {s for each in every for s in _called(each)}
        roots = [s for s in every if s not in called]
        return roots[-1] if roots else every[-1]

    def _note_unused(self) -> None:
        for section in sections(self.deck.top):
            if section not in self.seen:
                self.notes.add(f"sub-circuit {shown(section.name)}, not called", section.card.place)
        for section in (self.deck.top, *(s for s in sections(self.deck.top) if s in self.seen)):
            for model in section.models.values():
                shared = section.bins.get(model.name.rpartition(".")[0])
                if model.card not in self.models and (shared is None or shared.card not in self.models):
                    self.notes.add(f"model {shown(model.name)}, not used", model.card.place)

    def _uses(self, section: Section) -> frozenset[str]:
        """Names in the cards of a section and of all that it calls, those of parameters among them."""
        if section not in self.used:
            found, waiting, met = set[str](), [section], {section}
            while waiting:
                each = waiting.pop()
                new = set(_called(each)) - met
                waiting += new
                met |= new
                found.update(*(IDENTIFIER.findall(text.lower()) for text in _texts(each)))
            functions = (IDENTIFIER.findall(f.text) for f in self.deck.functions.values())
            self.used[section] = frozenset(found.union(*functions))
        return self.used[section]

    def _part(self, section: Section, given: dict[str, float], card: Card, caller: Scope) -> Part:
        key = (section, tuple(sorted(given.items())), caller.inherited(self._uses(section) - given.keys()))
        if key in self.built:
            return self.built[key]
        if section in self.calls:
            raise card.error(f"{shown(section.name)}: a sub-circuit that calls itself; break the cycle")
        if len(self.calls) >= self.limits.call_depth:
            raise card.error(f"calls deeper than {self.limits.call_depth}, the limit; flatten the netlist")
        is_again = section in self.seen
        if is_again:
            self._count(section, card)
        self.seen.add(section)
        self.calls.append(section)
        self.again += is_again
        for name in (section.name, *section.ports):
            section.card.check_name(name, self.limits.word)
        scope = Scope(self.limits, caller, dict(given), section=section)
        defaults = {n: (text, section.card) for n, text in section.defaults.items()}
        scope.define(defaults | section.parameters, self.notes)
        contents = self._contents(section, scope)
        lifted = tuple(n for n in contents.lifted if n not in section.ports)
        names = [circuit_name(n) for n in (*section.ports, *lifted) if not is_ground(n)]
        driven = [s.node for s in contents.sources if s.node not in names]
        ports = tuple(Port(n, "analog") for n in dict.fromkeys((*names, *driven)))
        self.built[key] = self._finish(section.name, ports, contents, section.card, lifted)
        self.calls.pop()
        self.again -= is_again
        return self.built[key]

    def _count(self, section: Section, card: Card) -> None:
        """Count a section that is read again; raises `DataError` beyond the limits."""
        nested = self.again > 0
        self.expanded[nested] += len(section.elements) + len(section.defaults) + len(section.parameters) + 1
        most = self.limits.expansion if nested else self.limits.calls
        if self.expanded[nested] > most:
            limit = f"more than {most} cards of sub-circuits called with other parameters"
            raise card.error(f"{limit}, the limit; call them with equal ones")

    def _finish(
        self,
        name: str,
        ports: tuple[Port, ...],
        contents: _Contents,
        card: Card,
        lifted: tuple[str, ...] = (),
    ) -> Part:
        try:
            circuit = Circuit(circuit_name(name), ports, tuple(contents.devices), tuple(contents.instances))
        except CircuitError as error:
            raise card.error(str(error)) from None
        count = len(contents.devices) + sum(1 + p.elements for p in contents.parts.values())
        sources = tuple(contents.sources)
        return Part(
            circuit, contents.parts, contents.deviations, lifted, count, sources, contents.moved,
            frozenset(contents.turned), contents.starts, contents.held,
        )  # fmt: skip

    def _contents(self, section: Section, scope: Scope) -> _Contents:
        contents, card = _Contents(), section.card
        fixed = (*section.ports, *self.deck.global_nodes)
        taken = sensed(section.elements)
        same, wired = wires(section.elements, fixed, scope, taken | self.asked.currents, self.asked.nodes)
        for each in wired:
            self.notes.add("source of 0 V between two nodes, a wire in the circuit", each.place)

        def node(name: str) -> str:
            if is_ground(name):
                return GROUND
            name = same.get(name, name)
            card.check_name(name, self.limits.word)  # the card that the loop below is at
            if name in self.deck.global_nodes:
                contents.lifted[name] = None
            return circuit_name(name)

        context = Context(
            section, scope, node, self.notes, self.is_cdl, self.uses_ic, self.models, taken, self.nominal_c
        )
        self._stated(section, scope, contents)
        for card in section.elements:
            if card in wired or not self._is_taken(card, section, scope):
                continue
            name = card.name()
            if name in contents.names:
                raise duplicate(card, name, contents.names[name])
            contents.names[name] = card
            card.check_name(name, self.limits.word)
            try:
                self._element(card, context, contents)
            except ForeignError as error:
                self.notes.keep(card, error)
            except ParameterError as error:
                raise card.error(str(error)) from None
        return contents

    def _stated(self, section: Section, scope: Scope, contents: _Contents) -> None:
        """Read the voltages that `.ic` and `.nodeset` cards of a sub-circuit state."""
        for card in section.voltages:
            try:
                into = contents.held if card.name() == ".ic" else contents.starts
                into |= voltages_of(card, scope)
            except ForeignError as error:
                self.notes.keep(card, error)

    def _is_taken(self, card: Card, section: Section, scope: Scope) -> bool:
        """Whether the conditions of an element hold, where it has any."""
        try:
            return scope.holds(section.conditions.get(card, ()))
        except ForeignError as error:
            self.notes.keep(card, error)
            return False

    def _element(self, card: Card, context: Context, contents: _Contents) -> None:
        letter = card.text[0].lower()
        if letter == "x":
            self._call(card, context, contents)
        elif letter in "vi":
            contents.sources += self._sources(card, context, contents)
        else:
            element = read_element(card, context)
            contents.devices += (element.device, *element.more)
            if element.deviation is not None:
                contents.deviations[element.device.name] = element.deviation

    def _call(self, card: Card, context: Context, contents: _Contents) -> None:
        name, words = element_arguments(card)
        if not _call_words(words):
            raise card.error(f"{shown(name)}: no sub-circuit; write Xname node ... SUBCKT")
        *nodes, called = _call_words(words)
        section = context.section.find_section(called)
        if section is None:
            raise card.error(f"{shown(name)}: sub-circuit {shown(called)} is not there; add its .subckt")
        if len(nodes) != len(section.ports):
            raise card.error(
                f"{shown(name)}: {len(nodes)} nodes, {shown(called)} has {len(section.ports)} ports,"
                f" see {section.card.place}; name one node a port"
            )
        given = {}
        for key, word in words.named.items():
            if key not in section.defaults:
                raise card.foreign(
                    f"{shown(name)}.{shown(key)}: {shown(called)} has no such parameter,"
                    f" see {section.card.place}; remove it"
                )
            given[key] = context.scope.parameter(card, f"{shown(name)}.{shown(key)}", word)
        part = self._part(section, given, card, context.scope)
        at = dict(zip(section.ports, nodes, strict=True))
        fixed = {*part.lifted, *self.deck.global_nodes}
        for inside, into in ((part.starts, contents.starts), (part.held, contents.held)):
            for node, stated in inside.items():
                into[node if node in fixed else at.get(node, f"{name}.{node}")] = stated
        connections = [*zip(section.ports, nodes, strict=True), *((n, n) for n in part.lifted)]
        connected = {circuit_name(p): context.node(n) for p, n in connections if not is_ground(p)}
        _lift(card, part, circuit_name(name), connected, contents)
        contents.instances.append(Instance(circuit_name(name), part.circuit, connected))
        contents.parts[circuit_name(name)] = part

    def _sources(self, card: Card, context: Context, contents: _Contents) -> list[Source]:
        name, *words = element_words(card)
        form = f"write {name[0]}name n+ n- VALUE"
        if len(words) < 2:
            raise card.error(f"{shown(name)}: {len(words)} nodes, must be 2; {form}")
        if set(words[:2]) & {"(", ")", "="}:
            raise card.error(f"{shown(name)}: {' '.join(map(shown, words[:2]))}, must be two nodes; {form}")
        plus, minus = map(context.node, words[:2])
        left = replace(self.span, vertices=self.limits.vertices - self.vertices)
        given = read_waveform(card, words[2:], context.scope, left, self.notes)
        self.vertices += vertex_count(given.waveform)
        own = circuit_name(name)
        small = small_signal(card, words[2:], context.scope)
        if plus == minus:
            raise card.foreign(f"{shown(name)}: both ends at one node; remove it")
        if name[0] == "v":
            is_branch = name in context.sensed or GROUND not in (plus, minus)
            source = self._voltage(name, (plus, minus), given, contents, is_branch=is_branch)
            _move(contents, own, -small if own in contents.turned else small)
            return [source]
        ends = [(n, g) for n, g in ((minus, given), (plus, given.negated())) if n != GROUND]
        if len(ends) == 1:
            if minus == GROUND:
                contents.turned.add(own)
            _move(contents, own, -small if minus == GROUND else small)
            return [_source(own, *ends[0], "current")]
        for k, sign in enumerate((1.0, -1.0)):
            _move(contents, f"{own}[{k}]", sign * small)
        return [_source(f"{own}[{k}]", n, g, "current") for k, (n, g) in enumerate(ends)]

    def _voltage(
        self, name: str, ends: tuple[str, str], given: Given, contents: _Contents, *, is_branch: bool
    ) -> Source:
        """A source of voltage at a node of the circuit, or at a port of its own that the circuit follows."""
        plus, minus = ends
        own = circuit_name(name)
        if is_branch:
            contents.devices += Branch(name, plus, minus).follower(value_node(name), GROUND, 1.0)
            return _source(own, value_node(name), given)
        if minus == GROUND:
            return _source(own, plus, given)
        contents.turned.add(own)
        return _source(own, minus, given.negated())


def _source(name: str, node: str, given: Given, quantity: Quantity = "voltage") -> Source:
    return Source(name, node, given.waveform, quantity, given.direct)


def _move(contents: _Contents, source: str, small: complex) -> None:
    """Keep the AC value of a source, V or A, where it has one."""
    if small:
        contents.moved[source] = small


def _lift(card: Card, part: Part, name: str, connected: dict[str, str], contents: _Contents) -> None:
    """Take the sources of a part over to the circuit that calls it, each with a node there.

    `connected`, the node by port, is added to. Raises `DataError` for a voltage source whose node is ground
    there.
    """
    prefix = circuit_name(f"{original_name(name)}.")
    for source in part.sources:
        node = connected.setdefault(source.node, prefix + source.node)
        if node != GROUND:
            contents.sources.append(replace(source, name=prefix + source.name, node=node))
            _move(contents, prefix + source.name, part.moved.get(source.name, 0.0))
            contents.turned.update({prefix + source.name} if source.name in part.turned else ())
        elif source.quantity == "voltage":
            raise card.foreign(f"{shown(name)}: its source {source.name} drives ground; connect another node")


def _texts(section: Section) -> Iterator[str]:
    """All texts of a section that can name a parameter."""
    yield from (card.text for card in (section.card, *section.elements, *section.voltages))
    yield from (text for text, _ in section.parameters.values())
    yield from (text for model in section.models.values() for text in model.parameters.values())
    yield from (c.text for conditions in section.conditions.values() for c in conditions)


def _call_words(words: Arguments) -> list[str]:
    """Nodes of a call and what it calls, without the marks that some dialects put between them."""
    return [w for w in words.positional if w not in {"/", "params:"}]


def _called(section: Section) -> Iterator[Section]:
    for card in section.elements:
        if card.text[0] in "xX":
            words = _call_words(element_arguments(card)[1])
            found = section.find_section(words[-1]) if words else None
            if found is not None:
                yield found


def _sole_call(contents: _Contents) -> tuple[Part, dict[str, str]] | None:
    """The part of a top level that is one call and sources at its ports, with its port by node."""
    if contents.devices or len(contents.instances) != 1:
        return None
    instance = contents.instances[0]
    by_node = {node: port for port, node in instance.connections.items()}
    if len(by_node) < len(instance.connections) or GROUND in by_node:
        return None
    if any(source.node not in by_node for source in contents.sources):
        return None
    return contents.parts[instance.name], by_node


def _ports_of_sources(sources: list[Source]) -> tuple[Port, ...]:
    nodes = dict.fromkeys(s.node for s in sources)
    constant = _constant(sources)
    return tuple(Port(n, "supply" if n in constant else "analog") for n in nodes)


def _ports_driven(ports: tuple[Port, ...], sources: tuple[Source, ...]) -> tuple[Port, ...]:
    driven, constant = {s.node for s in sources}, _constant(sources)
    return tuple(
        Port(p.name, "supply" if p.name in constant else "analog", "in" if p.name in driven else "out")
        for p in ports
    )


def _constant(sources: list[Source] | tuple[Source, ...]) -> set[str]:
    return {s.node for s in sources if isinstance(s.waveform, Constant) and s.quantity == "voltage"}
