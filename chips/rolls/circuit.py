"""The ROLLS chip as a circuit: 256 rows, each of a neuron, its filters and the synapses onto it.

A row holds

* `synapse[256]`, one a presynaptic neuron, on two lines, `exc` and `inh`, with a filter each;
* `virtual_exc[4]`, `virtual_inh[4]`: virtual synapses, which have the constant current alone, with a pulse
  extender each and two filters of their own;
* `plastic`: the filter of the plastic synapses, which feeds the NMDA gate; they stand in
  `chips.rolls.plastic.circuit`, and without them it is silent;
* `neuron`: the excitatory filters' currents flow into `i_in`, the inhibitory ones' are drawn from `v_mem`.

`extender[256]`: one a column; it serves the synapses of a presynaptic neuron. That a column shares its
extender, that virtual synapses are like the others, and that inhibition is drawn from the membrane is ours;
what is found is in `circuits.blocks.rolls.dpi_synapse` and `circuits.blocks.rolls.neuron`. The current biases
are those of the control software's codes, the shared ones once a chip.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from chips.registry import Chip
from chips.rolls.program.address import LAB_VIRTUAL, NEURONS, VirtualSynapses
from chips.rolls.program.bias_file import BiasTable, default_biases
from circuits.blocks.rolls import dpi_synapse
from circuits.blocks.rolls import neuron as rolls_neuron
from circuits.circuit import Bias, BiasKind, Circuit, Instance, InstanceArray, Node, Port

NAME = "rolls_chip"
SUPPLY = Port("vdd", "supply")

_NEURON = {
    "i_thr": "IF_THR_N", "i_tau1": "IF_TAU1_N", "i_tau2": "IF_TAU2_N", "i_dc": "IF_DC_P",
    "i_buf": "IF_BUF_P", "i_rfr1": "IF_RFR1_N", "i_rfr2": "IF_RFR2_N", "i_ahw": "IF_AHW_P",
    "i_athr": "IF_ATHR_N", "i_ahtau": "IF_AHTAU_N", "i_nmda": "IF_NMDA_N",
}  # fmt: skip
_WEIGHTS = {
    "i_exc": "NPA_WEIGHT_EXC_P", "i_exc0": "NPA_WEIGHT_EXC0_P", "i_exc1": "NPA_WEIGHT_EXC1_P",
    "i_inh": "NPA_WEIGHT_INH_N", "i_inh0": "NPA_WEIGHT_INH0_N", "i_inh1": "NPA_WEIGHT_INH1_N",
}  # fmt: skip
FILTERS = ("excitatory", "inhibitory", "virtual_excitatory", "virtual_inhibitory")
_FILTER_CODES = {
    "excitatory": ("NPDPIE_TAU_P", "NPDPIE_THR_P"),
    "inhibitory": ("NPDPII_TAU_P", "NPDPII_THR_P"),
    "virtual_excitatory": ("VDPIE_TAU_P", "VDPIE_THR_P"),
    "virtual_inhibitory": ("VDPII_TAU_N", "VDPII_THR_N"),
    "plastic": ("PDPI_TAU_P", "PDPI_THR_P"),
}
_LINES = {
    "excitatory": ("exc", "i_in"), "inhibitory": ("inh", "v_mem"), "virtual_excitatory": ("vexc", "i_in"),
    "virtual_inhibitory": ("vinh", "v_mem"), "plastic": ("pexc", "i_nmda"),
}  # fmt: skip
_VIRTUAL_WEIGHT = {"virtual_exc": ("v_exc", "VA_EXC_N"), "virtual_inh": ("v_inh", "VA_INH_P")}


@dataclass(frozen=True, slots=True)
class Params:
    """Sizes of the chip's blocks, and how many virtual synapses each neuron has."""

    neuron: rolls_neuron.Params = field(default_factory=rolls_neuron.Params)
    synapse: dpi_synapse.Params = field(default_factory=dpi_synapse.Params)
    virtual: VirtualSynapses = LAB_VIRTUAL


