"""Structured comments of a netlist, called notes, from which our own data can be read back.

A simulator skips them. A reader needs them for what the lines of a netlist do not say: names, arrays, kinds
of biases, the die. A note is a comment that begins with `% ` right after the dialect's comment sign (`*% ` in
the SPICE family, `//% ` in Spectre and Verilog-A). `%+ ` continues the note before it:

    note   = kind field*

A note holds one frozen dataclass, which its kind names (`KINDS`), with the fields in order.
`netlists.write.field_text` has the grammar of fields. These notes stand in a netlist, in this order:

    noctule       format version, dialect, transistor models                            (`Header`)
    process, variation, components, diodes, nmos, pmos, silicon, die, plan: the `Silicon` of the netlist
                  (`silicon_notes`); `components` and `diodes` where its process states them
    circuit       right after a definition's first line: the circuit's name; the definition may be `NAME_2`
    port, node, bias: of that circuit, in its order
    transistor, amplifier, diode: the device that the lines up to the next note or device write, with the
                  values that it has in this definition; `deviation` before them is what its place on the die
                  adds
    capacitor, resistor, diode: one that a die changes, as it is drawn; `change` before it says by how much
    instance, array: before its calls; connections are references of the calling circuit
    parameter     of the instance or array before it: values of `shape`, nested tuples when read; `base` is
                  the value in the instance's own circuit, which the called definitions replace
    testbench     before the call of the top definition
    source, then constant, pulse, polyline, sampled or driven: a source of the testbench, and the lines that
                  write it, one for each element of its port
    parasitic     the next line is a capacitance from a layout, no part of the circuit
    biased        the next line sets a bias port as the circuit's `bias` says, at the silicon's temperature

Other resistors and capacitors, and linear controlled sources, need no note: their line says all. Where
it does not, as in Verilog-A, or in CDL for a controlled source, there are `resistor`, `capacitor` and
`transconductor`.

Reading. The circuit of a definition has the devices as they are written. The circuit of an instance is that
of the definition of its first call, with each parameter of the instance set to its `base`; a dotted key
reaches into instances. The notes are believed only if writing what was read gives the lines that were read. A
line that was edited under its note is refused.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field, fields, replace
from typing import Any, Literal, NamedTuple, get_args

import numpy as np

from circuits.brief import OPTIONAL
from circuits.circuit import Bias, Circuit, Instance, InstanceArray, Node, Port, Shape
from circuits.devices import Capacitor, ControlledSource, OperationalAmplifier, Resistor, Source, Transistor
from circuits.devices.device import Device
from circuits.devices.diode import Diode
from circuits.devices.source import Constant, Driven, PiecewiseLinear, Pulse, Sampled, Waveform
from circuits.errors import DataError
from circuits.silicon.components import Components, Extent
from circuits.silicon.die import Corner, Die, Place
from circuits.silicon.edit import KINDS as KINDS_OF_EDIT
from circuits.silicon.edit import Edit
from circuits.silicon.process import DiodeVariation, Process, TransistorModel, Variation
from circuits.silicon.sampling import Sampling
from circuits.silicon.silicon import Change, Deviation, Silicon
from circuits.testbench import Begin, Testbench
from netlists.write.field_text import NumberPairs, Pairs, format_fields, parse_fields

FORMAT_VERSION = 1
_BEGINS, _CONTINUES = "% ", "%+ "  # after the comment sign

_WIDTH = 100
_EXPLICIT = frozenset(
    {"variation", "components", "diodes", "nmos", "pmos"}
)  # a later default must not change an old netlist


@dataclass(frozen=True, slots=True)
class Header:
    """The first note: what a netlist is.

    version: version of the format of the notes. dialect: name of the dialect that the netlist is written in.
    models: name of the transistor models that it uses.
    """

    version: int
    dialect: str
    models: str


@dataclass(frozen=True, slots=True)
class ProcessFigures:
    """Figures of a `Process` beside its transistors and its variation.

    Attributes
    ----------
    name : str
        Name of the process.
    v_dd : float
        Supply voltage, V.
    pair_a_vt : float
        Pelgrom coefficient of the threshold difference of a pair, V m.
    pair_a_beta : float
        Pelgrom coefficient of the relative current factor of a pair, m.
    nominal_temperature_c : float
        Temperature that the transistors' figures are for, degC.
    """

    name: str
    v_dd: float
    pair_a_vt: float
    pair_a_beta: float
    nominal_temperature_c: float


@dataclass(frozen=True, slots=True)
class Surroundings:
    """Temperature and place of a `Silicon`.

    Attributes
    ----------
    temperature_c : float
        Temperature, degC.
    place : Place or None
        Where the circuit stands on the die: names with their indices; None for a place of its own.
    """

    temperature_c: float
    place: Place | None = None


@dataclass(frozen=True, slots=True)
class DieNote:
    """A `Die` without its plan of samples.

    Attributes
    ----------
    lot : str
        Name of the lot.
    number : int or None
        Number of the die in the lot, or None for the nominal die.
    corner : str
        Corner of the process, one of `circuits.silicon.die.CORNERS`.
    mismatch : bool
        Whether its devices deviate from one another.
    process : bool
        Whether it has a process deviation of its own.
    variation : str
        Which components of variation it has beside, one of `circuits.silicon.components.EXTENTS`.
    edits : tuple of (str, float)
        What was changed of it by hand: `heal` or `only` with paths, or `set` with a path and its parameter,
        and the deviation that is set, 0 for the others.
    """

    lot: str
    number: int | None = None
    corner: Corner = "random"
    mismatch: bool = True
    process: bool = True
    variation: Extent = "plain"
    edits: tuple[tuple[str, float], ...] = ()


@dataclass(frozen=True, slots=True)
class Plan:
    """What a sampling plan sets on this die.

    Attributes
    ----------
    name : str
        Name of the plan.
    draws : tuple of (str, float)
        Standard normal, dimensionless, of each label.
    """

    name: str
    draws: NumberPairs


@dataclass(frozen=True, slots=True)
class CircuitName:
    """The circuit that a definition writes.

    Attributes
    ----------
    name : str
        Name of the circuit.
    """

    name: str


@dataclass(frozen=True, slots=True)
class LocalDeviation:
    """What its place on the die adds to the next device.

    Attributes
    ----------
    v_t0 : float
        Added to the magnitude of the threshold voltage, V.
    beta : float
        Relative change of the current factor, dimensionless.
    """

    v_t0: float
    beta: float


@dataclass(frozen=True, slots=True)
class ChangeNote:
    """What the die changes of the next capacitor, resistor or diode.

    Attributes
    ----------
    value : float
        Relative change of the capacitance, resistance or saturation current, dimensionless.
    """

    value: float


@dataclass(frozen=True, slots=True)
class InstanceNote:
    """An `Instance` without its circuit and its parameters.

    name: name of the instance. connections: port of its circuit, and the node of the calling circuit on it.
    """

    name: str
    connections: Pairs


@dataclass(frozen=True, slots=True)
class ArrayNote:
    """An `InstanceArray` without its circuit and its parameters.

    Attributes
    ----------
    name : str
        Name of the array.
    shape : tuple of int
        How many instances it has along each axis.
    connections : tuple of (str, str)
        Port of its circuit, and the node or node array of the calling circuit on it.
    """

    name: str
    shape: Shape
    connections: Pairs


@dataclass(frozen=True, slots=True)
class ParameterNote:
    """A parameter of the instance or array of the note before it.

    Attributes
    ----------
    key : str
        Device and parameter, such as `m1.width`; a dotted name reaches into instances.
    values : tuple of float
        Value of every element in row-major order, in the SI unit of the parameter.
    base : float
        Value in the circuit of the instance itself, in the same unit.
    shape : tuple of int
        Shape of `values`; () for one number.
    """

    key: str
    values: tuple[float, ...]
    base: float
    shape: Shape = ()


@dataclass(frozen=True, slots=True)
class BenchNote:
    """A `Testbench` without its circuit and its sources.

    Attributes
    ----------
    title : str
        Title of the netlist.
    stop : float
        End of the run, s.
    watch : tuple of str
        Ports whose events are watched.
    start : tuple of (str, float)
        Voltages (V) by path, from which the operating point is sought.
    initial : tuple of (str, float)
        Voltages (V) by path that hold at time 0.
    begin : str
        How a run begins, as `Testbench.begin` says it.
    """

    title: str
    stop: float
    watch: tuple[str, ...] = ()
    start: NumberPairs = ()
    initial: NumberPairs = ()
    begin: Begin = "disturbed"


@dataclass(frozen=True, slots=True)
class SourceNote:
    """A `Source` without its waveform.

    name: name of the source. node: node that it drives against ground. quantity: `voltage` or `current`.
    direct: what it gives to an analysis without time, V or A.
    """

    name: str
    node: str
    quantity: Literal["voltage", "current"] = "voltage"
    direct: float | None = field(default=None, metadata=OPTIONAL)


@dataclass(frozen=True, slots=True)
class Biased:
    """The next line sets a bias.

    Attributes
    ----------
    node : str
        A bias port, or an element of it.
    """

    node: str


@dataclass(frozen=True, slots=True)
class Parasitic:
    """The next line is a capacitance from a layout and no part of the circuit.

    Attributes
    ----------
    name : str
        Name of the line's own element.
    """

    name: str


KINDS: dict[str, type] = {
    "noctule": Header,
    "process": ProcessFigures,
    "variation": Variation,
    "components": Components,
    "diodes": DiodeVariation,
    "nmos": TransistorModel,
    "pmos": TransistorModel,
    "silicon": Surroundings,
    "die": DieNote,
    "plan": Plan,
    "circuit": CircuitName,
    "port": Port,
    "node": Node,
    "bias": Bias,
    "transistor": Transistor,
    "amplifier": OperationalAmplifier,
    "diode": Diode,
    "deviation": LocalDeviation,
    "change": ChangeNote,
    "instance": InstanceNote,
    "array": ArrayNote,
    "parameter": ParameterNote,
    "testbench": BenchNote,
    "source": SourceNote,
    "constant": Constant,
    "pulse": Pulse,
    "polyline": PiecewiseLinear,
    "sampled": Sampled,
    "driven": Driven,
    "biased": Biased,
    "parasitic": Parasitic,
    "capacitor": Capacitor,
    "resistor": Resistor,
    "transconductor": ControlledSource,
}
_DEVICES: dict[type[Device], str] = {
    Transistor: "transistor", OperationalAmplifier: "amplifier", Diode: "diode",
}  # fmt: skip
_CHANGED: dict[type[Device], str] = {Capacitor: "capacitor", Resistor: "resistor", Diode: "diode"}
_WAVEFORMS = {kind: name for name, kind in KINDS.items() if kind in get_args(Waveform)}


class Annotation(NamedTuple):
    """One note of a netlist.

    Attributes
    ----------
    kind : str
        A key of `KINDS`.
    value : object
        A value of the dataclass that `KINDS` has under that key.
    """

    kind: str
    value: Any


def format_annotation(note: Annotation, comment: str = "*") -> list[str]:
    """Write a note as lines of comment.

    Parameters
    ----------
    note
        The note.
    comment
        The dialect's comment sign.
    """
    lines, line = [], f"{comment}{_BEGINS}{note.kind}"
    for word in format_fields(note.value, all_fields=note.kind in _EXPLICIT):
        if len(line) + len(word) >= _WIDTH:
            lines.append(line)
            line = f"{comment}{_CONTINUES}{word}"
        else:
            line += f" {word}"
    return [*lines, line]


def parse_annotation(text: str) -> Annotation:
    """Read a note from its text: its lines without comment signs and marks, joined by spaces.

    Raises
    ------
    DataError
        There is no such kind or field, a field is missing or twice there, or a value is none of its type.
    """
    kind, *words = text.split() or [""]
    if kind not in KINDS:
        raise DataError(f"note {kind[:40]!r}: unknown kind; known are {', '.join(KINDS)}")
    return Annotation(kind, parse_fields(f"note {kind}", KINDS[kind], words))


def silicon_notes(silicon: Silicon) -> list[Annotation]:
    """Make the notes of a `silicon`: its process, its temperature, its place and its die."""
    process = silicon.process
    figures = {f.name: getattr(process, f.name) for f in fields(ProcessFigures)}
    return [
        Annotation("process", ProcessFigures(**figures)),
        Annotation("variation", process.variation),
        *([] if process.components is None else [Annotation("components", process.components)]),
        *([] if process.diodes is None else [Annotation("diodes", process.diodes)]),
        Annotation("nmos", process.n),
        Annotation("pmos", process.p),
        Annotation("silicon", Surroundings(silicon.temperature_c, silicon.place)),
        *_die_notes(silicon.die),
    ]


def to_silicon(notes: Iterable[Annotation]) -> Silicon:
    """Make the silicon that its `notes` describe.

    Raises
    ------
    DataError
        A note is missing.
    ParameterError
        A value breaks a rule of the silicon.
    """
    found = {note.kind: note.value for note in notes}
    missing = next(
        (k for k in ("process", "variation", "nmos", "pmos", "silicon", "die") if k not in found), ""
    )
    if missing:
        raise DataError(f"note {missing}: missing; a netlist with notes has one")
    figures: ProcessFigures = found["process"]
    process = Process(
        figures.name, found["nmos"], found["pmos"], figures.v_dd, figures.pair_a_vt, figures.pair_a_beta,
        figures.nominal_temperature_c, found["variation"], found.get("components"),
        diodes=found.get("diodes"),
    )  # fmt: skip
    surroundings: Surroundings = found["silicon"]
    die = _to_die(found["die"], found.get("plan"))
    return Silicon(process, surroundings.temperature_c, die, surroundings.place)


def circuit_notes(circuit: Circuit) -> list[Annotation]:
    """Make the notes of a circuit: its name, its ports, its node arrays and its biases."""
    return [
        Annotation("circuit", CircuitName(circuit.name)),
        *(Annotation("port", port) for port in circuit.ports),
        *(Annotation("node", node) for node in circuit.nodes),
        *(Annotation("bias", bias) for bias in circuit.biases),
    ]


def instance_notes(instance: Instance | InstanceArray) -> list[Annotation]:
    """Make the notes of an instance or an array of instances, and of its parameters."""
    connections = tuple(instance.connections.items())
    head = (
        Annotation("instance", InstanceNote(instance.name, connections))
        if isinstance(instance, Instance)
        else Annotation("array", ArrayNote(instance.name, instance.shape, connections))
    )
    return [head, *(_parameter_note(instance.circuit, k, v) for k, v in instance.parameters.items())]


def device_notes(device: Device, deviation: Deviation | Change) -> list[Annotation]:
    """Make the notes of a device whose lines do not say all of it; there are none for any other device.

    `deviation` is what the die changes of the device: a note of its own, unless it is zero.
    """
    if isinstance(deviation, Change):
        kind = _CHANGED[type(device)]
        return [Annotation("change", ChangeNote(float(deviation.value))), Annotation(kind, device)]
    kind = _DEVICES.get(type(device), "")
    if not kind:
        return []
    own = Annotation(kind, device)
    if not deviation.v_t0 and not deviation.beta:
        return [own]
    return [Annotation("deviation", LocalDeviation(float(deviation.v_t0), float(deviation.beta))), own]


def bench_note(testbench: Testbench) -> Annotation:
    """Make the note of a testbench: its title, stop time, watched ports, and where its runs begin."""
    start, initial = tuple(testbench.start.items()), tuple(testbench.initial.items())
    return Annotation(
        "testbench",
        BenchNote(testbench.title, testbench.stop, testbench.watch, start, initial, testbench.begin),
    )


def source_notes(source: Source) -> list[Annotation]:
    """Make the notes of a source and of its waveform."""
    head = Annotation("source", SourceNote(source.name, source.node, source.quantity, source.direct))
    return [head, Annotation(_WAVEFORMS[type(source.waveform)], source.waveform)]


def to_source(source: SourceNote, waveform: Waveform) -> Source:
    """Make the source that its note and its waveform describe."""
    return Source(source.name, source.node, waveform, source.quantity, source.direct)


def to_parameters(notes: Iterable[ParameterNote]) -> dict[str, Any]:
    """Make the parameters of an instance from its notes: numbers, or nested tuples where a note has a shape.

    Raises
    ------
    DataError
        A note has too few or too many values for its shape.
    """
    return {n.key: _nested(n.values, n.shape) for n in notes}


def _die_notes(die: Die) -> list[Annotation]:
    edits = tuple((_edit_text(edit), edit.value) for edit in die.edits)
    key = DieNote(die.lot, die.number, die.corner, die.mismatch, die.process, die.variation, edits)
    if die.sampling is None or die.number is None:
        return [Annotation("die", key)]
    row = die.sampling.rows[die.number - die.sampling.first]
    draws = tuple((label, float(row[column])) for label, column in die.sampling.columns.items())
    return [Annotation("die", key), Annotation("plan", Plan(die.sampling.name, draws))]


def _edit_text(edit: Edit) -> str:
    """Kind and paths of an edit, in one text."""
    return f"{edit.kind} {';'.join(edit.paths)}{f'.{edit.parameter}' if edit.parameter else ''}"


def _to_edit(text: str, value: float) -> Edit:
    """The edit of its text and value; raises `DataError` for a kind that is none."""
    kind, _, told = text.partition(" ")
    if kind == "set":
        path, _, parameter = told.rpartition(".")
        return Edit("set", (path,), parameter, value)
    if kind not in KINDS_OF_EDIT:
        raise DataError(f"note die.edits: {kind}, must be one of {', '.join(KINDS_OF_EDIT)}")
    return Edit("heal" if kind == "heal" else "only", tuple(told.split(";")))


def _to_die(key: DieNote, plan: Plan | None) -> Die:
    edits = tuple(_to_edit(text, value) for text, value in key.edits)
    plain = Die(
        key.lot, key.number, key.corner, key.mismatch, key.process, variation=key.variation, edits=edits
    )  # fmt: skip
    if plan is None or key.number is None:
        return plain
    columns = {label: k for k, (label, _) in enumerate(plan.draws)}
    rows = np.array([[value for _, value in plan.draws]])
    return replace(plain, sampling=Sampling(plan.name, key.number, columns, rows))


def _parameter_note(circuit: Circuit, key: str, value: object) -> Annotation:
    name, _, attribute = key.rpartition(".")
    numbers = np.asarray(value, dtype=np.float64)
    base = float(circuit.device(name).parameters()[attribute])
    return Annotation("parameter", ParameterNote(key, tuple(numbers.ravel().tolist()), base, numbers.shape))


def _nested(values: tuple[float, ...], shape: Shape) -> Any:
    if not shape:
        if len(values) != 1:
            raise DataError(f"note parameter.values: {len(values)} numbers, must be one without a shape")
        return values[0]
    if min(shape) < 1 or len(values) != math.prod(shape):
        raise DataError(f"note parameter.values: {len(values)} numbers, must fill the shape {shape}")
    step = len(values) // shape[0]
    parts = [values[k : k + step] for k in range(0, len(values), step)]
    return tuple(_nested(part, shape[1:]) for part in parts)
