"""A circuit that was built with PySpice, taken over as a testbench of ours.

Its devices become a circuit, its sources the stimuli. These elements are taken over:

- R, C, M, X of a `SubCircuit`, and D by its `.model` (`netlists.read.model.diode`);
- V and I between ground and a node of the top: constant, `PulseVoltageSource`, `PieceWiseLinearVoltageSource`
  and their current forms, or a `pwl(...)` of plain numbers as raw text.

Everything else is refused by name: another element, raw text, a parameter, an include, a value that is an
expression. A transistor takes its polarity from its `.model`. A model with figures of its own is refused
unless `drop` names it, because here the process says what silicon is. The process also gives what belongs to
the layout (`ad as pd ps nrd nrs`), so these values are left behind.

Names. Upper and lower case do not differ, as in SPICE. A name that does not begin with a letter gets an `n`
in front; any other character that a name of ours cannot have becomes `_`; where two names would become one,
the second gets a number. Elements keep PySpice's names, letter included (`R1`). Nodes with a source become
ports.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from itertools import count
from typing import Any

import numpy as np

from circuits.circuit import GROUND, Circuit, Instance, Port
from circuits.devices import Capacitor, Resistor, Source, Transistor
from circuits.devices.device import Device
from circuits.devices.source import Constant, PiecewiseLinear, Pulse, Waveform, polyline
from circuits.errors import DataError, unknown_name
from circuits.silicon.process import Polarity
from circuits.testbench import Testbench
from netlists.read.card import Arguments, Card
from netlists.read.element import NOMINAL_C
from netlists.read.model.diode import diode_of
from netlists.read.note import Notes, drop_names
from netlists.read.number import read_number
from netlists.read.text.section import Model

_GROUNDS = frozenset({"0", "gnd"})
_POLARITIES: Mapping[str, Polarity] = {"nmos": "n", "pmos": "p"}
_PWL = re.compile(r"pwl\s*\(([^()]*)\)", re.IGNORECASE)
_OUTSIDE = {
    "_includes": "include",
    "_libs": "lib",
    "_parameters": "parameter",
    "_global_nodes": "global node",
}
_LAYOUT = frozenset(
    f"{end}_{x}" for end in ("drain", "source") for x in ("area", "perimeter", "number_square")
)
# what is taken over of each class of element; a value under another name is refused
_TAKEN = {
    "Resistor": frozenset({"resistance"}),
    "Capacitor": frozenset({"capacitance", "initial_condition"}),
    "Diode": frozenset({"model", "area", "multiplier"}),
    "Mosfet": frozenset({"model", "width", "length", "multiplier"}) | _LAYOUT,
    "SubCircuitElement": frozenset({"subcircuit_name"}),
    "VoltageSource": frozenset({"dc_value"}),
    "CurrentSource": frozenset({"dc_value"}),
    **{f"{wave}{kind}Source": frozenset[str]() for wave in ("Pulse", "PieceWiseLinear")
       for kind in ("Voltage", "Current")},
}  # fmt: skip
_LARGEST_TRAIN = 100_000  # pulses of one source


def from_pyspice(
    circuit: Any,
    *,
    stop: float = float("inf"),
    polarities: Mapping[str, Polarity] | None = None,
    drop: Iterable[str] = (),
) -> Testbench:
    """Take over a PySpice circuit of R, C, D, V, I, M and X elements as a testbench.

    Parameters
    ----------
    circuit
        The circuit, a `PySpice.Spice.Netlist.Circuit`.
    stop
        End of the run, s; periodic pulses go on until then.
    polarities
        `n` or `p` by the name of a model, for models whose `.model` is not in the circuit.
    drop
        Names of models whose figures may be ignored; `.model` stands for all models.

    Raises
    ------
    DataError
        What cannot be taken over, with the element's name.
    ParameterError
        A value that breaks its device's rule, or is no number.
    UnknownNameError
        A sub-circuit or a model that the PySpice circuit does not have.
    """
    for attribute, word in _OUTSIDE.items():
        for item in vars(circuit)[attribute]:
            raise DataError(f"{circuit.title}: {word} {item}, cannot be taken over; build its contents")
    title = " ".join(circuit.title.split()) or "circuit"
    given = {k.lower(): v for k, v in (polarities or {}).items()}
    scope = _Scope(title, given, drop_names(drop)).inside(circuit, title)
    names = _Names()
    sources = tuple(
        _source(e, names, stop, title) for e in _enabled(circuit) if type(e).__name__.endswith("Source")
    )
    ports = tuple(
        Port(s.node, "supply" if s.quantity == "voltage" and isinstance(s.waveform, Constant) else "analog")
        for s in {s.node: s for s in sources}.values()
    )
    return Testbench(title, _circuit(circuit, _Names().element(title), ports, names, scope), sources, stop)


@dataclass(slots=True)
class _Names:
    """Names of ours by those of PySpice, of one circuit's nodes and elements."""

    nodes: dict[str, str] = field(default_factory=dict)
    elements: dict[str, str] = field(default_factory=dict)

    def node(self, name: str) -> str:
        return GROUND if name.lower() in _GROUNDS else _legal(name, self.nodes)

    def element(self, name: str) -> str:
        return _legal(name, self.elements)


