"""The ROLLS chip with depressed excitatory weights as a circuit: what its rows have in addition.

A row of `chips.rolls.circuit` has `depression_exc[256]`, `depression_exc0[256]` and `depression_exc1[256]`,
the cells of `circuits.blocks.rolls.depressing_synapse`, one for each of a synapse's three weight devices: the
gates of me2, me4 and me6 are nodes of the synapse, on a capacitor each, and each cell takes its own step at
every excitatory pulse. All other paths are those of the chip without, and so are their draws. Virtual and
plastic synapses have no cells (ours: the one bias that is found, NPA_WEIGHT_STD, is among those of the
non-plastic array). 196,608 capacitors of 0.2 pF would be 39 nF, more than ROLLS' 51 mm^2 has room for: the
chip's own are smaller, or fewer; with another capacitor and both currents in proportion all is the same but
the noise.
"""

from __future__ import annotations

from dataclasses import replace

from chips.rolls.depression.program import STEP_BIAS, ShortTermDepression
from chips.rolls.program.address import NEURONS
from chips.rolls.program.bias_file import BiasTable
from circuits.blocks.rolls.bias import current_of
from circuits.blocks.rolls.depressing_synapse import WEIGHTS, depression, synapse
from circuits.circuit import Bias, BiasKind, Circuit, Instance, InstanceArray, Node, Port
from circuits.errors import ParameterError

CELLS = tuple(f"depression_{name}" for name in WEIGHTS)
STD, RECOVERY = "depression_std", "depression_rec"  # bias ports of a row
_PULSE = {"exc_off": "depression_off", "exc_on": "depression_on"}


def depression_biases(
    program: ShortTermDepression, table: BiasTable, kind: BiasKind, prefix: str = ""
) -> tuple[Bias, ...]:
    """Return the biases of the cells in a row, or in the chip where `prefix` is the row's name."""
    return (
        Bias("i_std", STD, kind, table.current(STEP_BIAS), f"{prefix}{CELLS[0]}.ms1"),
        Bias("i_rec", RECOVERY, kind, current_of(program.recovery), f"{prefix}{CELLS[0]}.mr1"),
    )


def depressing_row(one: Circuit, program: ShortTermDepression, count: int) -> Circuit:
    """Return a row with `count` synapses and their cells; its biases are the caller's."""
    if not count:
        return one
    shape = (count,)
    made = synapse(program.cell)
    to_gate = {f"v_{name}": f"w_{name}" for name in WEIGHTS}
    instances: list[Instance | InstanceArray] = []
    for each in one.instances:
        if each.name != "synapse":
            instances.append(each)
            continue
        own = {port: to_gate.get(port, node) for port, node in each.connections.items()} | _PULSE
        instances.append(InstanceArray("synapse", made, shape, own))
    cell = depression(program.cell)
    for name, weight in zip(CELLS, WEIGHTS, strict=True):
        wires = {"vdd": "vdd", "level": f"v_{weight}", "w": f"w_{weight}", "v_std": STD, "v_rec": RECOVERY}
        instances.append(InstanceArray(name, cell, shape, wires | _PULSE))
    nodes = (*one.nodes, *(Node(name, shape) for name in (*_PULSE.values(), *to_gate.values())))
    ports = (*one.ports, Port(STD, "bias"), Port(RECOVERY, "bias"))
    return replace(one, ports=ports, instances=tuple(instances), nodes=nodes)


def depressing_chip(base: Circuit, program: ShortTermDepression, table: BiasTable, kind: BiasKind) -> Circuit:
    """Return a chip of `chips.rolls.circuit`, or of `chips.rolls.plastic.circuit`, with cells in its rows."""
    added = depression_biases(program, table, kind, "row.")
    instances = []
    for each in base.instances:
        if each.name != "row":
            instances.append(each)
            continue
        made = depressing_row(each.circuit, program, NEURONS)
        wires = {**each.connections, STD: STD, RECOVERY: RECOVERY}
        instances.append(replace(each, circuit=made, connections=wires))
    ports = (*base.ports, *(Port(b.port, "bias") for b in added))
    return replace(base, ports=ports, instances=tuple(instances), biases=(*base.biases, *added))


def check_cell(program: ShortTermDepression, chip_synapse: object) -> None:
    """Raise `ParameterError` where the cell was made for a synapse of other sizes than the chip's."""
    if program.cell.synapse != chip_synapse:
        raise ParameterError(
            "depression.cell.synapse: of other sizes than the chip's, must be the chip's; give it both"
        )
