"""Cell of the race to the first spike: a passive current against step inhibitions, stopped by another spike.

From the ping on, a passive current charges the membrane; excitations add a charge each, inhibitions switch a
current on that lasts to the end of the race. With charges Q and inhibitory currents I_i from t_i on,

    T_WTA = (C_mem V_ref - Q_goal - Q_dir - sum I_i t_i) / (I_passive - sum I_i)          (10)

A charge is a step of I_charge for T_charge = C_t V_ref / I_pulse. `stop` is what recurrent inhibition
gives all cells where one of them has spiked: it brings the membrane to ground, as `reset`, the ping, does.

Synapses are those of `circuits.blocks.latency.synapse`. Source: Wen & Horiuchi 2022, section 3, "Action
Selection Layer", equation (10); circuit and all numbers are ours: 58 ms without any input, as in the network.
"""

from __future__ import annotations

from dataclasses import dataclass

from circuits.blocks.block import Block, Stimulus, Values
from circuits.blocks.latency.synapse import comparator, event_sources, step_inhibition, step_synapse
from circuits.blocks.mos import mos
from circuits.blocks.rest import started_at_rest
from circuits.checks import require_positive
from circuits.circuit import Bias, Circuit, Instance, Port
from circuits.count import whole_number
from circuits.devices import Capacitor, Source
from circuits.devices.source import Constant
from circuits.event import pulse
from circuits.silicon.process import AMI_1500
from circuits.solver.power import supply_power
from circuits.solver.transient import Result
from circuits.testbench import Testbench
from circuits.units import quantity

EXCITATIONS, INHIBITIONS = 2, 2  # by itself: goal and direction of the ping; memories, 7 in the network
REFERENCE = 2.0  # V


@dataclass(frozen=True, slots=True)
class Params:
    """Capacitors in farad, numbers of synapses; ours. Raises `ParameterError` for what cannot be built."""

    membrane_capacitance: float = quantity(10e-12, "F")
    timer_capacitance: float = quantity(5e-12, "F")
    excitations: int = quantity(EXCITATIONS, "")
    inhibitions: int = quantity(INHIBITIONS, "")

    def __post_init__(self) -> None:
        require_positive(self, "membrane_capacitance", "timer_capacitance")
        for name in ("excitations", "inhibitions"):
            whole_number(name, getattr(self, name))


BIASES = (
    Bias("i_passive", "v_passive", "gate", 345e-12, "mp"),  # ours: 58 ms
    Bias("i_charge", "v_charge", "gate", 800e-12, "excite0.me"),  # 0.08 of a threshold in 2 ms
    Bias("i_pulse", "v_pulse", "gate", 5e-9, "excite0.mt"),  # 2 ms
    Bias("i_inh", "v_inh", "gate", 100e-12, "inhibit0.mk"),
    Bias("i_hold", "v_hold", "gate", 100e-12, "inhibit0.mt"),  # 100 ms
    Bias("i_cmp", "v_cmp", "gate", 50e-9, "threshold.mc0"),
    Bias("v_ref", "v_ref", "voltage", REFERENCE),
)


def build(params: Params = Params()) -> Circuit:
    """Ports excite[n], inhibit[m], reset, stop (events in), spike (event out), biases and the supply."""
    excitation = step_synapse(params.timer_capacitance)
    inhibition = step_inhibition(params.timer_capacitance)
    threshold = comparator()
    ports = (
        Port("vdd", "supply"),
        Port("excite", "event", "in", (int(params.excitations),)),
        Port("inhibit", "event", "in", (int(params.inhibitions),)),
        Port("reset", "event"),
        Port("stop", "event"),
        Port("spike", "event", "out"),
        *(Port(b.port, "bias") for b in BIASES),
    )
    devices = (
        Capacitor("cm", "v_mem", "0", params.membrane_capacitance),
        mos("mp", "p", "v_mem", "v_passive", "vdd", 6, 24),
        mos("mz", "n", "v_mem", "reset", "0", 6, 1.5),
        mos("mx", "n", "v_mem", "stop", "0", 6, 1.5),
    )
    instances = [
        Instance(
            f"excite{k}", excitation,
            excitation.wired(event=f"excite[{k}]", v_exc="v_charge", v_step="v_pulse"),
        )
        for k in range(int(params.excitations))
    ]  # fmt: skip
    own = inhibition.wired()
    instances += [
        Instance(f"inhibit{k}", inhibition, own | {"event": f"inhibit[{k}]"})
        for k in range(int(params.inhibitions))
    ]
    plus = threshold.wired(plus="v_mem", above="spike")
    instances.append(Instance("threshold", threshold, plus))
    return Circuit("latency_race", ports, devices, tuple(instances), biases=BIASES)


PING = 20e-6  # s, ours: the testbench's reset
STOP = 90e-3  # s


def testbench(circuit: Circuit, stimuli: Values, v_dd: float) -> Testbench:
    """Reset at 20 us; excitations and inhibitions, each off or so long after it; `stop` likewise."""
    stopped = event_sources("stop", (stimuli["stop"],), 1, PING, v_dd)[0]
    excitations, inhibitions = (circuit.port(name).shape[0] for name in ("excite", "inhibit"))
    sources = (
        Source("vdd", "vdd", Constant(v_dd)),
        Source("reset", "reset", pulse((PING,), v_dd)),
        Source("stop", "stop", stopped.waveform),
        *event_sources("excite", (stimuli["goal"], stimuli["direction"]), excitations, PING, v_dd),
        *event_sources("inhibit", (stimuli["first"], stimuli["second"]), inhibitions, PING, v_dd),
    )
    bench = Testbench("race cell", circuit, sources, stimuli["duration"] or STOP, watch=("spike",))
    return started_at_rest(bench, AMI_1500)


def measures(result: Result) -> dict[str, float | None]:
    """`latency_s` of the spike after the ping, None without one; `supply_power_W`."""
    spikes = result.spikes["spike"]
    return {
        "latency_s": float(spikes[0]) - PING if spikes.size else None,
        "supply_power_W": supply_power(result),
    }


def outcome(result: Result) -> str:
    """`spike`, or `none`."""
    return "spike" if result.spikes["spike"].size else "none"


BLOCK = Block(
    name="race-cell",
    summary="passive current against step inhibitions: the cell of a race to the first spike",
    params=Params,
    build=build,
    stimuli=(
        Stimulus("goal", "s", 5e-3, "charge of the goal, after the ping", can_be_off=True),
        Stimulus("direction", "s", None, "charge of the ping's direction", can_be_off=True),
        Stimulus("first", "s", 20e-3, "first inhibition", can_be_off=True),
        Stimulus("second", "s", None, "second inhibition", can_be_off=True),
        Stimulus("stop", "s", None, "recurrent inhibition", can_be_off=True),
        Stimulus("duration", "s", None, "length of the run", can_be_off=True),
    ),
    testbench=testbench,
    measures=measures,
    outcome=outcome,
    plotted=("inhibit[0]", "inhibit0.timer", "inhibit0.on", "v_mem", "spike"),
)