@dataclass(frozen=True, slots=True)
class _Scope:
    """Where names are looked up: what a netlist defines, then what those around it do."""

    path: str
    polarities: Mapping[str, Polarity]
    drop: frozenset[str] = frozenset()
    figures: Mapping[str, str] = field(default_factory=dict)  # of a model, by its name
    models: Mapping[str, Any] = field(default_factory=dict)  # of PySpice, by name
    subcircuits: Mapping[str, tuple[Any, _Scope]] = field(default_factory=dict)
    open: tuple[str, ...] = ()  # sub-circuits that are being taken over
    made: dict[int, Circuit] = field(default_factory=dict)  # by the sub-circuit's id, which lives as long

    def inside(self, netlist: Any, path: str) -> _Scope:
        """Scope of the elements of `netlist`."""
        models = {m.name.lower(): m for m in netlist.models}
        kinds = {name: m.model_type.lower() for name, m in models.items()}
        known = {name: _POLARITIES[kind] for name, kind in kinds.items() if kind in _POLARITIES}
        figures = {name: ", ".join(m.parameters) for name, m in models.items()}
        found = dict(self.subcircuits)
        inner = replace(
            self,
            path=path,
            polarities={**self.polarities, **known},
            figures={**self.figures, **figures},
            models={**self.models, **models},
            subcircuits=found,
        )
        found.update({s.name.lower(): (s, inner) for s in netlist.subcircuits})
        return inner


def _circuit(netlist: Any, name: str, ports: tuple[Port, ...], names: _Names, scope: _Scope) -> Circuit:
    """Circuit of the netlist's devices and instances; its sources have been dealt with."""
    if netlist.raw_spice:
        raise DataError(f"{scope.path}: raw text in the netlist, cannot be taken over; build its elements")
    devices: list[Device] = []
    instances: list[Instance] = []
    for e in _enabled(netlist):
        _require_known(e, scope.path)
        if type(e).__name__ == "SubCircuitElement":
            instances.append(_instance(e, names, scope))
        elif type(e).__name__ == "Diode":
            devices += _diode(e, names, scope)
        elif not type(e).__name__.endswith("Source"):
            devices.append(_device(e, names, scope))
        elif scope.open:
            raise DataError(f"{scope.path}.{e.name}: a source in a sub-circuit; put it at the top")
    return Circuit(name, ports, tuple(devices), tuple(instances))


def _instance(e: Any, names: _Names, scope: _Scope) -> Instance:
    wanted = str(e.subcircuit_name).lower()
    if e.parameters:
        raise DataError(f"{scope.path}.{e.name}: parameters {sorted(e.parameters)}; write the values inside")
    if wanted not in scope.subcircuits:
        known = (s.name for s, _ in scope.subcircuits.values())
        raise unknown_name(f"{scope.path}.{e.name}: sub-circuit", str(e.subcircuit_name), known)
    if wanted in scope.open:
        raise DataError(f"{scope.path}.{e.name}: sub-circuit {wanted} contains itself; break the cycle")
    sub, around = scope.subcircuits[wanted]
    if sub.parameters:
        raise DataError(f"{sub.name}: parameters {sorted(sub.parameters)}; write the values inside")
    outer = [names.node(n) for n in _nodes(e)]
    if id(sub) not in scope.made:
        scope.made[id(sub)] = _definition(sub, replace(around, open=(*scope.open, wanted)), scope.path)
    body = scope.made[id(sub)]
    if len(body.ports) != len(outer):
        raise DataError(
            f"{scope.path}.{e.name}: {len(outer)} nodes, must be {len(body.ports)} as {sub.name} has"
        )
    connections = dict(zip((p.name for p in body.ports), outer, strict=True))
    return Instance(names.element(e.name), body, connections)


