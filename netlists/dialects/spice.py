"""What all dialects of the SPICE family write alike; a `Syntax` says in what one of them differs.

They share devices, sources, definitions and calls. EKV transistors are behavioural currents, with the
constants folded into numbers, beside their constant capacitances; a definition has literal numbers only. A
device `mi5` is written as an element with its type's letter and its name. The elements that make it up have a
tag (`netlists.naming`): its capacitances `gb`, its junctions' leakage `db`.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any

import numpy as np

from circuits.circuit import GROUND
from circuits.devices import Capacitor, ControlledSource, OperationalAmplifier, Resistor, Source, Transistor
from circuits.devices.device import Device
from circuits.devices.diode import Diode
from circuits.devices.source import polyline
from circuits.devices.transistor import capacitances
from circuits.silicon.process import Polarity, TransistorAtTemperature, TransistorModel
from circuits.silicon.silicon import Deviation, Silicon
from netlists.naming import Naming
from netlists.registry import DeviceFormatter, Dialect
from netlists.write import law
from netlists.write.bsim3 import Form, make_cards, make_transistors
from netlists.write.deck import NOT_RUN, Control, Writer, wrap
from netlists.write.dialect import Cards, Transistors, make_dialect, make_formatter, no_cards
from netlists.write.traversal import Definition

TERMINALS = "dgsb"
# A, by models. BSIM3's currents are noisier: of 52 runs of the rebound neuron (26 dies, two settings) 7 ended
# with a timestep too small at 1e-15, none from 1e-14 to 1e-12; at 1e-13 spikes are within 0.5 us of 1e-14.
_ABSTOL = {"ekv": "1e-15", "bsim3": "1e-13", "sweepable": "1e-15"}
_CACHED = 1 << 14
DIODE_WORDS = {
    "is": "saturation_current", "n": "emission", "cjo": "junction_capacitance", "vj": "junction_potential",
    "m": "grading", "fc": "forward_coefficient", "tt": "transit_time", "bv": "breakdown_voltage",
    "ibv": "breakdown_current", "nbv": "breakdown_emission", "eg": "energy_gap", "xti": "current_exponent",
    "tnom": "nominal_temperature_c",
}  # fmt: skip
"""Words of a diode's `.model` card by SPICE, and our figures."""
_OF_BREAKDOWN = frozenset({"bv", "ibv", "nbv"})


def _capacitor(name: str, a: str, b: str, value: float) -> str:
    return f"c{name} {a} {b} {value!r}"


@dataclass(frozen=True, slots=True)
class Syntax:
    """How a dialect of the SPICE family differs from the others.

    Attributes
    ----------
    dialect, naming
        Its name, and how names of nodes and devices are written.
    current
        Gives the lines of a behavioural current from its name, the node that it leaves, the node that it
        enters after it has passed the source (both as the dialect names them), and its expression in A.
    control
        Gives the cards of analysis and options, and of what is saved.
    runs
        Whether netlists are run here in that simulator.
    separator, case
        What stands between the names of a path in a run, and what folds their case.
    capacitor
        Gives the line of a capacitance, F, from its name and its two nodes.
    diode
        Type and level of a diode's model.
    """

    dialect: str
    naming: Naming
    current: Callable[[str, str, str, str], list[str]]
    control: Callable[[Control], list[str]]
    runs: bool = False
    separator: str = "."
    case: Callable[[str], str] = str
    capacitor: Callable[[str, str, str, float], str] = _capacitor
    diode: tuple[str, ...] = ("d",)


def spice_dialect(
    syntax: Syntax,
    summary: str,
    bsim3: Form | None = None,
    more: Mapping[str, tuple[Transistors, Cards]] = MappingProxyType({}),
) -> Dialect:
    """Make a dialect of the SPICE family.

    Parameters
    ----------
    syntax
        In what it differs from the others.
    summary
        What the list of dialects says about it.
    bsim3
        How it writes BSIM3 cards; unless given, transistors are EKV currents alone.
    more
        What else transistors are in it, by name.
    """
    others = _others(syntax)
    ekv = make_formatter(syntax.dialect, ekv_transistors(syntax), others)
    models: dict[str, tuple[DeviceFormatter, Cards]] = {"ekv": (ekv, no_cards)}
    if bsim3 is not None:
        with_cards = make_formatter(syntax.dialect, make_transistors(bsim3), others)
        models["bsim3"] = (with_cards, make_cards(bsim3))
    for name, (transistors, cards) in more.items():
        models[name] = (make_formatter(syntax.dialect, transistors, others), cards)
    return make_dialect(make_writer(syntax), summary, models)


