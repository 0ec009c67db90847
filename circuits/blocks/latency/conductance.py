"""Conductance neuron of subthreshold transistors: a fast sodium conductance and a slow potassium one.

Each conductance is a differential pair, whose share of its tail current is a sigmoid of a voltage. With s(x)
= 1 / (1 + e^(-kappa x / U_T)), the membrane v and the gate w of the potassium follow

    C dv/dt = I_Na s(v - V_Na) - I_K s(w - V_K) + I_leak (2 s(V_rest - v) - 1) + I_tonic + I_synapse
    C_w dw/dt = I_w (2 s(v - w) - 1)

Potassium pulls the membrane down to where its pair leaves saturation, about kappa (w - V_T0), below rest:
that is its reversal potential. That of sodium is the supply, where its mirror ends. The slow gate opens the
potassium and so ends the spike. There is no inactivation apart from it, as in reductions of the
Hodgkin-Huxley equations to two variables. The circuit does what the network asks of a Hodgkin-Huxley neuron:
it rests, spikes once for a strong synapse and never for a weak one, spikes for two weak ones that coincide,
spikes without end for a steady current, is silent under inhibition, and has a refractory time.

Source: Wen & Horiuchi 2022, equations (12) and (13), for what is asked; the circuit of two variables is that
of Patel & DeWeerth (1997), Electronics Letters 33, 997, in outline and from memory. Sizes and numbers are
ours.
"""

from __future__ import annotations

from dataclasses import dataclass

from circuits.blocks.block import DURATION, Stimulus, Values, catalogued
from circuits.blocks.drive import powered
from circuits.blocks.latency.synapse import comparator_biases, events, step_inhibition, step_synapse
from circuits.blocks.measure import last_rate, latency
from circuits.blocks.mos import current_mirror, inverter, mos
from circuits.blocks.ports import SUPPLY, biased, event_in, event_out
from circuits.blocks.rest import rested
from circuits.blocks.sizes import Sizes
from circuits.circuit import Bias, Circuit, Port
from circuits.devices import Capacitor, Device
from circuits.solver.transient import Result
from circuits.testbench import Testbench
from circuits.units import quantity

EXCITATIONS = 2
REST, SODIUM, POTASSIUM = 1.5, 1.8, 1.95  # V: leak, and where the conductances are half open; ours


@dataclass(frozen=True, slots=True)
class Params(Sizes):
    """Capacitors, F; ours."""

    membrane_capacitance: float = quantity(5e-12, "F")
    gate_capacitance: float = quantity(2e-12, "F")
    timer_capacitance: float = quantity(2e-12, "F")


BIASES = (
    Bias("i_na", "v_na_tail", "gate", 20e-9, "mn0"),
    Bias("i_k", "v_k_tail", "gate", 80e-9, "mk0"),
    Bias("i_leak", "v_leak", "gate", 0.2e-9, "ml0"),
    Bias("i_gate", "v_gate", "gate", 0.5e-9, "mw0"),
    Bias("i_tonic", "v_tonic", "gate", 1e-12, "mp"),  # none to speak of
    Bias("i_exc", "v_exc", "gate", 0.85e-9, "excite0.me"),
    Bias("i_step", "v_step", "gate", 8e-9, "excite0.mt"),  # 0.5 ms
    Bias("i_inh", "v_inh", "gate", 5e-9, "inhibit.mk"),
    Bias("i_hold", "v_hold", "gate", 0.2e-9, "inhibit.mt"),  # 20 ms
    *comparator_biases("excite0.timer.mc0"),
    Bias("v_rest", "v_rest", "voltage", REST),
    Bias("v_na", "v_na", "voltage", SODIUM),
    Bias("v_k", "v_k", "voltage", POTASSIUM),
)