def _definition(sub: Any, around: _Scope, path: str) -> Circuit:
    names = _Names()
    ports = tuple(Port(names.node(str(n)), "analog") for n in sub.external_nodes)
    return _circuit(sub, _Names().element(sub.name), ports, names, around.inside(sub, f"{path}.{sub.name}"))


def _device(e: Any, names: _Names, scope: _Scope) -> Device:
    name, (a, b, *rest) = names.element(e.name), [names.node(n) for n in _nodes(e)]
    if e.PREFIX == "R":
        return Resistor(name, a, b, _number(e, "resistance", "Ohm", scope.path))
    if e.PREFIX == "C":
        ic = None if e.initial_condition is None else _number(e, "initial_condition", "V", scope.path)
        return Capacitor(name, a, b, _number(e, "capacitance", "F", scope.path), ic)
    model = str(e.model).lower()
    if model not in scope.polarities:
        raise unknown_name(f"{scope.path}.{e.name}: model", str(e.model), scope.polarities)
    if scope.figures.get(model) and not scope.drop & {model, ".model"}:
        raise DataError(
            f"{scope.path}.{e.name}: .model {e.model}: parameters {scope.figures[model]}: not honoured;"
            f" transistors have the law of the process, give the model none, or drop=[{model!r}]"
        )
    width, length = (_number(e, a, "m", scope.path) for a in ("width", "length"))
    parallel = 1.0 if e.multiplier is None else float(e.multiplier)
    source, bulk = rest
    return Transistor(name, scope.polarities[model], a, b, source, bulk, width, length, parallel)


def _diode(e: Any, names: _Names, scope: _Scope) -> Iterator[Device]:
    """A diode, and the resistor before it where its model has RS."""
    model = scope.models.get(str(e.model).lower())
    if model is None:
        raise unknown_name(f"{scope.path}.{e.name}: model", str(e.model), scope.models)
    card = Card("", scope.path, 0)
    figures = {word.lower(): _text(model[word]) for word in model.parameters}
    given = {key: _text(value) for key, value in (("area", e.area), ("m", e.multiplier)) if value is not None}
    words = Arguments([*(names.node(n) for n in _nodes(e)), str(e.model)], given)
    kind = Model(str(e.model), model.model_type.lower(), figures, card)
    try:
        if kind.type != "d":
            raise card.error(
                f"{e.name}: model {e.model}: type {kind.type}, must be d; give it one of a diode"
            )
        diode, series = diode_of(card, names.element(e.name), words, kind, (_read, _read), NOMINAL_C, Notes())
    except DataError as error:
        raise DataError(f"{scope.path}.{str(error).removeprefix(f'{card.place}: ')}") from None
    yield replace(diode, name=names.element(e.name))
    if series is not None:
        yield series


def _text(value: Any) -> str:
    return value if isinstance(value, str) else repr(float(value))


def _read(card: Card, what: str, text: str) -> float:
    return _spice_number(text, what)


def _source(e: Any, names: _Names, stop: float, path: str) -> Source:
    """Source between ground and a node; a current of SPICE leaves its first node."""
    _require_known(e, path)
    plus, minus = (names.node(n) for n in _nodes(e))
    if (plus == GROUND) == (minus == GROUND):
        raise DataError(f"{path}.{e.name}: from {plus} to {minus}, must have one end at ground")
    voltage = e.PREFIX == "V"
    sign = 1.0 if (minus == GROUND) == voltage else -1.0
    wave = _waveform(e, stop, f"{path}.{e.name}")
    direct = _direct(e, wave, f"{path}.{e.name}")
    if isinstance(wave, Constant):
        wave = Constant(sign * wave.value)
    elif sign < 0.0:
        time, value = polyline(e.name, wave)
        wave = PiecewiseLinear(tuple(time.tolist()), tuple((sign * value).tolist()))
    node = plus if minus == GROUND else minus
    given = None if direct is None else sign * direct
    return Source(names.element(e.name), node, wave, "voltage" if voltage else "current", given)


def _direct(e: Any, wave: Waveform, path: str) -> float | None:
    """What a source gives to an analysis without time beside raw text, where that is another value."""
    if isinstance(wave, Constant) or not e.raw_spice or e.dc_value is None:
        return None
    found = _number(e, "dc_value", "V" if e.PREFIX == "V" else "A", path.rpartition(".")[0])
    time, value = polyline(e.name, wave)
    return None if found == float(np.interp(0.0, time, value)) else found


