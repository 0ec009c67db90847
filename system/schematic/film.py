"""A transient of a circuit as a film: its schematic, all voltages and currents, spikes, and every device."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace

from circuits.arrays import F64
from circuits.devices import Capacitor, Source
from circuits.lowering.kernel import Machine
from circuits.measure.branch import voltage_nodes
from circuits.measure.scope import device_currents
from circuits.solver.transient import Result
from system.schematic.drawing import drawing_of
from system.view.devices import devices_in
from system.view.film import Device, Film, Line, Neuron, Panel, Raster, merged

MOST = 4_000_000
"""Numbers of a page's waveforms; of a circuit that has more, those alone that its schematic names. Ours."""
SHOWN = 5
"""Waveforms of a panel that are drawn before a reader asks for others; ours."""


def film_of(result: Result, shown: Sequence[str] = (), sources: Sequence[Source] = ()) -> Film:
    """Return the film of a transient.

    Parameters
    ----------
    result
        The run, which recorded every node.
    shown
        Nodes whose waveforms are drawn first; the watched ones unless given.
    sources
        Sources of the testbench that stand in the schematic.

    Raises
    ------
    ParameterError
        The run did not record every node, or the circuit has no device.
    """
    drawing = drawing_of(result.machine.flat.circuit, sources)
    first = tuple(shown) or tuple(result.spikes)
    currents, devices = device_currents(result), devices_in(result.machine)
    voltages = voltage_nodes(result.machine)
    volts = {n: result.voltage[:, k] for k, n in enumerate(result.nodes) if n in voltages}
    facts = {}
    total = len(volts) + len(currents)
    if total * result.time.size > MOST:
        nets, drawn = ({getattr(piece, of) for piece in drawing.strokes} for of in ("net", "device"))
        volts, currents = _named(volts, {*nets, *first}), _named(currents, drawn)
        facts = {"waveforms": f"{len(volts) + len(currents)} of {total}: those that the schematic names"}
    lines = (
        _lines(result.time, volts, first or tuple(volts)),
        _lines(result.time, currents, _touching(result.machine, first)),
    )
    raster = Panel(title="spikes", raster=_spikes(result))
    return Film(
        title="",
        headline="",
        duration=float(result.time[-1]),
        drawing=drawing,
        panels=(
            *([raster] if result.spikes else []),
            Panel(title="node voltages", unit="V", lines=lines[0]),
            Panel(title="currents", unit="A", lines=lines[1]),
        ),
        neurons=tuple(_device(line, devices[line.name]) for line in lines[1] if line.name in devices),
        facts=facts,
    )


def _named(values: Mapping[str, F64], names: Collection[str]) -> dict[str, F64]:
    return {name: value for name, value in values.items() if name in names}


def _touching(machine: Machine, nodes: Sequence[str]) -> list[str]:
    """Devices but capacitors that touch the first of some nodes that no source drives."""
    driven = {source.node for source in machine.testbench.sources}
    free = [machine.flat.node(node) for node in nodes if node not in driven][:1]
    return [
        group.label(k)
        for group in machine.flat.groups
        if not isinstance(group.device, Capacitor)
        for k in range(group.nodes.shape[1])
        if any(n in group.nodes[:, k] for n in free)
    ]


def _lines(time: F64, values: Mapping[str, F64], shown: Sequence[str]) -> tuple[Line, ...]:
    first = [name for name in shown if name in values][:SHOWN]
    return tuple(
        Line(name=name, time=time, value=value, shown=name in first) for name, value in values.items()
    )


def _spikes(result: Result) -> Raster:
    time, row = merged(list(result.spikes.values()))
    return Raster(time=time, row=row, rows=tuple(result.spikes))


def _device(line: Line, device: Device) -> Neuron:
    """A device with its current."""
    panel = Panel(title=f"current of {device.path}", unit="A", lines=(replace(line, shown=True),))
    return Neuron(name=device.path, devices=(device,), waveform=panel)