def bias_ports(circuit: str) -> dict[str, str]:
    """Return the port of a row for each bias port of a part of it.

    circuit: `neuron`, `synapse`, `extender`, a virtual synapse's or a filter's name.
    """
    if circuit == "neuron":
        return {b.port: b.port for b in rolls_neuron.BIASES if b.name != "v_select"} | {"select": "select"}
    if circuit in _FILTER_CODES:
        return {"v_tau": f"{circuit}_tau", "v_thr": f"{circuit}_thr"}
    if circuit == "extender":
        return {"v_pwlk": "v_pwlk"}
    ports = {f"v_{name[2:]}": f"v_{name[2:]}" for name in _WEIGHTS} | {"v_shift": "synapse_shift"}
    if circuit in _VIRTUAL_WEIGHT:
        off = {"v_exc": "vdd", "v_exc0": "vdd", "v_exc1": "vdd", "v_inh": "0", "v_inh0": "0", "v_inh1": "0"}
        port, _ = _VIRTUAL_WEIGHT[circuit]
        return off | {port: circuit, "v_shift": "synapse_shift"}
    return ports


def biases(table: BiasTable | None = None, kind: BiasKind = "gate", prefix: str = "") -> tuple[Bias, ...]:
    """Return the biases of a row, or of the chip where `prefix` is the row's name, with a table's codes.

    A code 0 is the generator's least current (`circuits.blocks.rolls.bias`).
    """
    codes = default_biases() if table is None else table
    found = []
    for block, names, inner in ((rolls_neuron, _NEURON, "neuron."), (dpi_synapse, _WEIGHTS, "")):
        for bias in block.BIASES:
            if bias.name in names:
                value = codes.current(names[bias.name])
                found.append(replace(bias, kind=kind, value=value, device=f"{prefix}{inner}{bias.device}"))
    for name, (tau, thr) in _FILTER_CODES.items():
        for port, code, device in (("tau", tau, "md3"), ("thr", thr, "md4")):
            where = f"{prefix}{name}.{device}"
            found.append(Bias(f"i_{name}_{port}", f"{name}_{port}", kind, codes.current(code), where))
    for name, (port, code) in _VIRTUAL_WEIGHT.items():
        device = "me2" if port == "v_exc" else "mi2"
        found.append(Bias(f"i_{name}", name, kind, codes.current(code), f"{prefix}{name}.{device}"))
    pulse = f"{prefix}virtual_exc_extender.mp2" if prefix == "" else "extender.mp2"
    found.append(Bias("i_pwlk", "v_pwlk", kind, codes.current("NPA_PWLK_P"), pulse))
    shift = next(b for b in dpi_synapse.BIASES if b.name == "v_shift")
    found.append(replace(shift, port="synapse_shift", name="v_synapse_shift"))
    found += [b for b in rolls_neuron.BIASES if b.name == "v_shift"]
    return tuple(found)


def row(params: Params = Params(), table: BiasTable | None = None, kind: BiasKind = "gate") -> Circuit:
    """Build a row: a neuron with its synapses and filters.

    Its ports are pulse[256] and the latches of every synapse, events of the virtual synapses, v_mem, spike,
    the leak's latch `select`, the biases and the supply.
    """
    synapse = dpi_synapse.synapse(params.synapse)
    shape = (NEURONS,)
    own = synapse.wired() | bias_ports("synapse")
    instances: list[Instance | InstanceArray] = [InstanceArray("synapse", synapse, shape, own)]
    for name, (line, out) in _LINES.items():
        make = dpi_synapse.inhibitory_filter if name.endswith("inhibitory") else dpi_synapse.excitatory_filter
        wires = {"vdd": "vdd", "line": line, "v_syn": f"{name}_v_syn", "i_out": out} | bias_ports(name)
        instances.append(Instance(name, make(params.synapse), wires))
    neuron = rolls_neuron.build(params.neuron)
    own = neuron.wired()
    instances.append(Instance("neuron", neuron, own))
    counts = {"virtual_exc": params.virtual.excitatory, "virtual_inh": params.virtual.inhibitory}
    for name, count in counts.items():
        if count:
            instances += _virtual(params, name, count)
    virtual = {k: c for k, c in counts.items() if c}
    ports = (
        SUPPLY,
        Port("pulse", "analog", "in", shape),
        *(Port(latch, "bias", "in", shape) for latch in dpi_synapse.LATCHES),
        *(Port(f"{name}_event", "event", "in", (count,)) for name, count in virtual.items()),
        Port("v_mem", "analog", "out"),
        Port("spike", "event", "out"),
        Port("select", "bias"),
        *(Port(b.port, "bias") for b in _known(biases(), virtual)),
    )
    nodes = tuple(Node(f"{name}_pulse", (count,)) for name, count in virtual.items())
    chosen = _known(biases(table, kind), virtual)
    return Circuit("rolls_row", ports, (), tuple(instances), nodes, chosen)


