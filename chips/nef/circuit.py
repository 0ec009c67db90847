"""The NEF chip as a circuit: neurons, columns of encoder stages, filters with their lines.

* `neuron[8192]`: its membrane takes the currents of the neuron's stages;
* `column[64]`: a column is `stage[8192]`, one a neuron; in column 0 a fixed current stands in the signal's
  place, which is the neurons' bias;
* `filter[512]`, each with its converter's middle, and `line[512]`, which adds up filters of one signal.

Which line drives a column of which neurons, and which filters a line adds up, are switches that have no
circuit here: stages and filters whose connections are open have nodes of their own. Sizes of the arrays are
ours.
"""

from __future__ import annotations

from dataclasses import replace

from chips.registry import Chip
from circuits.blocks.nef import encoder as nef_encoder
from circuits.blocks.nef import neuron as nef_neuron
from circuits.blocks.nef import synapse as nef_synapse
from circuits.circuit import Bias, Circuit, InstanceArray, Node, Port

NAME = "nef_chip"
NEURONS, COLUMNS, FILTERS = 8192, 64, 512
SUPPLY = Port("vdd", "supply")
LINE_PORTS = ("v_ref", "v_split", "v_cas_n", "v_cas_p")


def converter_filter() -> Circuit:
    """Return a low-pass with the middle of its converter and its biases; its ports are i_in, i_sum, v_syn."""
    whole = nef_synapse.build()
    filter_ = next(i for i in whole.instances if i.name == "filter")
    connections = dict(filter_.connections)
    connections["i_out"] = "i_sum"
    return replace(
        whole,
        name="nef_filter",
        ports=(
            *(p for p in whole.ports if p.name not in ("v_pos", "v_neg", *LINE_PORTS)),
            Port("v_syn", "analog", "out"),
            Port("i_sum", "analog", "out"),
        ),
        instances=(replace(filter_, connections=connections),),
        biases=tuple(b for b in whole.biases if b.port not in LINE_PORTS),
    )


def neurons(count: int) -> Circuit:
    """Return the chip with its first `count` neurons alone."""
    part = nef_neuron.build()
    ports = (SUPPLY, *(Port(b.port, "bias") for b in part.biases))
    nodes = (Node("v_mem", (count,)), Node("spike", (count,)))
    biases = tuple(replace(b, device=f"neuron.{b.device}" if b.device else None) for b in part.biases)
    array = InstanceArray("neuron", part, (count,), part.wired())
    return Circuit(NAME, ports, (), (array,), nodes, biases=biases)


def column(count: int) -> Circuit:
    """Return a column with its first `count` stages alone.

    The bits and signs of each are nodes of its own.
    """
    part = nef_encoder.build()
    shared = ("v_pos", "v_neg")
    own = [p.name for p in part.ports if p.name not in ("vdd", *shared)]
    ports = (SUPPLY, *(Port(name, "bias") for name in shared))
    nodes = tuple(Node(name, (count,)) for name in own)
    biases = tuple(
        replace(b, device=f"stage.{b.device}") for b in part.biases if b.name == "i_pos" and b.device
    )
    array = InstanceArray("stage", part, (count,), part.wired())
    return Circuit("nef_column", ports, (), (array,), nodes, biases=biases)


def filters(count: int) -> Circuit:
    """Return the chip with its first `count` filters alone; i_tau and i_mid are each filter's own."""
    part = converter_filter()
    own = [p.name for p in part.ports if p.name not in ("vdd", "v_mid", "v_tau", "v_thr")]
    ports = (SUPPLY, *(Port(b.port, "bias") for b in part.biases))
    nodes = tuple(Node(name, (count,)) for name in own)
    biases = tuple(replace(b, device=f"filter.{b.device}") for b in part.biases)
    array = InstanceArray("filter", part, (count,), part.wired())
    return Circuit(NAME, ports, (), (array,), nodes, biases=biases)


def lines(count: int) -> Circuit:
    """Return the chip with its first `count` lines alone."""
    part = nef_synapse.line()
    nodes = tuple(Node(name, (count,)) for name in ("i_sum", "v_pos", "v_neg"))
    array = InstanceArray("line", part, (count,), part.wired())
    ports = (SUPPLY, *(Port(name, "bias") for name in LINE_PORTS))
    biases = tuple(
        replace(b, device=f"line.{b.device.removeprefix('line.')}" if b.device else None)
        for b in nef_synapse.BIASES
        if b.port in LINE_PORTS
    )
    return Circuit(NAME, ports, (), (array,), nodes, biases=biases)


def chain(count: int) -> Circuit:
    """Return a neuron with `count` filters, lines and stages, of as many columns, and nothing else.

    All voltages of biases are ports, and the bits and signs of the stages, their gates and the inputs of the
    filters are arrays of ports. A column whose gates are held is one of biases.
    """
    parts = {
        "filter": replace(converter_filter(), biases=()),
        "line": nef_synapse.line(),
        "column": _one_stage(),
        "neuron": replace(nef_neuron.build(), biases=()),
    }
    own = {"filter": ("i_in",), "column": tuple(b.port for b in nef_encoder.BIASES if b.kind == "voltage")}
    inside, gates = ("i_sum", "v_syn", "v_mem", "spike", "i_out"), ("v_pos", "v_neg")
    ports = {p.name: p for part in parts.values() for p in part.ports if p.name not in (*inside, *gates)}
    arrays = [name for names in own.values() for name in names]
    outer = tuple(replace(p, shape=(count,)) if p.name in arrays else p for p in ports.values())
    return Circuit(
        NAME,
        (*outer, *(Port(name, "analog", shape=(count,)) for name in gates), Port("spike", "event", "out")),
        (),
        tuple(
            InstanceArray(name, part, (1 if name == "neuron" else count,), _wired_to_membrane(part))
            for name, part in parts.items()
        ),
        tuple(Node(name, (count,)) for name in inside[:2]),
    )


def _one_stage() -> Circuit:
    """A column of one stage whose ports are the column's."""
    part = replace(nef_encoder.build(), biases=())
    stage = InstanceArray("stage", part, (1,), part.wired())
    return Circuit("nef_column", part.ports, (), (stage,))


def _wired_to_membrane(part: Circuit) -> dict[str, str]:
    return {**part.wired(), **({"i_out": "v_mem"} if part.name == "nef_column" else {})}


def chip_biases() -> tuple[Bias, ...]:
    """Return the biases of the chip, named as in its blocks, without a stage's bits and signs."""
    return (
        *nef_neuron.BIASES,
        *(b for b in nef_encoder.BIASES if b.name == "i_pos"),
        *nef_synapse.BIASES,
    )


def circuits() -> tuple[Circuit, ...]:
    """Return the circuits that all devices of the chip stand in: neurons, a column, filters and lines."""
    return neurons(NEURONS), column(NEURONS), filters(FILTERS), lines(FILTERS)


CHIP = Chip(
    "nef-chip",
    f"{NEURONS} neurons whose curves a die sets, encoders, filters, a router of events",
    circuits,
    "run a network on it (chips.nef), or take one of its blocks, as nef-neuron",
)
