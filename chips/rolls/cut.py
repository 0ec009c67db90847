"""One row of a ROLLS chip as a circuit with the synapses that its program latches: that die's very row.

The chip's circuit (`chips.rolls.circuit`) with one row, and of its 256 synapses and columns those that are
latched: three million devices become some hundreds. Element 0 of `row` stands for the chosen neuron, element
j of `synapse` and `extender` for the j-th latched column, so that the draws of a die are those of the row's
own places (`silicon_of`). With short-term depression the cells of a latched synapse come with it, whatever
its sign. Left out are synapses that are not latched, which leak picoamperes, and virtual
synapses that no input uses.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from chips.rolls.circuit import NAME, SUPPLY, Params, chip, row
from chips.rolls.depression.circuit import CELLS, check_cell, depressing_chip, depressing_row
from chips.rolls.program.address import LAB_VIRTUAL, NEURONS, VirtualSynapses
from chips.rolls.program.program import Program, check_unlearned
from circuits.blocks.rolls import dpi_synapse
from circuits.circuit import Bias, BiasKind, Circuit, Instance, InstanceArray, Node, Port
from circuits.devices import Source, Transistor
from circuits.devices.source import Constant, Waveform
from circuits.errors import ParameterError
from circuits.lowering.flatten import flatten
from circuits.silicon.die import PARAMETERS, Die, Place, standard_normals
from circuits.silicon.edit import Edit, edited
from circuits.silicon.sampling import Sampling, labels
from circuits.silicon.silicon import Silicon
from circuits.testbench import Testbench

OWN = ("row", "synapse", "extender", *CELLS)  # arrays of which only some elements are kept


@dataclass(frozen=True, slots=True)
class Cut:
    """A row as a circuit: its neuron, its latched columns in rising order, and their levels.

    slow: whether its leak is IF_TAU1; virtual: how many virtual synapses of either sign it has.
    """

    circuit: Circuit
    neuron: int
    columns: tuple[int, ...]
    levels: tuple[int, ...]
    slow: bool
    virtual: VirtualSynapses


def cut_row(program: Program, neuron: int, kind: BiasKind = "gate", params: Params | None = None) -> Cut:
    """Return the row of a neuron of a program's chip as a circuit.

    A row without a latched synapse and without an input is its neuron with silent filters. Raises
    `ParameterError` for a neuron that the chip does not have, and for a program with a plastic array.
    """
    check_unlearned(program, "a row as a circuit")
    if not 0 <= neuron < NEURONS:
        raise ParameterError(f"row[{neuron}]: must be 0 to {NEURONS - 1}; the chip has {NEURONS} neurons")
    used = _virtual(program, neuron)
    params = replace(Params() if params is None else params, virtual=used)
    columns = np.flatnonzero(program.levels[neuron])
    one = _row_of(row(params, program.biases, kind), columns.size)
    whole = chip(replace(params, virtual=LAB_VIRTUAL), program.biases, kind)
    if program.depression is not None:
        check_cell(program.depression, params.synapse)
        one = depressing_row(one, program.depression, columns.size)
        whole = depressing_chip(whole, program.depression, program.biases, kind)
    shape = (columns.size,)
    instances: list[Instance | InstanceArray] = [InstanceArray("row", one, (1,), one.wired())]
    biases = _biases(one, whole, columns.size)
    ports = [replace(p, shape=(1, *p.shape)) for p in one.ports if _is_own(p)]
    ports += [SUPPLY, *(Port(b.port, "bias") for b in biases)]
    if columns.size:
        wires = {"vdd": "vdd", "event": "event", "pulse": "pulse", "v_pwlk": "v_pwlk"}
        extender = dpi_synapse.pulse_extender(params.synapse)
        instances.append(InstanceArray("extender", extender, shape, wires))
        ports.append(Port("event", "event", "in", shape))
    nodes = (Node("pulse", shape),) if columns.size else ()
    circuit = Circuit(NAME, tuple(ports), (), tuple(instances), nodes, biases)
    levels = tuple(int(program.levels[neuron, c]) for c in columns)
    return Cut(circuit, neuron, tuple(int(c) for c in columns), levels, neuron in program.tau1, used)


def silicon_of(cut: Cut, silicon: Silicon) -> Silicon:
    """Return the silicon on which every device of the cut has the deviations of its own place on the chip.

    Raises `ParameterError` for a die with components of variation beside the plain ones.
    """
    die = silicon.die
    if not die.deviates:
        return silicon
    if die.components:
        raise ParameterError(
            f"row[{cut.neuron}]: {die}, a row by itself has no gradients of its place on the chip; leave the"
            " variation plain"
        )
    names: dict[str, int] = {}
    values: list[float] = []
    sets: list[Edit] = []
    place: Place = ((NAME, ()),)
    for group in flatten(cut.circuit).groups:
        if not isinstance(group.device, Transistor):
            continue
        own = ((group.device.name, ()),)
        shape = tuple(n for _, dimensions in group.path for n in dimensions)
        there = [_place(cut, group.path, index) for index in np.ndindex(shape)]
        for parameter in PARAMETERS:
            here = labels(place, [(*group.path, *own)], parameter)
            for label, at in zip(here, there, strict=True):
                names[label] = len(names)
                values.append(0.0 if die.number is None else _draw(die, at, own, parameter))
                changed = edited(die.edits, at, (own,), parameter)
                if changed is not None and not np.isnan(changed.value[0]):
                    path = label.removesuffix(f".{parameter}")
                    sets.append(Edit("set", (path,), parameter, float(changed.value[0])))
    # what single devices have of the die's edits is in the plan already
    edits = (*die.shared_edits, *sets)
    if die.number is None:
        return replace(silicon, die=replace(die, edits=edits))
    plan = Sampling(f"row[{cut.neuron}]", die.number, names, np.array(values)[None, :])
    return replace(silicon, die=replace(die, sampling=plan, edits=edits))


def _draw(die: Die, place: Place, own: Place, parameter: str) -> float:
    """Standard normal of a device at its place on the whole chip."""
    return float(standard_normals(die, place, [own], parameter)[0])


def testbench(cut: Cut, events: Mapping[str, Waveform], stop: float, v_dd: float) -> Testbench:
    """Return the testbench of a row with its latches set; its spikes are those of `spike[0]`.

    events: waveforms by port, as `event[0]` or `virtual_exc_event[0,1]`; ports without one are at ground.
    stop: s; v_dd: supply, V.
    """
    known = {
        name for p in cut.circuit.ports if p.kind == "event" and p.direction == "in" for name in p.elements()
    }
    sources = [
        Source("vdd", "vdd", Constant(v_dd)),
        Source("select", "select[0]", Constant(v_dd if cut.slow else 0.0)),
        *(Source(name, name, events.get(name, Constant(0.0))) for name in sorted(known)),
    ]
    for j, level in enumerate(cut.levels):
        for name, voltage in dpi_synapse.latches(level, v_dd).items():
            sources.append(Source(f"{name}[0,{j}]", f"{name}[0,{j}]", Constant(voltage)))
    return Testbench(f"ROLLS row {cut.neuron}", cut.circuit, tuple(sources), stop, watch=("spike",))


def _virtual(program: Program, neuron: int) -> VirtualSynapses:
    """Virtual synapses of the neuron that the program's inputs use, in the order of their columns."""
    used = {False: 0, True: 0}
    for each in program.inputs:
        if neuron in each.neurons:
            used[each.inhibitory] += each.synapses
    return VirtualSynapses(used[False], used[True])


