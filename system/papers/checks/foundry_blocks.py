"""Every block on a foundry's cards, gf180mcu: what it does there, beside what it does on its own process.

No paper has it. `paper` is the block on its own process by our law, ours the block on the foundry's cards in
ngspice, nominal, at 27 degC and 3.3 V, under the same stimuli of its testbench. Its currents are the same;
where they are biases, gates stand at the foundry's voltages for them (`netlists.foundry.deck`), and one below
`FLOOR` is raised to it, since the foundry's devices leak up to that at a gate of 0 V. Sizes stay but where
the foundry's extraction does not reach: lengths are kept from 0.4 to 50 um, and widths from 0.5 to 90 um with
wider ones as equal parts (ours). The row of a block says its class of outcome, the next one its first number;
a block that cannot be put there has the reason in its row. What a block does is shown; judged is how many
run.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from matplotlib.figure import Figure

from circuits.circuit import Circuit, Instance, InstanceArray
from circuits.devices import Transistor
from circuits.devices.device import Device
from circuits.errors import CircuitError
from circuits.registry import block_names
from circuits.silicon.size import SizeTerms
from circuits.solver.transient import Result
from circuits.solver.transient import simulate as native
from netlists.foundry.deck import format_foundry, map_circuit
from netlists.foundry.engine import RELTOL
from netlists.foundry.process import read_foundry
from netlists.ngspice.engine import simulate_deck
from netlists.registry import Settings
from system.experiment import Experiment, Progress, Report
from system.options.block import Choice, choose
from system.options.silicon import SiliconChoice
from system.plot import COLOURS, sized_axes
from system.rule import at_least, unjudged
from system.statement import Statement

PROCESS = "gf180mcu"
FLOOR = 0.1e-12  # A; ours
DEADLINE = 300.0  # s, of one block in ngspice


@dataclass(frozen=True, slots=True)
class There:
    """A block on the cards.

    name : name of the block in the registry.
    home, cards : its class of outcome on its own process, and on the cards; empty where it cannot run.
    number : name of its first number; empty without one.
    values : that number on either, NaN where it has none.
    changed : whether sizes had to move.
    reason : why it cannot run, empty where it does.
    """

    name: str
    home: str
    cards: str = ""
    number: str = ""
    values: tuple[float, float] = (math.nan, math.nan)
    changed: bool = False
    reason: str = ""


def reproduce(progress: Progress, names: Sequence[str] = ()) -> Report:
    """Run every block on its own process and on the cards.

    Parameters
    ----------
    progress
        Is told the share that is done.
    names
        Blocks; all unless given.
    """
    found = []
    chosen = tuple(names) or tuple(block_names())
    for k, name in enumerate(chosen):
        found.append(put_there(name))
        progress((k + 1) / len(chosen))
    rows = [row for each in found for row in _rows(each)]
    ran = sum(1.0 for each in found if not each.reason)
    same = sum(1.0 for each in found if each.cards == each.home)
    rows.append(Statement("blocks_that_run", float(len(found)), ran, at_least(0.9 * len(found))))
    rows.append(Statement("blocks_of_the_same_class", float(len(found)), same, unjudged("shown")))
    return Report(tuple(rows), lambda figure: draw(found, figure))


def put_there(name: str) -> There:
    """Run one block, the block of that `name`, on its own process and on the cards."""
    home = choose(name)
    at_home = native(home.testbench(), home.silicon)
    there = There(name, home.block.outcome(at_home))
    try:
        choice, result, changed = _on_cards(name, bool(home.circuit.biases))
    except CircuitError as error:
        return replace(there, reason=str(error).partition(";")[0])
    measured = choice.block.measured(result)
    number = next((key for key, value in measured.items() if value is not None), "")
    values = (home.block.measured(at_home).get(number), measured.get(number))
    both = tuple(math.nan if value is None else float(value) for value in values)
    return replace(
        there, cards=choice.block.outcome(result), number=number, values=(both[0], both[1]), changed=changed
    )


def _on_cards(name: str, biased: bool) -> tuple[Choice, Result, bool]:  # noqa: FBT001 - whether there are biases
    """The block on the cards with its run there, and whether its sizes had to move."""
    choice = choose(name, bias_kind="gate" if biased else None, silicon=SiliconChoice(process=PROCESS))
    size = choice.silicon.process.n.size
    mapping = read_foundry(PROCESS)
    fitting = choice.circuit if size is None else within(choice.circuit, size)
    circuit = map_circuit(_with_floor(fitting), mapping, choice.silicon)
    bench = choice.block.testbench(circuit, choice.stimuli, mapping.v_dd)
    settings = Settings(reltol=RELTOL)
    result = simulate_deck(
        bench, choice.silicon, lambda b: format_foundry(b, mapping, choice.silicon, settings), DEADLINE
    )
    return choice, result, fitting != choice.circuit


def within(circuit: Circuit, size: SizeTerms) -> Circuit:
    """The circuit whose transistors have sizes that an extraction reaches, wide ones in equal parts.

    Parameters
    ----------
    circuit
        The circuit, whose instances are gone through too.
    size
        Says which widths and lengths are reached, m.
    """
    devices = tuple(_device_within(device, size) for device in circuit.devices)
    instances = tuple(_instance_within(each, size) for each in circuit.instances)
    return replace(circuit, devices=devices, instances=instances)


def _device_within(device: Device, size: SizeTerms) -> Device:
    if not isinstance(device, Transistor):
        return device
    parts = max(1, math.ceil(device.width / size.most_width - 1e-9))
    width = max(device.width / parts, size.least_width)
    length = min(max(device.length, size.least_length), size.most_length)
    return replace(device, width=width, length=length, multiplicity=device.multiplicity * parts)


def _instance_within(each: Instance | InstanceArray, size: SizeTerms) -> Instance | InstanceArray:
    limits = {
        "width": (size.least_width, size.most_width), "length": (size.least_length, size.most_length)
    }  # fmt: skip
    given = dict(each.parameters)
    for key, value in given.items():
        path, _, attribute = key.rpartition(".")
        if attribute in limits and isinstance(each.circuit.device(path), Transistor):
            moved = np.clip(np.asarray(value, dtype=np.float64), *limits[attribute])
            given[key] = moved if moved.ndim else float(moved)
    inner = within(each.circuit, size)
    if isinstance(each, InstanceArray):
        return replace(each, circuit=inner, parameters=given)
    numbers = {key: float(np.asarray(value, dtype=np.float64)) for key, value in given.items()}
    return replace(each, circuit=inner, parameters=numbers)


def _with_floor(circuit: Circuit) -> Circuit:
    """The circuit whose currents are the floor at least."""
    biases = []
    for bias in circuit.biases:
        value = np.asarray(bias.value, dtype=np.float64)
        kept = np.maximum(value, FLOOR) if bias.kind == "gate" else value
        biases.append(replace(bias, value=tuple(kept.tolist()) if kept.ndim else float(kept)))
    return replace(circuit, biases=tuple(biases))


def _rows(each: There) -> Iterator[Statement]:
    key = each.name.replace("-", "_")
    moved = "sizes moved into the foundry's range" if each.changed else "its own sizes"
    yield Statement(f"{key}_outcome", each.home, each.cards or "not run", unjudged(each.reason or moved))
    if each.number:
        home, cards = (None if math.isnan(value) else value for value in each.values)
        yield Statement(f"{key}_{each.number}", home, cards, unjudged("shown"))


def draw(found: Sequence[There], figure: Figure) -> None:
    """Fill `figure` with the ratio of each block's first number on the cards to that on its own process.

    Parameters
    ----------
    found
        What came of each block; those without a number on either process are not drawn.
    figure
        The figure, empty.
    """
    shown = [f for f in found if f.values[0] > 0.0 and f.values[1] > 0.0]
    ax = sized_axes(figure, 8.0, 1.2 + 0.22 * len(shown))
    for k, each in enumerate(shown):
        colour = COLOURS[0] if each.cards == each.home else COLOURS[1]
        ax.plot(each.values[1] / each.values[0], k, "o", color=colour)
    ax.axvline(1.0, color="0.7", linewidth=0.8)
    ax.set_yticks(range(len(shown)), [f"{each.name}: {each.number}" for each in shown], fontsize=7)
    ax.set_xscale("log")
    ax.set_xlabel(f"on {PROCESS}'s cards in ngspice / on its own process; the second colour: another class")


EXPERIMENT = Experiment(
    "foundry-blocks", "every block on a foundry's cards, its class and its first number", reproduce
)
