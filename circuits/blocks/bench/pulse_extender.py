"""Pulse extender: an event charges a capacitor, and a small current decides how long the pulse lasts.

    width = C_ext (V_dd - V_end) / I_tau

The first inverter and `m3` charge C_ext to the supply, `m_tau` discharges it. The second inverter stands
under a pFET diode, which lowers where it turns: C_ext falls far before the pulse ends. As its output rises
`m_fb` empties C_ext, so that the end is an edge.

Source: topology, sizes (C_ext is 14 um square, 0.40 pF) and the bias's code are the laboratory's. That `m_fb`
is at the second inverter's output is ours.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from circuits.blocks.bench.bias import MASTERS, coded_bias
from circuits.blocks.block import Values, catalogued, lasting
from circuits.blocks.drive import powered
from circuits.blocks.measure import fall, high_time, rise
from circuits.blocks.mos import mos
from circuits.blocks.ports import SUPPLY, analog_out, biased, event_in
from circuits.blocks.rest import rested
from circuits.blocks.sizes import Sizes, um
from circuits.circuit import Circuit
from circuits.devices import Capacitor
from circuits.event import pulse
from circuits.silicon.process import ROLLS_180
from circuits.solver.transient import Result
from circuits.testbench import Testbench
from circuits.units import quantity

BEGIN = 1e-3  # s, of the event


@dataclass(frozen=True, slots=True)
class Params(Sizes):
    """Capacitor (F) and sizes (um).

    logic: of the inverters and of m3. tau: of m_tau, whose current decides how long a pulse lasts. diode: of
    the pFET diode above the second inverter. feedback: of m_fb, which ends the pulse.
    """

    extender_capacitance: float = quantity(0.40e-12, "F")
    logic_width: float = um(0.5)
    logic_length: float = um(0.5)
    tau_width: float = um(4.0)
    tau_length: float = um(4.0)
    diode_width: float = um(2.0)
    diode_length: float = um(2.0)
    feedback_width: float = um(0.22)
    feedback_length: float = um(2.0)


BIASES = (coded_bias("tau", MASTERS[0], 10, "m_tau", (4.0, 4.0)),)


def build(params: Params = Params()) -> Circuit:
    """The extender: ports event (in), pulse (out), v_tau (bias), the supply; params: capacitor, sizes."""
    logic = params.size("logic")
    devices = (
        mos("m1p", "p", "quiet", "event", "vdd", *logic),
        mos("m1n", "n", "quiet", "event", "0", *logic),
        mos("m3", "p", "v_ext", "quiet", "vdd", *logic),
        Capacitor("c_ext", "v_ext", "0", params.extender_capacitance),
        mos("m_tau", "n", "v_ext", "v_tau", "0", *params.size("tau")),
        mos("m_d", "p", "under", "under", "vdd", *params.size("diode")),
        mos("m2p", "p", "over", "v_ext", "under", *logic),
        mos("m2n", "n", "over", "v_ext", "0", *logic),
        mos("m_fb", "n", "v_ext", "over", "0", *params.size("feedback")),
        mos("m4p", "p", "pulse", "over", "vdd", *logic),
        mos("m4n", "n", "pulse", "over", "0", *logic),
    )
    return biased("bench_pulse_extender", (SUPPLY, *event_in("event"), *analog_out("pulse")), BIASES, devices)


DURATION = 0.15  # s

STIMULI = (lasting(DURATION),)
PLOTTED = ("event", "v_ext", "over", "pulse")


def testbench(circuit: Circuit, stimuli: Values, v_dd: float) -> Testbench:
    """One event at 1 ms."""
    sources = powered(v_dd, {"event": pulse((BEGIN,), v_dd)})
    return rested("pulse extender", circuit, sources, stimuli["duration"] or DURATION, ROLLS_180)


def measures(result: Result) -> dict[str, float | None]:
    """Numbers of a run: `pulse_width_s`, `end_V` and `discharge_V_per_s`.

    end: v_ext where the pulse ends. discharge: its mean fall in the first half of the pulse. None without a
    pulse that ends in the run.
    """
    begin, end = rise(result, "pulse"), fall(result, "pulse")
    if begin is None or end is None:
        return dict.fromkeys(("pulse_width_s", "end_V", "discharge_V_per_s"))
    early, middle = begin + 0.1 * (end - begin), begin + 0.5 * (end - begin)
    levels = np.interp((early, middle, end), result.time, result["v_ext"])
    return {
        "pulse_width_s": high_time(result, "pulse"),
        "end_V": float(levels[2]),
        "discharge_V_per_s": float((levels[0] - levels[1]) / (middle - early)),
    }


def outcome(result: Result) -> str:
    """`pulse` where one begins and ends in the run, `long` where it does not end, else `silent`."""
    if rise(result, "pulse") is None:
        return "silent"
    return "long" if fall(result, "pulse") is None else "pulse"


BLOCK = catalogued("pulse-extender", build, STIMULI, testbench, measures, outcome, PLOTTED, ROLLS_180)
