"""The ROLLS chip with its plastic array as a circuit: what its rows and columns have in addition.

A row of `chips.rolls.circuit` has more:

* `plastic_synapse[256]`, one a presynaptic neuron, on the line of the filter `plastic`;
* `learning`: the neuron's learning circuit, which makes the row's two lines from its calcium and its
  membrane, and `learning_extender`, which makes its spikes longer;

and the chip `plastic_extender[256]`, one a column. That a column shares its extender is ours, as for the
non-plastic synapses. All other paths are those of the chip without the array, and so are their draws.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from chips.rolls.circuit import Params, chip
from chips.rolls.plastic.biases import CELL_BIASES, GATE_BIASES, MEMBRANE, PULSE
from chips.rolls.program.address import NEURONS
from chips.rolls.program.bias_file import BiasTable, default_biases
from circuits.blocks.rolls import calcium_gate, plastic_synapse
from circuits.blocks.rolls.dpi_synapse import pulse_extender
from circuits.circuit import Bias, BiasKind, Circuit, Instance, InstanceArray, Node, Port
from circuits.errors import ParameterError

CELL, GATE, GATE_EXTENDER, EXTENDER = "plastic_synapse", "learning", "learning_extender", "plastic_extender"
_PARTS = (
    (CELL, plastic_synapse.BIASES, CELL_BIASES, "cell."),
    (GATE, calcium_gate.BIASES, GATE_BIASES, "gate."),
)


@dataclass(frozen=True, slots=True)
class Learning:
    """Sizes of the plastic array's circuits, and the threshold of its weights (V); all are ours."""

    cell: plastic_synapse.Params = field(default_factory=plastic_synapse.Params)
    gate: calcium_gate.Params = field(default_factory=calcium_gate.Params)
    weight_threshold: float = plastic_synapse.THRESHOLD  # V, of w

    def __post_init__(self) -> None:
        if not 0.0 < self.weight_threshold < 1.8:
            raise ParameterError(
                f"learning.weight_threshold: {self.weight_threshold:g} V, must be within 0 to 1.8 V"
            )


def plastic_ports(part: str) -> dict[str, str]:
    """Return the port of a row for each bias port of a part of it: CELL, GATE or an extender."""
    if part in (EXTENDER, GATE_EXTENDER):
        return {"v_pwlk": f"{CELL}_pwlk"}
    names = next(names for name, _, names, _ in _PARTS if name == part)
    own = {f"v_{name[2:]}": f"{part}_{name[2:]}" for name in names} | {"v_shift": "synapse_shift"}
    return own | ({"v_wthr": f"{CELL}_wthr"} if part == CELL else {"v_memthr": f"{GATE}_memthr"})


def biases(learning: Learning, table: BiasTable, kind: BiasKind) -> tuple[Bias, ...]:
    """Return the biases of the chip's plastic array, with the codes of `table`."""
    found = []
    for part, blocks, names, inner in _PARTS:
        for bias in blocks:
            if bias.name in names:
                where = f"row.{part}.{(bias.device or '').removeprefix(inner)}"
                value, port = table.current(names[bias.name]), f"{part}_{bias.name[2:]}"
                found.append(Bias(f"i_{port}", port, kind, value, where))
    for port, code, device in (
        (f"{CELL}_pwlk", PULSE, f"{EXTENDER}.mp2"), (f"{GATE}_memthr", MEMBRANE, f"row.{GATE}.mm3"),
    ):  # fmt: skip
        found.append(Bias(f"i_{port}", port, kind, table.current(code), device))
    found.append(Bias(f"v_{CELL}_wthr", f"{CELL}_wthr", "voltage", learning.weight_threshold))
    return tuple(found)


def plastic_chip(
    params: Params,
    learning: Learning,
    table: BiasTable | None = None,
    kind: BiasKind = "gate",
) -> Circuit:
    """Build the whole chip with its plastic array; a column's plastic events come at `plastic_event[256]`."""
    codes = default_biases() if table is None else table
    added = biases(learning, codes, kind)
    base = chip(params, codes, kind)
    ports = (*(Port(b.port, "bias") for b in added),)
    instances = tuple(_with_array(i, learning, ports) if i.name == "row" else i for i in base.instances)
    shape = (NEURONS,)
    extender = InstanceArray(
        EXTENDER, pulse_extender(learning.cell.synapse), shape,
        {"vdd": "vdd", "event": "plastic_event", "pulse": "plastic_pulse"} | plastic_ports(EXTENDER),
    )  # fmt: skip
    return replace(
        base,
        ports=(*base.ports, *ports, Port("plastic_event", "event", "in", shape)),
        instances=(*instances, extender),
        nodes=(*base.nodes, Node("plastic_pulse", shape)),
        biases=(*base.biases, *added),
    )


def _with_array(rows: Instance | InstanceArray, learning: Learning, ports: tuple[Port, ...]) -> InstanceArray:
    """The rows of a chip, each with its plastic synapses and learning circuit."""
    if not isinstance(rows, InstanceArray):
        raise TypeError(rows.name)
    one, shape = rows.circuit, (NEURONS,)
    nodes = (Node("plastic_w", shape), Node("plastic_low", shape))
    made = replace(
        one,
        ports=(*one.ports, Port("plastic_pulse", "analog", "in", shape), *ports),
        instances=(*one.instances, *_parts(learning)),
        nodes=(*one.nodes, *nodes),
    )
    wires = {p.name: p.name for p in (Port("plastic_pulse", "analog"), *ports)}
    return replace(rows, circuit=made, connections={**rows.connections, **wires})


def _parts(learning: Learning) -> tuple[Instance | InstanceArray, ...]:
    cell, gate = plastic_synapse.cell(learning.cell), calcium_gate.gate(learning.gate)
    extender = pulse_extender(learning.gate.synapse)
    lines = {"vdd": "vdd", "up_b": "up_b", "dn": "dn"}
    return (
        InstanceArray(
            CELL, cell, (NEURONS,),
            lines | plastic_ports(CELL)
            | {"pulse": "plastic_pulse", "line": "pexc", "w": "plastic_w", "low": "plastic_low"},
        ),
        Instance(
            GATE_EXTENDER, extender,
            {"vdd": "vdd", "event": "spike", "pulse": "calcium_pulse"} | plastic_ports(GATE_EXTENDER),
        ),
        Instance(GATE, gate, lines | plastic_ports(GATE) | {"pulse": "calcium_pulse", "v_mem": "v_mem"}),
    )  # fmt: skip
