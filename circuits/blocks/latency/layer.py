"""Layer of cells that race to the first spike, and the inhibition that the first spike stops them with.

The cells are those of `circuits.blocks.latency.race`. The spike of any cell pulls a common line down, and a
latch keeps it there. From then on the recurrent inhibition charges its capacitor; when it reaches the
reference it stops every cell until the next ping:

    T_stop = T_first + C_r V_ref / I_recurrent

Cells that spike before that win too, so that the layer may have several winners, as the paper's has while its
recurrent inhibitory neuron charges. The ping resets cells, latch and capacitor.

Source: Wen & Horiuchi 2022, section 3, "Action Selection Layer", Figure 8. The circuit and all numbers are
ours: 1.4 ms of recurrent inhibition, as in the network.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from circuits.blocks.block import DURATION, Stimulus, Values, catalogued
from circuits.blocks.drive import powered
from circuits.blocks.latency import race as latency_race
from circuits.blocks.latency.synapse import MembraneSizes, compared, events
from circuits.blocks.mos import inverter, mos
from circuits.blocks.ports import SUPPLY, bias_in, biased, event_in, event_out
from circuits.blocks.rest import rested
from circuits.circuit import Bias, Circuit, Port
from circuits.devices import Capacitor
from circuits.event import pulse, rising_crossing
from circuits.lowering.supply import half_supply
from circuits.solver.transient import Result
from circuits.testbench import Testbench
from circuits.units import quantity

CELLS = 3  # of the block as it is simulated by itself
RECURRENT_CAPACITANCE = 5e-12  # F; ours


@dataclass(frozen=True, slots=True)
class Params(MembraneSizes):
    """Capacitors (F) and number of cells; ours."""

    recurrent_capacitance: float = quantity(RECURRENT_CAPACITANCE, "F")
    cells: int = quantity(CELLS, "")


BIASES = (
    *(replace(b, device=b.device and f"cell0.{b.device}") for b in latency_race.BIASES),
    Bias("i_recurrent", "v_recurrent", "gate", 7.3e-9, "recurrent.mt"),  # ours: 1.4 ms
)


def recurrent_inhibition(capacitance: float, cells: int) -> Circuit:
    """What stops the cells: ports spike[cells], reset (events in), stop (event out), biases.

    capacitance: of its timer, F.
    """
    spike, biases = Port("spike", "event", "in", (cells,)), bias_in("v_recurrent", "v_cmp", "v_ref")
    ports = (SUPPLY, spike, *event_in("reset"), *event_out("stop"), *biases)
    devices = (
        *(mos(f"mo{k}", "n", "quiet", f"spike[{k}]", "0", 6, 1.5) for k in range(cells)),
        *inverter("mu", "reset", "unset", width=3.0, length=1.5),
        mos("ml", "p", "quiet", "unset", "vdd", 12, 1.5),
        *inverter("mi", "quiet", "some", width=3.0, length=1.5),
        mos("mkp", "p", "quiet", "some", "vdd", 3, 24),  # keep what was said
        mos("mkn", "n", "quiet", "some", "0", 3, 24),
        mos("ms", "p", "foot", "quiet", "vdd", 6, 1.5),
        mos("mt", "p", "timer", "v_recurrent", "foot", 6, 24),
        mos("mz", "n", "timer", "reset", "0", 6, 1.5),
        Capacitor("cr", "timer", "0", capacitance),
    )
    return Circuit("recurrent_inhibition", ports, devices, (compared("timer", "timer", "stop"),))


def build(params: Params = Params()) -> Circuit:
    """The layer: ports inhibit[n], excite[n], reset (events in), spike[n] (out), biases and the supply."""
    count = int(params.cells)
    cell = latency_race.build(
        latency_race.Params(
            params.membrane_capacitance, params.timer_capacitance, excitations=1, inhibitions=1
        )
    )
    recurrent = recurrent_inhibition(params.recurrent_capacitance, count)
    ports = (
        SUPPLY,
        Port("excite", "event", "in", (count,)),
        Port("inhibit", "event", "in", (count,)),
        *event_in("reset"),
        Port("spike", "event", "out", (count,)),
    )
    cells = (
        cell.instance(f"cell{k}", excite=f"excite[{k}]", inhibit=f"inhibit[{k}]", spike=f"spike[{k}]")
        for k in range(count)
    )
    return biased("race_layer", ports, BIASES, (), (*cells, recurrent.instance("recurrent")))


PING = latency_race.PING
STOP = 70e-3  # s

STIMULI = (
    *(
        Stimulus(f"excite_{k}", "s", (5e-3, 6e-3, None)[k], f"charge of cell {k}", can_be_off=True)
        for k in range(3)
    ),
    *(
        Stimulus(f"inhibit_{k}", "s", (None, 40e-3, 20e-3)[k], f"inhibition of cell {k}", can_be_off=True)
        for k in range(3)
    ),
    DURATION,
)
PLOTTED = ("cell0.v_mem", "cell1.v_mem", "cell2.v_mem", "recurrent.timer", "stop")


def testbench(circuit: Circuit, stimuli: Values, v_dd: float) -> Testbench:
    """The ping at 20 us; excitation and inhibition of three cells, each so long (s) after it or off."""
    excite, inhibit = (
        events(circuit.port(kind), tuple(stimuli[f"{kind}_{k}"] for k in range(3)), PING, v_dd)
        for kind in ("excite", "inhibit")
    )
    sources = powered(v_dd, {"reset": pulse((PING,), v_dd)} | excite | inhibit)
    return rested("race layer", circuit, sources, stimuli["duration"] or STOP, watch=("spike",))


def measures(result: Result) -> dict[str, float | None]:
    """Numbers of a run: `latency_s` of the first spike after the ping, `stop_s` and `winners`.

    stop: from the first spike to the recurrent inhibition. None where what is asked for is not in the run.
    """
    half = half_supply(result.machine)
    firsts = sorted(float(t[0]) for t in result.spikes.values() if t.size)
    after = result.time > PING
    stops = rising_crossing(result.time[after], result["stop"][after], half)
    return {
        "latency_s": firsts[0] - PING if firsts else None,
        "stop_s": None if stops is None or not firsts else stops - firsts[0],
        "winners": float(len(firsts)),
    }


def outcome(result: Result) -> str:
    """The numbers of the cells that won, or `none`."""
    won = [name.partition("[")[2].rstrip("]") for name, times in result.spikes.items() if times.size]
    return " ".join(sorted(won)) if won else "none"


BLOCK = catalogued("race-layer", build, STIMULI, testbench, measures, outcome, PLOTTED)
