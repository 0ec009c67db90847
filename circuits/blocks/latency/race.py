"""Cell of the race to the first spike: a passive current that inhibitions oppose.

From the ping on a passive current charges the membrane. Each excitation adds a charge, and each inhibition
switches a current on that lasts to the end of the race. With charges Q and inhibitory currents I_i from t_i
on,

    T_WTA = (C_mem V_ref - Q_goal - Q_dir - sum I_i t_i) / (I_passive - sum I_i)          (10)

A charge is a step of I_charge for T_charge = C_t V_ref / I_pulse. `stop` is the event that recurrent
inhibition gives all cells when one of them has spiking: it brings the membrane to ground, as the ping at
`reset` does. The synapses are those of `circuits.blocks.latency.synapse`.

Source: Wen & Horiuchi 2022, section 3, "Action Selection Layer", equation (10). The circuit and all numbers
are ours: 58 ms without any input, as in the network.
"""

from __future__ import annotations

from dataclasses import dataclass

from circuits.blocks.block import DURATION, Stimulus, Values, catalogued
from circuits.blocks.drive import Wave, powered
from circuits.blocks.latency.synapse import (
    MembraneSizes,
    comparator_biases,
    compared,
    events,
    step_inhibition,
    step_synapse,
)
from circuits.blocks.measure import latency, spiking
from circuits.blocks.mos import mos
from circuits.blocks.ports import SUPPLY, biased, event_in, event_out
from circuits.blocks.rest import rested
from circuits.circuit import Bias, Circuit, Port
from circuits.devices import Capacitor, Device
from circuits.event import pulse
from circuits.solver.transient import Result
from circuits.testbench import Testbench
from circuits.units import quantity

EXCITATIONS, INHIBITIONS = 2, 2  # by itself: goal and direction of the ping; memories, 7 in the network


@dataclass(frozen=True, slots=True)
class Params(MembraneSizes):
    """Capacitors (F) and numbers of synapses; ours."""

    excitations: int = quantity(EXCITATIONS, "")
    inhibitions: int = quantity(INHIBITIONS, "")


BIASES = (
    Bias("i_passive", "v_passive", "gate", 345e-12, "mp"),  # ours: 58 ms
    Bias("i_charge", "v_charge", "gate", 800e-12, "excite0.me"),  # 0.08 of a threshold in 2 ms
    Bias("i_pulse", "v_pulse", "gate", 5e-9, "excite0.mt"),  # 2 ms
    Bias("i_inh", "v_inh", "gate", 100e-12, "inhibit0.mk"),
    Bias("i_hold", "v_hold", "gate", 100e-12, "inhibit0.mt"),  # 100 ms
    *comparator_biases("threshold.mc0"),
)


def build(params: Params = Params()) -> Circuit:
    """The cell: ports excite[n], inhibit[m], reset, stop (events in), spike (out), biases and the supply."""
    excitation = step_synapse(params.timer_capacitance)
    inhibition = step_inhibition(params.timer_capacitance)
    excite = Port("excite", "event", "in", (int(params.excitations),))
    inhibit = Port("inhibit", "event", "in", (int(params.inhibitions),))
    ports = (SUPPLY, excite, inhibit, *event_in("reset", "stop"), *event_out("spike"))
    membrane = Capacitor("cm", "v_mem", "0", params.membrane_capacitance)
    instances = (
        *(
            excitation.instance(f"excite{k}", event=node, v_exc="v_charge", v_step="v_pulse")
            for k, node in enumerate(excite.elements())
        ),
        *(inhibition.instance(f"inhibit{k}", event=node) for k, node in enumerate(inhibit.elements())),
        compared("threshold", "v_mem", "spike"),
    )
    devices = (membrane, passive_current(), *membrane_resets())
    return biased("latency_race", ports, BIASES, devices, instances)


def passive_current() -> Device:
    """The transistor that charges a cell's `v_mem` from the ping on."""
    return mos("mp", "p", "v_mem", "v_passive", "vdd", 6, 24)


def membrane_resets() -> tuple[Device, Device]:
    """The transistors that bring a cell's `v_mem` to ground, at events of `reset` and of `stop`."""
    return (
        mos("mz", "n", "v_mem", "reset", "0", 6, 1.5),
        mos("mx", "n", "v_mem", "stop", "0", 6, 1.5),
    )


PING = 20e-6  # s, ours: the testbench's reset
STOP = 90e-3  # s

STIMULI = (
    Stimulus("goal", "s", 5e-3, "charge of the goal, after the ping", can_be_off=True),
    Stimulus("direction", "s", None, "charge of the ping's direction", can_be_off=True),
    Stimulus("first", "s", 20e-3, "first inhibition", can_be_off=True),
    Stimulus("second", "s", None, "second inhibition", can_be_off=True),
    Stimulus("stop", "s", None, "recurrent inhibition", can_be_off=True),
    DURATION,
)
PLOTTED = ("inhibit[0]", "inhibit0.timer", "inhibit0.on", "v_mem", "spike")


def testbench(circuit: Circuit, stimuli: Values, v_dd: float) -> Testbench:
    """The ping at 20 us; excitations, inhibitions and `stop` so long (s) after it, or not at all."""
    ports = {"stop": ("stop",), "excite": ("goal", "direction"), "inhibit": ("first", "second")}
    waves: dict[str, Wave] = {"reset": pulse((PING,), v_dd)}
    for name, knobs in ports.items():
        waves |= events(circuit.port(name), tuple(stimuli[knob] for knob in knobs), PING, v_dd)
    sources = powered(v_dd, waves)
    return rested("race cell", circuit, sources, stimuli["duration"] or STOP, watch=("spike",))


def measures(result: Result) -> dict[str, float | None]:
    """Numbers of a run: `latency_s` from the ping to the spike, None without one."""
    return {"latency_s": latency(result, PING)}


outcome = spiking("spike", "none")

BLOCK = catalogued("race-cell", build, STIMULI, testbench, measures, outcome, PLOTTED)