def _row_of(one: Circuit, count: int) -> Circuit:
    """The row with its first `count` synapses, without its biases, which are the chip's."""
    instances = tuple(_shortened(i, count) for i in one.instances if count or i.name != "synapse")
    used = {node for i in instances for node in i.connections.values()}
    sized = {"pulse", *dpi_synapse.LATCHES}
    ports = (replace(p, shape=(count,)) if p.name in sized else p for p in one.ports if p.name in used)
    return replace(one, ports=tuple(ports), instances=instances, biases=())


def _shortened(instance: Instance | InstanceArray, count: int) -> Instance | InstanceArray:
    if instance.name == "synapse" and isinstance(instance, InstanceArray):
        return replace(instance, shape=(count,))
    return instance


def _is_own(port: Port) -> bool:
    """Whether a row's port is each row's: neither shared, nor the pulses that its columns make."""
    return port.name != "pulse" and (
        bool(port.shape) or port.kind not in ("bias", "supply") or port.name == "select"
    )


def _biases(one: Circuit, whole: Circuit, columns: int) -> tuple[Bias, ...]:
    """Biases of the chip that the row, or an extender, has a port for."""
    ports = {p.name for p in one.ports} | ({"v_pwlk"} if columns else set())
    found = [b for b in whole.biases if b.port in ports]
    if not columns:
        # the device whose gate the pulses' bias is made for is one of the virtual synapses' then
        extenders = [i.name for i in one.instances if i.name.endswith("_extender")]
        found = [replace(b, device=f"row.{extenders[0]}.mp2") if b.port == "v_pwlk" else b for b in found]
    return tuple(found)


def _place(cut: Cut, path: Place, index: tuple[int, ...]) -> Place:
    """Where the element `index` of a path of the cut stands on the whole chip."""
    found: list[tuple[str, tuple[int, ...]]] = [(NAME, ())]
    rest = index
    for name, dimensions in path:
        own, rest = rest[: len(dimensions)], rest[len(dimensions) :]
        if name == "row":
            own = (cut.neuron,)
        elif name in OWN and own:
            own = (cut.columns[own[0]],)
        found.append((name, own))
    return tuple(found)