def make_writer(syntax: Syntax) -> Writer:
    """Make the dialect's part in the walk over a design."""
    return Writer(
        dialect=syntax.dialect,
        remark="" if syntax.runs else NOT_RUN,
        comment="*",
        naming=syntax.naming,
        separator=syntax.separator,
        open=functools.partial(open_definition, syntax.naming),
        close=lambda name: [f".ends {name}"],
        call=lambda name, nodes, definition: wrap([name, *nodes, definition]),
        head=list,
        control=functools.partial(_control, syntax),
        case=syntax.case,
    )


def mos_form(naming: Naming, *version: str, instance: bool) -> Form:
    """Give M elements and their `.model` cards; `version`: the words by which a simulator knows BSIM3 3.3.

    `instance`: whether a transistor takes `delvto` and `mulu0` (`netlists.write.bsim3`).
    """
    return Form(
        naming,
        lambda name, polarity, words: wrap([".model", name, f"{polarity}mos", *version, *words]),
        lambda name, nodes, model, words: wrap([name, *nodes, model, *words]),
        instance,
    )


def tolerances(models: str) -> str:
    """Options gmin (S), abstol (A), chgtol (C), and of equations vntol (V).

    A node that holds a device's `u` (`netlists.write.law`) has 6e-5 at 1 fA, of which ngspice's usual 1 uV is
    some percent: a diode's voltage was 0.6 to 1.5 uV off there.
    """
    held = "" if models == "bsim3" else " vntol=1e-9"
    return f"gmin=1e-15 abstol={_ABSTOL[models]} chgtol=1e-17{held}"


def analysis_card(control: Control, *times: str) -> str:
    """Write the card of the analysis that `control` asks for.

    `times` stand behind the step and the stop time of a transient.
    """
    if control.analysis == "op":
        return ".op"
    uic = ["uic"] if control.uic else []
    return " ".join([".tran", repr(control.step), repr(control.stop), *times, *uic])


def open_definition(naming: Naming, name: str, definition: Definition) -> list[str]:
    """The `.subckt` card."""
    return wrap([".subckt", name, *map(naming.node, definition.ports)])


def ekv_transistors(syntax: Syntax) -> Transistors:
    """Make the formatter of transistors as currents of the law, and capacitances."""
    naming = syntax.naming

    @functools.lru_cache(_CACHED)
    def charges(device: Transistor, model: TransistorModel) -> tuple[str, ...]:
        return tuple(
            syntax.capacitor(naming.part(device.name, tag), naming.node(a), naming.node(b), value)
            for tag, a, b, value in _capacitances(device, model)
        )

    def transistor(device: Transistor, silicon: Silicon, deviation: Deviation) -> list[str]:
        at = _law_of(silicon, device, deviation)
        leaks = at.junction_leakage > 0.0 or at.gate_induced_leakage > 0.0
        lines = law_lines(syntax, device, at, leaks=leaks)
        return [*lines, *charges(device, silicon.process.model(device.polarity))]

    return transistor


def law_lines(syntax: Syntax, device: Transistor, at: TransistorAtTemperature, *, leaks: bool) -> list[str]:
    """Currents of a transistor by its law: the channel's, and the junctions' where it leaks."""
    naming, between = syntax.naming, difference(syntax.naming)
    drain, source, bulk = map(naming.node, (device.drain, device.source, device.bulk))
    turn = device.polarity == "p"

    def current(name: str, start: str, end: str, expression: str) -> list[str]:
        return syntax.current(name, *((end, start) if turn else (start, end)), expression)

    def held(tag: str) -> str:
        return f"v({naming.part(device.name, tag)})"

    channel = law.channel_current(device, at, between, held)
    lines = current(naming.plain(device.name), drain, source, channel.current)
    for tag, value in channel.terms.items():
        # a current of the node's own voltage, so that it needs no other element
        node = naming.part(device.name, tag)
        lines += syntax.current(node, GROUND, node, f"{value}-{held(tag)}")
    if leaks:
        for terminal, node, letter in ((device.drain, drain, "d"), (device.source, source, "s")):
            if node == bulk:  # no voltage, no current
                continue
            leak = law.junction_current(device, at, terminal, between)
            lines += current(naming.part(device.name, f"{letter}b"), node, bulk, leak)
    return lines


def format_amplifier(syntax: Syntax, device: OperationalAmplifier) -> list[str]:
    """Currents of an operational amplifier from its output to both supplies."""
    naming = syntax.naming
    up, down = law.amplifier_currents(device, difference(naming))
    out, top, bottom = map(naming.node, (device.output, device.vdd, device.vss))
    return [
        *syntax.current(naming.part(device.name, "up"), out, top, up),
        *syntax.current(naming.part(device.name, "down"), out, bottom, down),
    ]


