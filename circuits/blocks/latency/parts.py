"""Parts of the latency chip that are no blocks of their own: cells of both layers, gates and a pulse.

* `racing_cell`: a cell of the first layer. It is that of `circuits.blocks.latency.race` with a charge of its
  own for the goal and for the direction of the ping, and with inhibitions that depend on the distance of the
  memory and end at the next ping.
* `following_cell`: a cell of the second layer, whose only current is switched on by a spike of the first
  layer until the next ping.
* `lone_cell`: the emergency neuron, with a passive current alone.
* `any_of`: the memory's output, which is high while any of its units is.
* `edge_pulse`: an event of some 13 us at each rise. It stands between the integrating neuron, which stays
  high until the next ping, and the units, which take events. Its circuit is that of the end of a tap.

Source: Wen & Horiuchi 2022, section 3. Circuits and numbers are ours.
"""

from __future__ import annotations

from dataclasses import replace

from circuits.blocks.latency.race import membrane_resets, passive_current
from circuits.blocks.latency.synapse import compared, step_inhibition, step_synapse
from circuits.blocks.latency.tap import edge_event
from circuits.blocks.mos import inverter, mos
from circuits.blocks.ports import SUPPLY, bias_in, event_in, event_out
from circuits.circuit import Circuit, Instance, Port
from circuits.devices import Capacitor
from circuits.devices.device import Device

MEMBRANE, TIMER = 10e-12, 5e-12  # F, of the cells; ours


def racing_cell(reach: int) -> Circuit:
    """A cell of the first layer, with inhibitions from memories up to `reach` cells away.

    Ports goal, direction, inhibit[2 reach + 1], reset, stop (events in), spike (event out), and biases, of
    which v_inhibit[reach + 1] counts by the distance of the memory that inhibits.
    """
    excitation, inhibition = step_synapse(TIMER), ended(step_inhibition(TIMER))
    count = 2 * reach + 1
    excitations = (
        excitation.instance(f"excite{k}", event=name, v_exc=f"v_{name}", v_step="v_pulse")
        for k, name in enumerate(("goal", "direction"))
    )
    inhibitions = (
        inhibition.instance(
            f"inhibit{k}", event=f"inhibit[{k}]", end="reset",
            v_inh=f"v_inhibit[{abs(k - reach)}]", v_hold="v_inhibition",
        )
        for k in range(count)
    )  # fmt: skip
    ports = (
        SUPPLY,
        *event_in("goal", "direction", "reset", "stop"),
        Port("inhibit", "event", "in", (count,)),
        *event_out("spike"),
        Port("v_inhibit", "bias", "in", (reach + 1,)),
        *bias_in("v_passive", "v_goal", "v_direction", "v_pulse", "v_inhibition", "v_cmp", "v_ref"),
    )
    devices = (*_membrane(), passive_current())
    return Circuit("racing_cell", ports, devices, (*excitations, *inhibitions, _threshold()))


def following_cell() -> Circuit:
    """A cell of the second layer: ports excite, reset, stop (events in), spike (event out), biases."""
    part = ended(step_synapse(TIMER))
    excitation = part.instance("excite0", event="excite", end="reset", v_exc="v_second", v_step="v_kept")
    biases = bias_in("v_second", "v_kept", "v_cmp", "v_ref")
    ports = (SUPPLY, *event_in("excite", "reset", "stop"), *event_out("spike"), *biases)
    return Circuit("following_cell", ports, _membrane(), (excitation, _threshold()))


def lone_cell() -> Circuit:
    """The emergency neuron: ports reset, stop (events in), spike (event out), biases."""
    biases = bias_in("v_passive", "v_cmp", "v_ref")
    ports = (SUPPLY, *event_in("reset", "stop"), *event_out("spike"), *biases)
    return Circuit("lone_cell", ports, (*_membrane(), passive_current()), (_threshold(),))


def any_of(count: int) -> Circuit:
    """An OR gate, of a pseudo-nMOS NOR and an inverter: ports each[count] (events in), out (event out)."""
    ports = (SUPPLY, Port("each", "event", "in", (count,)), *event_out("out"))
    devices = (
        *(mos(f"mo{k}", "n", "none", f"each[{k}]", "0", 6, 1.5) for k in range(count)),
        mos("ml", "p", "none", "0", "vdd", 3, 24),  # weaker than any of them
        *inverter("mi", "none", "out", width=3.0, length=1.5),
    )
    return Circuit("any_of", ports, devices)


def edge_pulse() -> Circuit:
    """A pulse at each rise: ports level (event in), out (event out), v_cmp, which sets the pulse's width."""
    ports = (SUPPLY, *event_in("level"), *event_out("out"), *bias_in("v_cmp"))
    return Circuit("edge_pulse", ports, edge_event("level"))


def ended(part: Circuit) -> Circuit:
    """A step synapse with one more event port, `end`, which ends its step by filling its timer.

    Without it steps last longer than from one ping to the next.
    """
    devices = (
        *inverter("mw", "end", "going_on", width=3.0, length=1.5),
        mos("mq", "p", "timer", "going_on", "vdd", 6, 1.5),
    )
    return replace(
        part,
        name=f"ended_{part.name}",
        ports=(*part.ports, *event_in("end")),
        devices=(*part.devices, *devices),
    )


def _membrane() -> tuple[Device, ...]:
    return Capacitor("cm", "v_mem", "0", MEMBRANE), *membrane_resets()


def _threshold() -> Instance:
    return compared("threshold", "v_mem", "spike")
