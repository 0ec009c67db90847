"""The element cards of a netlist and the devices that they become.

    Rname a b value [M=]     Cname a b value [M=] [IC=]     Gname n+ n- c+ c- value
    Mname d g s b model W= L= [M=] [AD= AS= PD= PS= ...] [DELVTO=] [MULU0=]
    Bname n+ n- I=expression, linear in one voltage difference
    L, E, F, H: `netlists.read.branch.element`; D: `netlists.read.model.diode`

A current of G and B leaves n+, passes the source and enters n-. `DELVTO` adds to the signed threshold, so
that of a pFET it lowers the magnitude; `MULU0` multiplies the mobility. In CDL, which has no models, the
polarity is the first letter of the model's name. V, I and X are read elsewhere.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, field, replace

from circuits.checks import LIMITS
from circuits.circuit import GROUND
from circuits.devices import Capacitor, ControlledSource, Device, Resistor, Transistor
from circuits.errors import DataError, ParameterError
from circuits.silicon.process import Polarity
from circuits.silicon.silicon import Deviation
from circuits.units import format_quantity
from netlists.read.branch.element import INDUCTOR, TRANSCONDUCTANCE, Branch, branch_node
from netlists.read.card import Arguments, Card, element_arguments, shown
from netlists.read.expression.scope import Scope
from netlists.read.foreign import REMEDY, foreign_element, foreign_transistor
from netlists.read.model.diode import diode_of
from netlists.read.note import Notes
from netlists.read.text.name import circuit_name
from netlists.read.text.section import Model, Section

Node = Callable[[str], str]  # name of a node as written -> as the circuit has it
_CURRENT = re.compile(r"\b(?:i|cur|value)\s*=\s*(.*)$", re.IGNORECASE)
# parameters that are noted: what a layout says, which here the process does, and what concerns a run
_NOTED_OF_TRANSISTOR = {"ad", "as", "pd", "ps", "nrd", "nrs", "nf", "sa", "sb", "sd", "geo", "off"}
_NOTED = {"ic", "ac", "noise", "noisy"}
_DEGREES = {"temp", "dtemp"}  # of an element, which has the circuit's
_COEFFICIENTS = {"tc", "tc1", "tc2"}
_SHOWN = 6  # parameters of a model that an error names
_OF_NGSPICE = {"vdmos", "vdmosn", "vdmosp", "nsoi", "psoi", "numos"}  # types that its M elements have, too
NOMINAL_C = 27.0  # degC, of SPICE
_SIGNS: dict[Polarity, float] = {"n": 1.0, "p": -1.0}


@dataclass(frozen=True, slots=True)
class Context:
    """Where an element stands.

    Attributes
    ----------
    section, scope
        The sub-circuit or the top level, and the parameters in reach.
    node
        Gives the circuit's name of a node as it is written.
    notes
        Collects what is not taken over.
    is_cdl
        Whether the netlist is a layout's, which has no models.
    uses_ic
        Whether the run takes the capacitors' own initial voltages.
    models
        Cards of the models that elements have used so far.
    sensed
        Sources of voltage whose current has a node, since an F or H takes it.
    nominal_c
        Temperature that the figures of models belong to where these do not say it, degC.
    """

    section: Section
    scope: Scope
    node: Node
    notes: Notes
    is_cdl: bool = False
    uses_ic: bool = False
    models: set[Card] = field(default_factory=set)
    sensed: frozenset[str] = frozenset()
    nominal_c: float = NOMINAL_C


@dataclass(frozen=True, slots=True)
class Element:
    """A device, what its card adds to it on its die, and the devices that it comes with."""

    device: Device
    deviation: Deviation | None = None
    more: tuple[Device, ...] = ()


def read_element(card: Card, context: Context) -> Element:
    """Device of a card; raises `DataError` for an element that no device stands for."""
    letter = card.text[0].lower()
    if letter not in _READERS:
        raise foreign_element(card, context.section, context.models)
    return _READERS[letter](card, context)


def _nodes_and_value(
    card: Card, name: str, words: Arguments, count: int, key: str, form: str
) -> tuple[list[str], str]:
    """Nodes and value word of element `name` of `count` nodes; the value may be named `key`."""
    rest, value = list(words.positional), words.named.pop(key, None)
    if value is None and len(rest) > count:
        value = rest.pop(count)
    if len(rest) < count or value is None:
        missing = "a value" if len(rest) >= count else f"{count} nodes"
        raise card.error(f"{shown(name)}: without {missing}; write {name[0]}name {form}")
    if len(rest) > count:
        raise card.error(f"{shown(name)}: {shown(rest[count])} is not understood; write {name[0]}name {form}")
    return rest, value


def _two_nodes(
    card: Card, name: str, words: Arguments, context: Context, key: str, what: str
) -> tuple[str, str, str, float]:
    model = next((w for w in words.positional[2:] if context.section.find_model(w)), None)
    if model is not None:
        raise card.foreign(f"{shown(name)}: {what} by the model {shown(model)}; write its value, or {REMEDY}")
    nodes, word = _nodes_and_value(card, name, words, 2, key, "a b VALUE")
    count = context.scope.number(card, f"{shown(name)}.m", words.named.pop("m", "1"))
    if not count > 0.0:
        raise card.foreign(f"{shown(name)}.m: {count:g}, must be > 0; correct it")
    _note_unused(card, name, words, what, context.notes)
    a, b = map(context.node, nodes)
    value = context.scope.number(card, shown(name), word)
    return circuit_name(name), a, b, value * count if key == "c" else value / count


def _resistor(card: Card, context: Context) -> Element:
    return Element(Resistor(*_two_nodes(card, *element_arguments(card), context, "r", "resistor")))


def _capacitor(card: Card, context: Context) -> Element:
    name, words = element_arguments(card)
    word = words.named.pop("ic", None)
    device = Capacitor(*_two_nodes(card, name, words, context, "c", "capacitor"))
    if word is None:
        return Element(device)
    voltage = context.scope.number(card, f"{shown(name)}.ic", word)
    if not context.uses_ic:
        context.notes.add("ic of a capacitor, which a run without uic does not use", card.place)
        return Element(device)
    return Element(replace(device, ic=voltage))


def _controlled_source(card: Card, context: Context) -> Element:
    if _CURRENT.search(card.text):
        return _behavioural_source(card, context)
    name, words = element_arguments(card)
    for kind in set(words.positional) & {"poly", "table"}:
        raise card.foreign(f"{shown(name)}: {kind.upper()} is not supported; write a linear G")
    nodes, word = _nodes_and_value(card, name, words, 4, "gm", "n+ n- c+ c- VALUE")
    _note_unused(card, name, words, "controlled source", context.notes)
    a, b, c, d = map(context.node, nodes)
    value = context.scope.number(card, shown(name), word)
    return Element(ControlledSource(circuit_name(name), a, b, c, d, value))


def _behavioural_source(card: Card, context: Context) -> Element:
    head, name = _CURRENT.split(card.text.lower(), maxsplit=1)[0], shown(card.text.split()[0].lower())
    found = _CURRENT.search(card.text.lower())
    words = head.replace("(", " ").replace(")", " ").split()
    supported = "supported is I= linear in one voltage difference, as in I=1u*(v(a)-v(b)), or v(a,b)"
    if found is None or len(words) != 3:
        raise card.foreign(f"{name}: must be {name[0]}name n+ n- I=expression; {supported}")
    try:
        value = context.scope.linear(card, f"{name} ({supported})", found.group(1))
    except DataError as error:  # ngspice has more functions, currents and time
        raise card.foreign(str(error).removeprefix(f"{card.place}: ")) from None
    if value.constant != 0.0 or not 1 <= len(value.slopes) <= 2:
        raise card.foreign(f"{name}: not one voltage difference; {supported}")
    (plus, slope), *others = value.slopes.items()
    minus, back = others[0] if others else ("0", -slope)
    if back != -slope:
        raise card.foreign(f"{name}: slopes {slope:g} and {back:g} S, must be opposite; {supported}")
    a, b, c, d = map(context.node, (words[1], words[2], plus, minus))
    return Element(ControlledSource(circuit_name(words[0]), a, b, c, d, slope))


def _diode(card: Card, context: Context) -> Element:
    name, words = element_arguments(card)
    model = context.section.find_model(words.positional[2]) if len(words.positional) > 2 else None
    if model is None or model.type != "d":
        raise foreign_element(card, context.section, context.models)
    context.models.add(model.card)
    if "ic" in words.named:
        if context.uses_ic:
            raise card.foreign(f"{shown(name)}.ic: a voltage to begin with, of a capacitor only; {REMEDY}")
        words.named.pop("ic")
        context.notes.add("ic of a diode, which a run without uic does not use", card.place)
    for key in set(words.named) & _DEGREES:
        context.notes.leave_out(card, key, f"{key} of a diode", "a circuit has one temperature, remove it")
        words.named.pop(key)
    words.positional[:2] = map(context.node, words.positional[:2])
    numbers = context.scope.number, context.scope.of(model.section).number
    diode, series = diode_of(card, name, words, model, numbers, context.nominal_c, context.notes)
    return Element(diode, more=() if series is None else (series,))


def _inductor(card: Card, context: Context) -> Element:
    name, words = element_arguments(card)
    begins = words.named.pop("ic", None)
    if begins is not None and context.uses_ic:
        raise card.foreign(
            f"{shown(name)}.ic: a current to begin with, which the native solver has not; {REMEDY}"
        )
    own, a, b, value = _two_nodes(card, name, words, context, "l", "inductor")
    if not value > 0.0:
        raise card.foreign(f"{own}.inductance: {value:g} H, must be > 0; {REMEDY}")
    if begins is not None:
        context.notes.add("ic of an inductor, which a run without uic does not use", card.place)
    try:
        devices = Branch(name, a, b).inductor(value)
    except ParameterError:  # of the capacitor that stands for it
        low, high = (limit / INDUCTOR**2 for limit in LIMITS["F"])
        rule = f"must be {format_quantity(low, 'H')} to {format_quantity(high, 'H')}"
        meant = "give it in H, or `allow_implausible` where it is meant"
        raise card.error(f"{own}.inductance: {value:g} H, {rule}; {meant}") from None
    return _branch(card, devices, "inductor", context)


def _branch(card: Card, devices: tuple[Device, ...], what: str, context: Context) -> Element:
    context.notes.add(f"{what} as a gyrator, which is the same", card.place)
    return Element(devices[0], more=devices[1:])


def _controlled_voltage(card: Card, context: Context) -> Element:
    """E and H, whose voltage follows that between two nodes or a current."""
    name, words = element_arguments(card)
    is_plain = len(words.positional) == (5 if name[0] == "e" else 4) and not words.named
    if not is_plain or set(words.positional) & {"poly", "table", "vcvs", "ccvs"}:
        raise foreign_element(card, context.section, context.models)
    *nodes, word = words.positional
    gain = context.scope.number(card, shown(name), word)
    branch = Branch(name, *map(context.node, nodes[:2]))
    if name[0] == "h":
        control, gain = (_sensed(card, nodes[2], context), GROUND), TRANSCONDUCTANCE * gain
    else:
        control = context.node(nodes[2]), context.node(nodes[3])
    return _branch(card, branch.follower(*control, gain), "voltage that something controls", context)


def _current_by_current(card: Card, context: Context) -> Element:
    name, words = element_arguments(card)
    if len(words.positional) != 4 or words.named or set(words.positional) & {"poly", "cccs"}:
        raise foreign_element(card, context.section, context.models)
    *nodes, other, word = words.positional
    gain = context.scope.number(card, shown(name), word)
    a, b = map(context.node, nodes)
    control = _sensed(card, other, context)
    return Element(ControlledSource(circuit_name(name), a, b, control, GROUND, TRANSCONDUCTANCE * gain))


def _sensed(card: Card, name: str, context: Context) -> str:
    """Node of the current of the source `name`, which must stand in the same section."""
    if name not in context.sensed:
        raise card.foreign(
            f"{card.name()}: no source {shown(name)} beside it; name a V of the same sub-circuit"
        )
    return branch_node(name)


def _transistor(card: Card, context: Context) -> Element:
    name, words = element_arguments(card)
    rest = words.positional
    if len(rest) != 5:
        raise foreign_transistor(card, words, context.section)
    polarity = _polarity(card, context, rest[4])
    size = {}
    for key, default in (("w", None), ("l", None), ("m", "1")):
        word = words.named.pop(key, default)
        if word is None:
            raise card.foreign(f"{shown(name)}.{key}: missing; write {key.upper()}= in metre")
        size[key] = context.scope.number(card, f"{shown(name)}.{key}", word)
    shift = {
        key: context.scope.number(card, f"{shown(name)}.{key}", words.named.pop(key, neutral))
        for key, neutral in (("delvto", "0"), ("mulu0", "1"))
    }
    _note_transistor(card, name, words, context.notes)
    d, g, s, b = map(context.node, rest[:4])
    device = Transistor(circuit_name(name), polarity, d, g, s, b, size["w"], size["l"], size["m"])
    deviation = Deviation(_SIGNS[polarity] * shift["delvto"] + 0.0, shift["mulu0"] - 1.0)
    return Element(device, None if deviation == (0.0, 0.0) else deviation)


def _polarity(card: Card, context: Context, name: str) -> Polarity:
    model = context.section.find_model(name)
    if model is None and context.is_cdl and name[0] in "np":  # a layout's netlist has no models
        context.notes.add(f"polarity of model {shown(name)} taken from its first letter", card.place)
        return "n" if name[0] == "n" else "p"
    if model is None:
        raise card.error(f"model {shown(name)}: unknown; add its .model card of type nmos or pmos")
    if model.type not in {"nmos", "pmos"}:
        error = card.foreign if model.type in _OF_NGSPICE else card.error
        raise error(
            f"model {shown(name)}: type {shown(model.type)}, must be nmos or pmos; see {model.card.place}"
        )
    context.models.add(model.card)
    _leave_out_figures(model, context.notes)
    return "n" if model.type == "nmos" else "p"


def _leave_out_figures(model: Model, notes: Notes) -> None:
    """A model says the polarity; its figures would be another law than that of the process."""
    if model.parameters:
        name, given = shown(model.name), ", ".join(map(shown, list(model.parameters)[:_SHOWN]))
        more = "" if len(model.parameters) <= _SHOWN else f" and {len(model.parameters) - _SHOWN} more"
        notes.leave_out(
            model.card,
            model.name,
            f".model {name}: parameters {given}{more}",
            f"transistors have the law of the process, write .model {name} {model.type}",
            under=".model",
        )


def _note_transistor(card: Card, name: str, words: Arguments, notes: Notes) -> None:
    for key in words.named:
        if key in _DEGREES:
            notes.leave_out(card, key, f"{key} of a transistor", "a circuit has one temperature, remove it")
        elif key in _NOTED_OF_TRANSISTOR:
            notes.add(f"{key} of a transistor", card.place)
        else:
            raise card.foreign(f"{shown(name)}.{shown(key)}: unknown parameter; remove it")


def _note_unused(card: Card, name: str, words: Arguments, what: str, notes: Notes) -> None:
    for key in words.named:
        if key in _DEGREES | _COEFFICIENTS:
            notes.leave_out(card, key, f"{key} of a {what}", "a value holds at all temperatures, remove it")
        elif key in _NOTED:
            notes.add(f"{shown(key)} of a {what}", card.place)
        else:
            raise card.foreign(f"{shown(name)}.{shown(key)}: not supported; fold it into the value")


_READERS: dict[str, Callable[[Card, Context], Element]] = {
    "r": _resistor, "c": _capacitor, "g": _controlled_source, "b": _behavioural_source, "m": _transistor,
    "l": _inductor, "d": _diode, "e": _controlled_voltage, "h": _controlled_voltage, "f": _current_by_current,
}  # fmt: skip
