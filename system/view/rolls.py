"""What is inside a neuron of a ROLLS chip, for a film."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from chips.rolls.chip import Inputs, RollsChip
from chips.rolls.circuit import NAME
from chips.rolls.cut import Cut, cut_row, silicon_of, testbench
from chips.rolls.program.address import NEURONS, VIRTUAL_EXCITATORY, VIRTUAL_INHIBITORY
from chips.rolls.program.program import Program
from circuits.arrays import F64, I64
from circuits.blocks.rest import started_at_rest
from circuits.blocks.rolls import neuron as rolls_neuron
from circuits.devices.source import Waveform
from circuits.event import WIDTH, pulse
from circuits.solver.transient import simulate
from system.view.devices import devices_of
from system.view.film import Line, Neuron, Panel

STRETCH, LEAD = 0.04, 0.02
"""Of a neuron's waveform at transistor level, s, and from rest before it; ours, for they take seconds."""
_RTOL = 1e-4  # of its run; ours
_NODES = {  # of a row as a circuit, by what a page calls them
    "v_mem": "v_mem[0]", "spike": "spike[0]", "v_ref": "row[0].neuron.v_ref", "v_ahp": "row[0].neuron.v_ahp",
    "excitatory filter": "row[0].excitatory_v_syn", "inhibitory filter": "row[0].inhibitory_v_syn",
    "input filter": "row[0].virtual_excitatory_v_syn",
}  # fmt: skip
_SHOWN = ("v_mem", "spike")


@dataclass(frozen=True, slots=True)
class Heard:
    """What a chip's neurons heard in a run.

    times, neurons : spikes of all neurons, s, rising. inputs : gives the events from outside between two
    times, s, and may give more.
    """

    times: F64
    neurons: I64
    inputs: Callable[[float, float], Inputs]


def neuron_inside(chip: RollsChip, name: str, heard: Heard | None = None) -> Neuron:
    """Return a neuron with its devices on the chip's die, and its waveform where it is told what was heard.

    name: as `neuron[12]`. A row of a die with gradients, or with a plastic array, has no waveform.
    """
    at = int(name[name.index("[") + 1 : -1])
    place = ((NAME, ()), ("row", (NEURONS,)), ("neuron", ()))
    devices = devices_of(rolls_neuron.build(), chip.silicon, place, at)
    alone = chip.silicon.die.components or chip.program.plastic is not None  # a row by itself has neither
    return Neuron(
        name=name, devices=devices, waveform=None if heard is None or alone else _waveform(chip, at, heard)
    )


def _waveform(chip: RollsChip, at: int, heard: Heard) -> Panel:
    """The row of a neuron by its transistors, noiseless, about where it spikes most."""
    begin = _busiest(heard.times[heard.neurons == at])
    first = max(0.0, begin - LEAD)
    cut = cut_row(_awake(chip.program, at, heard, first, begin + STRETCH), at, chip.kind, chip.params)
    v_dd = chip.silicon.process.v_dd
    bench = testbench(cut, _events(cut, heard, first, begin + STRETCH, v_dd), begin + STRETCH - first, v_dd)
    bench = started_at_rest(bench, chip.silicon.process)
    found = simulate(bench, silicon_of(cut, chip.silicon), rtol=_RTOL)
    lines = tuple(
        Line(name=name, time=found.time + first, value=found[node], shown=name in _SHOWN)
        for name, node in _NODES.items()
        if node in found.nodes
    )
    mine = heard.times[heard.neurons == at]
    there = int(((mine >= first) & (mine < begin + STRETCH)).sum())
    here = len(found.spikes["spike[0]"])
    told = f"at transistor level, noiseless, from rest at {first:.3f} s on, driven by what it got in this run"
    return Panel(title=f"neuron[{at}] {told}: {here} spikes, {there} of the run", unit="V", lines=lines)


def _busiest(spikes: F64) -> float:
    """When the stretch begins in which a neuron spikes most, s; 0 for one that is silent."""
    if not spikes.size:
        return 0.0
    counts = np.searchsorted(spikes, spikes + STRETCH) - np.arange(spikes.size)
    return float(spikes[int(np.argmax(counts))])


def _awake(program: Program, at: int, heard: Heard, first: float, last: float) -> Program:
    """The program without synapses of a neuron from those silent meanwhile, which leak picoamperes."""
    inside = (heard.times >= first) & (heard.times < last)
    levels = np.array(program.levels)
    levels[at, np.setdiff1d(np.arange(NEURONS), heard.neurons[inside])] = 0
    return replace(program, levels=levels)


def _events(cut: Cut, heard: Heard, first: float, last: float, v_dd: float) -> Mapping[str, Waveform]:
    """Pulses at each port of a row, in its own time, which begins at `first`."""
    inside = (heard.times >= first) & (heard.times < last)
    times, neurons = heard.times[inside], heard.neurons[inside]
    given = heard.inputs(first, last)
    mine = (given.neurons == cut.neuron) & (given.times >= first) & (given.times < last)
    trains = {f"event[{j}]": times[neurons == column] for j, column in enumerate(cut.columns)}
    for sign, origin, count in (
        ("exc", VIRTUAL_EXCITATORY, cut.virtual.excitatory),
        ("inh", VIRTUAL_INHIBITORY, cut.virtual.inhibitory),
    ):
        for j in range(count):
            trains[f"virtual_{sign}_event[0,{j}]"] = given.times[mine & (given.columns == origin + j)]
    return {port: pulse(_apart(train - first), v_dd) for port, train in trains.items()}


def _apart(times: F64) -> tuple[float, ...]:
    """Times no two of which are nearer than two pulses, s: as a bus sends them, one after the other."""
    gap, order = 2.0 * WIDTH, np.sort(times)
    number = np.arange(order.size)
    return tuple((np.maximum.accumulate(order - gap * number) + gap * number).tolist())