def _known(found: tuple[Bias, ...], virtual: dict[str, int]) -> tuple[Bias, ...]:
    """Biases without those of virtual synapses that a row does not have."""
    missing = {name for name in _VIRTUAL_WEIGHT if name not in virtual}
    kept = [b for b in found if b.port not in missing]
    if "virtual_exc" in missing:
        swap = {"virtual_exc_extender.mp2": "virtual_inh_extender.mp2"}
        kept = [replace(b, device=swap.get(b.device or "", b.device)) for b in kept]
        if "virtual_inh" in missing:
            # a row without virtual synapses has no extender, and no port for its bias
            kept = [b for b in kept if b.name != "i_pwlk" or (b.device or "").startswith("extender")]
    return tuple(kept)


def _virtual(params: Params, name: str, count: int) -> list[Instance | InstanceArray]:
    extender, synapse = dpi_synapse.pulse_extender(params.synapse), dpi_synapse.synapse(params.synapse)
    high = name == "virtual_exc"
    latched = {"recurrent": "vdd", "sign": "vdd" if high else "0", "w0": "0", "w1": "0"}
    nodes = {"vdd": "vdd", "pulse": f"{name}_pulse", "exc": "vexc", "inh": "vinh"} | latched
    return [
        InstanceArray(
            f"{name}_extender",
            extender,
            (count,),
            {"vdd": "vdd", "event": f"{name}_event", "pulse": f"{name}_pulse", "v_pwlk": "v_pwlk"},
        ),
        InstanceArray(name, synapse, (count,), nodes | bias_ports(name)),
    ]


def chip(params: Params = Params(), table: BiasTable | None = None, kind: BiasKind = "gate") -> Circuit:
    """Build the chip: all rows, and a pulse extender for each column.

    Its ports are a row's, an array of 256 where they are a row's own.
    """
    one, extender = row(params, table, kind), dpi_synapse.pulse_extender(params.synapse)
    shape, shared = (NEURONS,), {b.port for b in one.biases} | {"vdd"}
    ports = (
        *(
            p if p.name in shared else replace(p, shape=shape + p.shape)
            for p in one.ports
            if p.name != "pulse"
        ),
        Port("event", "event", "in", shape),
    )
    wires = {"vdd": "vdd", "event": "event", "pulse": "pulse", "v_pwlk": "v_pwlk"}
    instances = (
        InstanceArray("row", one, shape, one.wired()),
        InstanceArray("extender", extender, shape, wires),
    )
    found = _known(
        biases(table, kind, "row."),
        {n: 1 for n in _VIRTUAL_WEIGHT if f"{n}_event" in {p.name for p in one.ports}},
    )
    # the columns' extenders have theirs even where a row has no virtual synapse
    named = {p.name for p in ports}
    ports += tuple(Port(b.port, "bias") for b in found if b.port not in named)
    return Circuit(NAME, ports, (), instances, (Node("pulse", shape),), found)


CHIP = Chip(
    "rolls",
    "256 neurons, 256 x 256 synapses of eight levels, and virtual synapses",
    lambda: (chip(),),
    "show rolls, run rolls, or export rolls at row[0] for a neuron with its synapses",
)
