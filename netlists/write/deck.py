"""The walk that writes a netlist in any dialect: the definitions first, then the testbench.

A dialect brings a `Writer`: how it opens and closes a definition, how it calls one, how it writes a device,
and what it says at the end. Notes (`netlists.write.annotation`) stand where their module says.
"""

from __future__ import annotations

import functools
import itertools
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

from circuits.circuit import Circuit
from circuits.devices import Capacitor
from circuits.devices.device import Device
from circuits.lowering.flatten import flatten
from circuits.silicon.silicon import Change, Deviation, Silicon
from circuits.solver.beginning import held_voltages
from circuits.testbench import Testbench
from netlists.naming import Naming, element
from netlists.registry import POINTS, Analysis, DeviceFormatter, Method, Settings
from netlists.write.annotation import (
    FORMAT_VERSION,
    Annotation,
    Biased,
    Header,
    Parasitic,
    bench_note,
    circuit_notes,
    device_notes,
    format_annotation,
    instance_notes,
    silicon_notes,
    source_notes,
)
from netlists.write.traversal import Call, Definition, Design, Drive, as_made, split_path, to_design

WIDTH = 100
NOT_RUN = "not run here: written to the simulator's manual, checked by reading it back"


class Control(NamedTuple):
    """What a dialect says at the end of a netlist, by its own names of nodes.

    Attributes
    ----------
    silicon, models
        Process, die and temperature; what transistors are.
    analysis, stop, step
        `tran` or `op`; stop time and largest step, s.
    reltol, method
        The simulator's relative tolerance and its integration method.
    saved
        Nodes to save.
    starts
        A guess at the rest state: nodes and their voltages, V.
    held
        Nodes that are held until time 0, and their voltages, V.
    uic
        Whether the run begins with these voltages, without a rest state.
    """

    silicon: Silicon
    models: str
    analysis: Analysis
    stop: float
    step: float
    reltol: float
    method: Method
    saved: list[str]
    starts: list[tuple[str, float]]
    held: list[tuple[str, float]]
    uic: bool


@dataclass(frozen=True, slots=True)
class Writer:
    """How a dialect writes the parts of a netlist.

    All functions return finished lines; the names that they get are the dialect's own.

    Attributes
    ----------
    dialect
        Its name.
    remark
        How far its text has been tried; empty for what is run here.
    comment
        What begins a comment.
    naming
        How names of nodes and devices are written.
    separator
        What stands between the names of a path in a run.
    open, close
        Give the first lines of a definition, and the last.
    call
        Gives the lines of a call from its name, its nodes and the definition that it calls.
    head
        Gives the lines behind the title.
    control
        Gives the lines about the run, at the end.
    top
        Calls the testbench's circuit; None calls it as any other.
    case
        Folds the case of names in a run.
    """

    dialect: str
    remark: str
    comment: str
    naming: Naming
    separator: str
    open: Callable[[str, Definition], list[str]]
    close: Callable[[str], list[str]]
    call: Callable[[str, list[str], str], list[str]]
    head: Callable[[], list[str]]
    control: Callable[[Control], list[str]]
    top: Callable[[str, list[str], str], list[str]] | None = None
    case: Callable[[str], str] = str


def no_control(control: Control) -> list[str]:
    """Nothing at the end."""
    return []


def format_deck(
    writer: Writer,
    format_device: DeviceFormatter,
    cards: Callable[[Design], list[str]],
    testbench: Testbench,
    silicon: Silicon,
    settings: Settings,
    title: str | None = None,
) -> str:
    """Complete netlist of a testbench; `cards` gives the models that its devices name."""
    design = to_design(testbench, silicon, settings.parasitics)
    top = Call(design.top.name, (), design.top.name, design.top.ports)
    walk = _Walk(writer, format_device, silicon)
    lines = [
        _format_title(writer, title or testbench.title, testbench.circuit.name, silicon),
        *writer.head(),
        *([f"{writer.comment} {writer.dialect}: {writer.remark}"] if writer.remark else []),
        *_generated(writer, testbench.circuit),
        *walk.notes([Annotation("noctule", Header(FORMAT_VERSION, writer.dialect, settings.models))]),
        *walk.notes(silicon_notes(silicon)),
        *cards(design),
        *itertools.chain.from_iterable(map(walk.definition, design.definitions)),
        *walk.notes([bench_note(testbench)]),
        *walk.call(top, writer.top or writer.call),
        *itertools.chain.from_iterable(map(walk.drive, design.drives)),
        *writer.control(_control(writer, testbench, silicon, settings, design)),
    ]
    return "\n".join(lines) + "\n"


def _generated(writer: Writer, circuit: Circuit) -> list[str]:
    """Where the voltages of the bias generator's lines come from, which is no part of the netlist."""
    names = [bias.name for bias in circuit.biases if bias.kind == "generator"]
    if not names:
        return []
    return [
        f"{writer.comment} biases {', '.join(names)}: voltages of lines of the bias generator",
        f"{writer.comment} on this die at this temperature, solved from its circuit, which is not in here",
    ]


def _format_title(writer: Writer, what: str, circuit: str, silicon: Silicon) -> str:
    """First line of a netlist; `what` is folded into one line."""
    return f"{writer.comment} {format_position(what, circuit, silicon)}"