def _law_of(silicon: Silicon, device: Transistor, deviation: Deviation) -> TransistorAtTemperature:
    """Law of a transistor: what the die shares, what its size and what its place adds."""
    shared = _shared_law(silicon, device.polarity).of_size(device.width, device.length)
    return replace(
        shared,
        v_t0=float(shared.v_t0 + deviation.v_t0),
        square_current=float(shared.square_current * (1.0 + deviation.beta)),
    )


@functools.lru_cache(8)
def _shared_law(silicon: Silicon, polarity: Polarity) -> TransistorAtTemperature:
    return silicon.law(polarity)


def _capacitances(device: Transistor, model: TransistorModel) -> list[tuple[str, str, str, float]]:
    """Capacitances of a transistor that are between two nodes: tag, our two nodes, F."""
    size = (np.array([device.width]), np.array([device.length]), np.array([device.multiplicity]))
    ends = device.terminals()
    found = capacitances(model, *size).items()
    return [
        (TERMINALS[i] + TERMINALS[j], ends[i], ends[j], float(value[0]))
        for (i, j), value in found
        if ends[i] != ends[j]
    ]


def difference(naming: Naming) -> law.Difference:
    """Text of the voltage between two of our nodes, `v(a,b)`."""

    def between(a: str, b: str) -> str:
        if a == b:
            return law.ZERO
        if b == GROUND:
            return f"v({naming.node(a)})"
        return f"(-v({naming.node(b)}))" if a == GROUND else f"v({naming.node(a)},{naming.node(b)})"

    return between


def corners(source: Source) -> list[tuple[float, float]]:
    """Vertices (s, value) of a source from time 0, where a run begins; earlier ones are cut off there."""
    time, value = polyline(source.name, source.waveform)
    first = float(np.interp(0.0, time, value))
    kept = time > 0.0
    return [(0.0, first), *zip(time[kept].tolist(), value[kept].tolist(), strict=True)]


def _control(syntax: Syntax, control: Control) -> list[str]:
    """What stands at the end: voltages to begin with, the dialect's own cards, `.end`."""
    return [
        *_voltages(".nodeset", control.starts),
        *_voltages(".ic", control.held),
        *syntax.control(control),
        ".end",
    ]


def _voltages(word: str, voltages: Sequence[tuple[str, float]]) -> list[str]:
    """A card of voltages, as `.ic v(a)=1.0`; none without any."""
    return wrap([word, *(f"v({name})={v!r}" for name, v in voltages)]) if voltages else []


def _others(syntax: Syntax) -> dict[type[Device], Callable[[Any], list[str]]]:
    """Lines of all devices but transistors."""
    naming = syntax.naming

    def element(letter: str, device: Device, value: float) -> str:
        nodes = map(naming.node, device.terminals())
        return " ".join((letter + naming.plain(device.name), *nodes, repr(float(value))))

    def capacitor(device: Capacitor) -> list[str]:
        begin = "" if device.ic is None else f" ic={float(device.ic)!r}"
        return [element("c", device, device.capacitance) + begin]

    return {
        Capacitor: capacitor,
        Resistor: lambda device: [element("r", device, device.resistance)],
        Diode: functools.partial(_diode, syntax),
        ControlledSource: lambda device: [element("g", device, device.transconductance)],
        OperationalAmplifier: functools.partial(format_amplifier, syntax),
        Source: functools.partial(_source, naming),
    }


def _diode(syntax: Syntax, device: Diode) -> list[str]:
    """A D element, and the model that is its own."""
    naming = syntax.naming
    nodes, model = map(naming.node, device.terminals()), naming.part(device.name, "model")
    words = ["d" + naming.plain(device.name), *nodes, model, f"area={float(device.area)!r}"]
    return [" ".join(words), *wrap([".model", model, *syntax.diode, *diode_figures(device)])]


def diode_figures(device: Diode) -> list[str]:
    """Figures of a diode's `.model` card by SPICE's names; those of breakdown only where it breaks down."""
    values = {word: float(getattr(device, name)) for word, name in DIODE_WORDS.items()}
    without = _OF_BREAKDOWN if device.breakdown_voltage == 0.0 else frozenset()
    return [f"{word}={value!r}" for word, value in values.items() if word not in without]


def _source(naming: Naming, source: Source) -> list[str]:
    """The card of a source of one node."""
    pairs = corners(source)
    head = "v" if source.quantity == "voltage" else "i"
    ends = (source.node, GROUND) if head == "v" else (GROUND, source.node)
    direct = pairs[0][1] if source.direct is None else float(source.direct)
    words = [head + naming.text(source.name), *map(naming.node, ends), "dc", repr(direct)]
    if len(pairs) > 1:
        vertices = [f"{t!r} {v!r}" for t, v in pairs]
        words += ["pwl(" + vertices[0], *vertices[1:-1], vertices[-1] + ")"]
    return wrap(words)
