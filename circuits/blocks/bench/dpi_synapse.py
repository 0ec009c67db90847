"""DPI synapse of the teaching chip: pulse extender, one weight, and the filter of the ROLLS synapse.

The filter is that of `circuits.blocks.rolls.dpi_synapse`, with its capacitor to ground and other sizes. While
a pulse lasts, the weight's current is divided between the supply and v_syn; between pulses I_tau brings v_syn
back towards the supply:

    dv_syn/dt = I_tau / C_syn                 while v_syn is far below the supply
    tau = C_syn U_T / (kappa I_tau)           of the output current

v_syn falls no further than where the pair gives the threshold's side all of the current, which V_thr sets:
a gate voltage of a pFET below the supply, as the bias of type P makes it.

Source: topology, sizes (C_syn is 32 um square, 2.08 pF) and the biases' codes are the laboratory's. That the
switch stands below the weight is ours, and the size of V_thr's device, that of the others.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from circuits.blocks.bench import pulse_extender
from circuits.blocks.bench.bias import MASTERS, coded_bias
from circuits.blocks.bench.curve import slope
from circuits.blocks.block import Stimulus, Values, catalogued, lasting
from circuits.blocks.drive import powered, train
from circuits.blocks.measure import between, fall, rise
from circuits.blocks.mos import mos
from circuits.blocks.ports import SUPPLY, analog_out, biased, event_in
from circuits.blocks.rest import rested
from circuits.blocks.rolls import dpi_synapse
from circuits.blocks.sizes import Sizes, um
from circuits.circuit import Bias, Circuit
from circuits.event import pulse
from circuits.silicon.process import ROLLS_180
from circuits.solver.power import drain_current
from circuits.solver.transient import Result
from circuits.testbench import Testbench
from circuits.units import quantity

FIRST_EVENT = 1e-3  # s
OUT_AT = 0.6  # V, where the output's current is read; ours


@dataclass(frozen=True, slots=True)
class Params(Sizes):
    """Capacitors (F) and sizes (um)."""

    synapse_capacitance: float = quantity(2.08e-12, "F")
    line_capacitance: float = quantity(0.0, "F", least=0.0)  # of v_syn, beside: the buffer's input
    extender_capacitance: float = quantity(0.40e-12, "F")
    filter_width: float = um(3.2)  # of the pair, the weight, I_tau and the output
    filter_length: float = um(3.2)
    switch_width: float = um(1.0)
    switch_length: float = um(1.0)

    def filter_params(self) -> dpi_synapse.Params:
        """Sizes and capacitors of the filter, as that of ROLLS takes them."""
        size = self.size("filter")
        return dpi_synapse.Params(
            synapse_capacitance=self.synapse_capacitance + self.line_capacitance,
            line_capacitance=0.0,
            pair_width=size[0],
            pair_length=size[1],
            tau_width=size[0],
            tau_length=size[1],
            output_width=size[0],
            output_length=size[1],
        )


SIZE = (3.2, 3.2)


def filter_biases(instance: str, suffix: str = "") -> tuple[Bias, ...]:
    """Biases of I_tau and of the threshold of a filter that is called `instance`."""
    return (
        coded_bias(f"tau{suffix}", MASTERS[0], 25, f"{instance}.md3", SIZE),
        coded_bias(f"thr{suffix}", MASTERS[0], 30, f"{instance}.md4", SIZE),
    )


BIASES = (
    *filter_biases("filter"),
    coded_bias("weight", MASTERS[3], 100, "mw", SIZE),
    coded_bias("pulse", MASTERS[0], 10, "extender.m_tau", (4.0, 4.0)),
)


def build(params: Params = Params()) -> Circuit:
    """The synapse: ports event (in), v_syn, i_out (current out), biases and the supply; params: its sizes."""
    size = params.size("filter")
    extender = pulse_extender.Params(extender_capacitance=params.extender_capacitance)
    instances = (
        pulse_extender.build(extender).instance("extender", v_tau="v_pulse"),
        dpi_synapse.excitatory_filter(params.filter_params(), "0").instance("filter"),
    )
    weight = (
        mos("mw", "n", "line", "v_weight", "low", *size),
        mos("m_in", "n", "low", "pulse", "0", *params.size("switch")),
    )
    ports = (SUPPLY, *event_in("event"), *analog_out("v_syn", "i_out"))
    return biased("bench_dpi_synapse", ports, BIASES, weight, instances)


def testbench(circuit: Circuit, stimuli: Values, v_dd: float) -> Testbench:
    """Events from 1 ms on at a rate, into an ideal voltage.

    Raises `ParameterError` for no events or too many, and for a rate of 0 or below.
    """
    values = {name: value or 0.0 for name, value in stimuli.items()}
    times = train("events", values["events"], values["rate"], FIRST_EVENT)
    held = dict.fromkeys(OUTPUTS & {port.name for port in circuit.ports}, OUT_AT)
    sources = powered(v_dd, {"event": pulse(times, v_dd), **held})
    return rested(circuit.name, circuit, sources, values["duration"], ROLLS_180)


OUTPUTS = {"i_out"}
STIMULI = (
    Stimulus("events", "", 1.0, "how many events"),
    Stimulus("rate", "Hz", 4.0, "of the events"),
    lasting(0.25),
)
PLOTTED = ("event", "pulse", "v_syn")


def measures(result: Result) -> dict[str, float | None]:
    """Numbers of a run: `pulse_width_s`, `rest_V`, `floor_V`, `recovery_V_per_s`, `peak_current_A`, `tau_s`.

    rest, floor: v_syn at the beginning, and its lowest. recovery: its rise over the middle half of the way
    back, None where that is not in the run. tau: time constant of the output's current there, in weak
    inversion that by which it falls e-fold.
    """
    time, v = result.time, result["v_syn"]
    current = np.abs(drain_current(result, "filter.md5"))
    low = int(v.argmin())
    rest, floor = float(v[0]), float(v[low])
    span = rest - floor
    after = np.arange(time.size) > low
    way = after & (v > floor + 0.25 * span) & (v < rest - 0.25 * span)
    decay = slope(time, np.log(np.maximum(current, 1e-30)), way)
    return {
        "pulse_width_s": between(rise(result, "pulse"), fall(result, "pulse")),
        "rest_V": rest,
        "floor_V": floor,
        "recovery_V_per_s": slope(time, v, way),
        "peak_current_A": float(current.max()),
        "tau_s": None if decay is None or decay >= 0.0 else -1.0 / decay,
    }


def outcome(result: Result) -> str:
    """`responds` where the output's current rises a hundredfold, else `silent`."""
    current = np.abs(drain_current(result, "filter.md5"))
    return "responds" if float(current.max()) > 100.0 * float(current[0]) else "silent"


BLOCK = catalogued("dpi-synapse-bench", build, STIMULI, testbench, measures, outcome, PLOTTED, ROLLS_180)