def build(params: Params = Params()) -> Circuit:
    """The neuron: ports excite[2], inhibit (events in), spike (event out), biases and the supply."""
    excitation = step_synapse(params.timer_capacitance)
    inhibition = step_inhibition(params.timer_capacitance)
    excite = Port("excite", "event", "in", (EXCITATIONS,))
    ports = (SUPPLY, excite, *event_in("inhibit"), *event_out("spike"))
    devices = (
        Capacitor("cm", "v_mem", "0", params.membrane_capacitance),
        Capacitor("cw", "w", "0", params.gate_capacitance),
        *_pair("mn", "v_na_tail", ("v_mem", "v_na"), ("na", "vdd")),
        *current_mirror("mn3", "mn4", "p", "na", "v_mem", (6, 6)),
        *_pair("mk", "v_k_tail", ("w", "v_k"), ("v_mem", "vdd")),
        *_follower("ml", "v_leak", "v_rest", "v_mem"),
        *_follower("mw", "v_gate", "v_mem", "w"),
        mos("mp", "p", "v_mem", "v_tonic", "vdd", 6, 24),
        *inverter("mi", "v_mem", "none", width=3.0, length=6.0),
        *inverter("mo", "none", "spike", width=3.0, length=1.5),
    )
    instances = (
        *(excitation.instance(f"excite{k}", event=node) for k, node in enumerate(excite.elements())),
        inhibition.instance("inhibit", event="inhibit"),
    )
    return biased("latency_conductance", ports, BIASES, devices, instances)


def _pair(name: str, tail: str, gates: tuple[str, str], drains: tuple[str, str]) -> tuple[Device, ...]:
    """Differential pair of nFETs, its tail `{name}0`."""
    node = f"{name}_tail"
    return (
        mos(f"{name}0", "n", node, tail, "0", 6, 24),
        mos(f"{name}1", "n", drains[0], gates[0], node, 6, 6),
        mos(f"{name}2", "n", drains[1], gates[1], node, 6, 6),
    )


def _follower(name: str, tail: str, plus: str, out: str) -> tuple[Device, ...]:
    """Transconductor whose output follows `plus`: a pair and a mirror."""
    return (
        *_pair(name, tail, (plus, out), (f"{name}_m", out)),
        mos(f"{name}3", "p", f"{name}_m", f"{name}_m", "vdd", 6, 6),
        mos(f"{name}4", "p", out, f"{name}_m", "vdd", 6, 6),
    )


START = 5e-3  # s, ours: from which the testbench counts
STOP = 40e-3  # s

STIMULI = (
    Stimulus("first", "s", 0.0, "first excitation, after 5 ms", can_be_off=True),
    Stimulus("second", "s", 1e-3, "second excitation", can_be_off=True),
    Stimulus("inhibit", "s", None, "inhibition", can_be_off=True),
    DURATION,
)
PLOTTED = ("excite[0]", "excite[1]", "v_mem", "w", "spike")


def testbench(circuit: Circuit, stimuli: Values, v_dd: float) -> Testbench:
    """Two excitations and an inhibition, each so long (s) after 5 ms, or not at all."""
    excite = events(circuit.port("excite"), (stimuli["first"], stimuli["second"]), START, v_dd)
    inhibit = events(circuit.port("inhibit"), (stimuli["inhibit"],), START, v_dd)
    sources = powered(v_dd, excite | inhibit)
    return rested("conductance", circuit, sources, stimuli["duration"] or STOP, watch=("spike",))


def measures(result: Result) -> dict[str, float | None]:
    """Numbers of a run: `spikes`, `latency_s` of the first after 5 ms, `rate_Hz` and `rest_V`.

    The rate is that of the last interval. None where what is asked for is not in the run.
    """
    spikes = result.spikes["spike"]
    return {
        "spikes": float(spikes.size),
        "latency_s": latency(result, START),
        "rate_Hz": last_rate(spikes),
        "rest_V": float(result["v_mem"][0]),
    }


def outcome(result: Result) -> str:
    """`silent`, `spike` or `spikes`."""
    return ("silent", "spike", "spikes")[min(result.spikes["spike"].size, 2)]


BLOCK = catalogued("conductance-neuron", build, STIMULI, testbench, measures, outcome, PLOTTED)