def format_position(what: str, circuit: str, silicon: Silicon) -> str:
    """What a netlist is: its title, circuit, place, process, die and temperature in one line."""
    place = "" if silicon.place is None else " at " + "/".join(element(*part) for part in silicon.place)
    made = f"process {silicon.process.name}, {silicon.die}, temperature {silicon.temperature_c!r} degC"
    return f"{' '.join(what.split())}: circuit {circuit}{place}, {made}"


def run_name(writer: Writer, path: str, top: Definition) -> str:
    """Name by which a run of the definition `top` knows the node at `path`."""
    parts = split_path(path)
    *instances, node = (writer.naming.node(element(*part)) for part in parts)
    if not instances and any(port.name == parts[0][0] for port in top.circuit.ports):
        return writer.case(node)
    outer = (f"x{writer.naming.node(top.name)}", *(f"x{name}" for name in instances))
    return writer.case(writer.separator.join((*outer, node)))


def wrap(words: Iterable[str], width: int = WIDTH) -> list[str]:
    """One card of `words` in lines of about `width` characters, continued by `+`."""
    lines, line = [], ""
    for word in words:
        if line and len(line) + len(word) >= width:
            lines.append(line)
            line = "+"
        line = f"{line} {word}" if line else word
    return [*lines, line]


@dataclass(frozen=True, slots=True)
class _Walk:
    """One netlist on its way; equal circuits and devices are annotated once and copied."""

    writer: Writer
    format_device: DeviceFormatter
    silicon: Silicon
    circuits: dict[int, tuple[list[str], list[list[str]]]] = field(default_factory=dict)
    devices: dict[Device, list[str]] = field(default_factory=dict)

    def notes(self, notes: Iterable[Annotation]) -> list[str]:
        return [line for note in notes for line in format_annotation(note, self.writer.comment)]

    def definition(self, definition: Definition) -> list[str]:
        name = self.writer.naming.node(definition.name)
        own, of_instances = self._circuit(definition.circuit)
        lines = [*self.writer.open(name, definition), *own]
        for device, deviation in definition.devices:
            lines += self._device(device, deviation)
            made, local = as_made(device, deviation)
            lines += self.format_device(made, self.silicon, local)
        for device in definition.parasitics:
            lines += self.notes([Annotation("parasitic", Parasitic(device.name))])
            lines += self.format_device(device, self.silicon)
        for notes, calls in zip(of_instances, definition.calls, strict=True):
            lines += notes
            for call in calls:
                lines += self.call(call, self.writer.call)
        return [*lines, *self.writer.close(name)]

    def call(self, call: Call, write: Callable[[str, list[str], str], list[str]]) -> list[str]:
        node = self.writer.naming.node
        return write(
            "x" + node(element(call.name, call.index)), [node(n) for n in call.nodes], node(call.definition)
        )

    def drive(self, drive: Drive) -> list[str]:
        own = (
            [Annotation("biased", Biased(drive.source.node))] if drive.biased else source_notes(drive.source)
        )
        return [
            *self.notes(own),
            *(line for each in drive.elements for line in self.format_device(each, self.silicon)),
        ]

    def _circuit(self, circuit: Circuit) -> tuple[list[str], list[list[str]]]:
        if id(circuit) not in self.circuits:
            inner = [self.notes(instance_notes(i)) for i in circuit.instances]
            self.circuits[id(circuit)] = (self.notes(circuit_notes(circuit)), inner)
        return self.circuits[id(circuit)]

    def _device(self, device: Device, deviation: Deviation | Change) -> list[str]:
        notes = device_notes(device, deviation)
        if notes and device not in self.devices:
            self.devices[device] = self.notes(notes[-1:])
        return [*self.notes(notes[:-1]), *self.devices[device]] if notes else []


def _control(
    writer: Writer, testbench: Testbench, silicon: Silicon, settings: Settings, design: Design
) -> Control:
    name = functools.partial(run_name, writer, top=design.top)
    uic = testbench.begin == "uic"  # without a rest state a guess at it has nothing to say
    return Control(
        silicon,
        settings.models,
        settings.analysis,
        testbench.stop,
        testbench.stop / POINTS if settings.tmax is None else settings.tmax,
        settings.reltol,
        settings.method,
        [name(path) for path in (design.nodes if settings.nodes is None else settings.nodes)],
        [] if uic else [(name(path), float(v)) for path, v in sorted(testbench.start.items())],
        [(name(path), float(v)) for path, v in sorted(held_at_start(testbench, silicon).items())],
        uic,
    )


def held_at_start(testbench: Testbench, silicon: Silicon) -> Mapping[str, float]:
    """Voltages (V) by node path that a simulator has to hold at time 0, those of capacitors among them.

    With `uic` these are the testbench's own alone: a capacitor's stands in its line.
    """
    if testbench.begin == "uic" or not (testbench.initial or _has_charged(testbench.circuit)):
        return testbench.initial
    return held_voltages(testbench, flatten(testbench.circuit), silicon)


def _has_charged(circuit: Circuit) -> bool:
    """Whether a capacitor of the circuit, or of one inside it, has an initial voltage."""
    own = any(isinstance(d, Capacitor) and d.ic is not None for d in circuit.devices)
    return own or any(map(_has_charged, {id(i.circuit): i.circuit for i in circuit.instances}.values()))
