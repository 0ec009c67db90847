"""Parts of the latency chip that its blocks do not have by themselves: cells of both layers, gates, a pulse.

* `racing_cell`: the first layer's cell, `circuits.blocks.latency.race` with a charge of its own for the goal
  and for the direction of the ping, and an inhibition by distance of the memory, which the next ping ends;
* `following_cell`: the second layer's, whose only current is switched on by the first layer's spike until
  the next ping;
* `lone_cell`: a passive current alone, the emergency neuron;
* `any_of`: the memory's output, high while any of its units is;
* `edge_pulse`: an event of some 13 us at each rise, between the integrating neuron, which stays high until
  the next ping, and the units, which take events; the circuit is that of a tap's end.

Source: Wen & Horiuchi 2022, section 3; circuits and numbers are ours.
"""

from __future__ import annotations

from dataclasses import replace

from circuits.blocks.latency.synapse import comparator, step_inhibition, step_synapse
from circuits.blocks.latency.tap import edge_event
from circuits.blocks.mos import inverter, mos
from circuits.circuit import Circuit, Instance, Port
from circuits.devices import Capacitor
from circuits.devices.device import Device

MEMBRANE, TIMER = 10e-12, 5e-12  # F, of the cells; ours


def racing_cell(reach: int) -> Circuit:
    """Ports goal, direction, inhibit[2 reach + 1], reset, stop (events in), spike (event out), biases.

    v_inhibit[reach + 1]: by the distance of the memory that inhibits.
    """
    excitation, inhibition = step_synapse(TIMER), ended(step_inhibition(TIMER))
    count = 2 * reach + 1
    own = excitation.wired()
    held = inhibition.wired(v_hold="v_inhibition", end="reset")
    instances = [
        Instance(f"excite{k}", excitation, own | {"event": name, "v_exc": f"v_{name}", "v_step": "v_pulse"})
        for k, name in enumerate(("goal", "direction"))
    ]
    instances += [
        Instance(
            f"inhibit{k}", inhibition,
            held | {"event": f"inhibit[{k}]", "v_inh": f"v_inhibit[{abs(k - reach)}]"},
        )
        for k in range(count)
    ]  # fmt: skip
    ports = (
        Port("vdd", "supply"),
        *(Port(name, "event") for name in ("goal", "direction", "reset", "stop")),
        Port("inhibit", "event", "in", (count,)),
        Port("spike", "event", "out"),
        Port("v_inhibit", "bias", "in", (reach + 1,)),
        *(Port(f"v_{name}", "bias") for name in ("passive", "goal", "direction", "pulse", "inhibition")),
        *(Port(name, "bias") for name in ("v_cmp", "v_ref")),
    )
    passive = mos("mp", "p", "v_mem", "v_passive", "vdd", 6, 24)
    return Circuit("racing_cell", ports, (*_membrane(), passive), (*instances, _threshold()))


def following_cell() -> Circuit:
    """Ports excite, reset, stop (events in), spike (event out), biases."""
    part = ended(step_synapse(TIMER))
    connections = part.wired(event="excite", end="reset", v_exc="v_second", v_step="v_kept")  # fmt: skip
    ports = (
        Port("vdd", "supply"),
        *(Port(name, "event") for name in ("excite", "reset", "stop")),
        Port("spike", "event", "out"),
        *(Port(name, "bias") for name in ("v_second", "v_kept", "v_cmp", "v_ref")),
    )
    return Circuit(
        "following_cell", ports, _membrane(), (Instance("excite0", part, connections), _threshold())
    )


def lone_cell() -> Circuit:
    """Ports reset, stop (events in), spike (event out), biases."""
    ports = (
        Port("vdd", "supply"),
        *(Port(name, "event") for name in ("reset", "stop")),
        Port("spike", "event", "out"),
        *(Port(name, "bias") for name in ("v_passive", "v_cmp", "v_ref")),
    )
    passive = mos("mp", "p", "v_mem", "v_passive", "vdd", 6, 24)
    return Circuit("lone_cell", ports, (*_membrane(), passive), (_threshold(),))


def any_of(count: int) -> Circuit:
    """Pseudo-nMOS NOR and an inverter: ports in[n] (events), out (event out)."""
    ports = (
        Port("vdd", "supply"),
        Port("each", "event", "in", (count,)),
        Port("out", "event", "out"),
    )
    devices = (
        *(mos(f"mo{k}", "n", "none", f"each[{k}]", "0", 6, 1.5) for k in range(count)),
        mos("ml", "p", "none", "0", "vdd", 3, 24),  # weaker than any of them
        *inverter("mi", "none", "out", width=3.0, length=1.5),
    )
    return Circuit("any_of", ports, devices)


def edge_pulse() -> Circuit:
    """Ports level (in), out (event out), v_cmp, which sets the width."""
    ports = (
        Port("vdd", "supply"),
        Port("level", "event"),
        Port("out", "event", "out"),
        Port("v_cmp", "bias"),
    )
    return Circuit("edge_pulse", ports, edge_event("level"))


def ended(part: Circuit) -> Circuit:
    """A step synapse with an event port `end`, which fills its timer: without it steps outlast the ping."""
    devices = (
        *inverter("mw", "end", "going_on", width=3.0, length=1.5),
        mos("mq", "p", "timer", "going_on", "vdd", 6, 1.5),
    )
    return replace(
        part,
        name=f"ended_{part.name}",
        ports=(*part.ports, Port("end", "event")),
        devices=(*part.devices, *devices),
    )


def _membrane() -> tuple[Device, ...]:
    return (
        Capacitor("cm", "v_mem", "0", MEMBRANE),
        mos("mz", "n", "v_mem", "reset", "0", 6, 1.5),
        mos("mx", "n", "v_mem", "stop", "0", 6, 1.5),
    )


def _threshold() -> Instance:
    part = comparator()
    return Instance("threshold", part, part.wired(plus="v_mem", above="spike"))