def _waveform(e: Any, stop: float, path: str) -> Waveform:
    kind = type(e).__name__
    if kind.startswith("Pulse"):
        return _pulses(e, stop, path)
    if kind.startswith("PieceWiseLinear"):
        if e.repeat_time is not None or e.delay_time is not None:
            raise DataError(f"{path}: a repeated or delayed piecewise-linear source; write its vertices")
        return _vertices([float(x) for x in e.values], path)
    if e.raw_spice:
        found = _PWL.fullmatch(e.raw_spice.strip())
        if found is None:
            raise DataError(f"{path}: raw text {e.raw_spice!r}, must be pwl(time value ...) or nothing")
        return _vertices([_spice_number(t, path) for t in re.split(r"[\s,]+", found[1].strip())], path)
    return Constant(_number(e, "dc_value", "V" if e.PREFIX == "V" else "A", path.rpartition(".")[0]))


def _pulses(e: Any, stop: float, path: str) -> Pulse:
    """Train of pulses until `stop`; SPICE's pulse without a period is taken as one."""
    low, high = float(e.initial_value), float(e.pulsed_value)
    delay, width, period = float(e.delay_time), float(e.pulse_width), float(e.period)
    if e.phase is not None:
        raise DataError(f"{path}: a phase, cannot be taken over; write it as a delay")
    number = 1 if period <= 0.0 else np.ceil(max(stop - delay, period) / period)
    if number > _LARGEST_TRAIN:
        raise DataError(f"{path}: {number:g} pulses until {stop:g} s, at most {_LARGEST_TRAIN}; give a stop")
    starts = tuple(float(delay + k * period) for k in range(int(number)))
    return Pulse(low, high, starts, width, float(e.rise_time), float(e.fall_time))


def _vertices(numbers: list[float], path: str) -> PiecewiseLinear:
    if len(numbers) % 2 or not numbers:
        raise DataError(f"{path}: {len(numbers)} numbers, must be pairs of time and value")
    return PiecewiseLinear(tuple(numbers[::2]), tuple(numbers[1::2]))


def _require_known(e: Any, path: str) -> None:
    """Refuse an element, or a part of it, that would be lost."""
    kind = type(e).__name__
    if kind not in _TAKEN:
        raise DataError(f"{path}.{e.name}: {kind}, must be one of R C D V I M X; replace it")
    if e.raw_spice and kind not in {"VoltageSource", "CurrentSource"}:
        raise DataError(f"{path}.{e.name}: raw text {e.raw_spice!r}, cannot be taken over; leave it out")
    for parameter in e.parameter_iterator():
        if parameter.attribute_name not in _TAKEN[kind]:
            raise DataError(f"{path}.{e.name}.{parameter.attribute_name}: cannot be taken over; leave it out")


def _number(e: Any, attribute: str, unit: str, path: str) -> float:
    """Value of an attribute in SI: a number, PySpice's with a unit, or text with a suffix."""
    value, name = getattr(e, attribute), f"{path}.{e.name}.{attribute}"
    if value is None:
        raise DataError(f"{name}: missing; give it in {unit}")
    return _spice_number(value, name) if isinstance(value, str) else float(value)


def _spice_number(text: str, name: str) -> float:
    value = read_number(text.strip())
    if value is None or not np.isfinite(value):
        raise DataError(f"{name}: {text!r}, must be a number as SPICE writes it; write as in 1.5k")
    return value


def _enabled(netlist: Any) -> Iterable[Any]:
    return (e for e in netlist.elements if e.enabled)


def _nodes(e: Any) -> list[str]:
    return [str(pin.node) for pin in e.pins]


def _legal(name: str, taken: dict[str, str]) -> str:
    """Name of ours for `name`, the same every time; `taken`: those given out, by PySpice's in lower case."""
    if name.lower() not in taken:
        plain = re.sub(r"[^A-Za-z0-9_]", "_", name)
        plain = plain if plain[:1].isalpha() or plain[:1] == "_" else f"n{plain}"
        used = {n.lower() for n in taken.values()}
        candidates = (plain if k == 1 else f"{plain}_{k}" for k in count(1))
        taken[name.lower()] = next(c for c in candidates if c.lower() not in used)
    return taken[name.lower()]
