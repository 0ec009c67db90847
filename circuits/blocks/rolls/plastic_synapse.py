"""Plastic synapse of the ROLLS chip's kind: a bistable weight that spikes move up and down.

* weight: `w` is the voltage of a capacitor. A presynaptic pulse of length t moves it up by `I_up t / C_w`
  while `up_b` is low, and down by `I_dn t / C_w` while `dn` is high. Both lines come from the learning
  circuit
  of the neuron (`circuits.blocks.rolls.calcium_gate`).
* bistability: a comparator of two stages compares w with v_wthr. The first is a pair of nFETs with a mirror
  and the tail I_cmp, whose output c gets no lower than the tail. The second is a pFET at c against I_cmp,
  whose
  output `low` is at ground where w is above the threshold, and at the supply where it is below. `low` is the
  gate of a starved inverter that drives w itself: `dw/dt = I_driftup / C_w` above the threshold and
  `-I_driftdn / C_w` below it, until w is at the rail.
* efficacy: the weight is binary. During a pulse `I_w` is drawn from the line while w is above its threshold.
  Between pulses the far node of the switch to the line is held at v_shift, as in the non-plastic synapse.

No gate that conducts by itself hangs on c or `low`, which pass slowly from rail to rail: at rest, and while
they do, a weight takes little more than I_cmp from the supply. An inverter at c would conduct microamperes.
The stacks that move w have their switches at the rails and the bias devices at w, so that less of a switch's
charge gets there. The switches are long, or their off currents would be as large as the drift.

Found are the form of the rule (learning "fusi" of teili, after Brader, Senn, Fusi 2007) and the names of the
biases (control software of ROLLS: PA_DELTAUP, PA_DELTADN, PA_WDRIFTUP, PA_WDRIFTDN, PA_WDRIFT, PA_WTHR,
PA_WHIDN, PA_PWLK). Topology, sizes, capacitor and what each bias does are ours. So are the currents, since
the default file of the software has the learning switched off (PA_DELTAUP and PA_DELTADN of fine code 0).
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from circuits.blocks.block import DURATION, Stimulus, Values, catalogued
from circuits.blocks.drive import powered, train
from circuits.blocks.mos import current_mirror, inverter, mos, nor
from circuits.blocks.ports import SUPPLY, analog_in, analog_out, bias_ports, biased, event_in
from circuits.blocks.rest import started_at_rest
from circuits.blocks.rolls.bias import gate_bias
from circuits.blocks.rolls.dpi_synapse import Params as SynapseParams
from circuits.blocks.rolls.dpi_synapse import pulse_extender
from circuits.blocks.sizes import Sizes, um
from circuits.circuit import Bias, Circuit
from circuits.devices import Capacitor, Source
from circuits.devices.device import Device
from circuits.devices.source import Constant
from circuits.errors import ParameterError
from circuits.event import pulse
from circuits.lowering.supply import half_supply
from circuits.silicon.process import ROLLS_180, ROLLS_180_IDEAL
from circuits.solver.power import drain_current
from circuits.solver.transient import Result
from circuits.testbench import Testbench
from circuits.units import quantity

# ours: 0.16 V a pulse of 23 us; 3.4 and 4 V/s of drift; the software's WDRIFT for the comparator
UP, DOWN, DRIFT_UP, DRIFT_DOWN = (4, 30), (4, 30), (7, 7), (7, 8)
THRESHOLD = 0.9  # V; ours: the middle of the supply
SHIFT = 0.25  # V, as the non-plastic synapse's


@dataclass(frozen=True, slots=True)
class Params(Sizes):
    """Capacitor (F), sizes (um), and the synapse whose pulse extender it shares; ours."""

    weight_capacitance: float = quantity(0.1e-12, "F")
    move_width: float = um(0.25)  # of the devices whose current moves w
    move_length: float = um(2.0)
    switch_length: float = um(4.0)  # long, for an off current below a tenth of the drift's
    pair_width: float = um(1.0)
    pair_length: float = um(1.0)
    # small, since I_cmp charges its gate; twice the W/L of the pair's mirror
    second_width: float = um(1.0)
    second_length: float = um(0.5)
    tail_width: float = um(0.5)  # of both currents I_cmp
    tail_length: float = um(4.0)
    synapse: SynapseParams = field(default_factory=SynapseParams)


def cell(params: Params) -> Circuit:
    """The weight: ports pulse, up_b, dn (in), line (it draws from it), w, low (out), biases.

    low: the weight's bit, inverted.
    """
    size = {"width": params.synapse.logic_width, "length": params.synapse.logic_length}
    move = params.size("move")
    switch = params.move_width, params.switch_length
    devices = (
        Capacitor("c_w", "w", "0", params.weight_capacitance),
        *inverter("mq1", "pulse", "pulse_b", **size),
        mos("mu1", "p", "u1", "pulse_b", "vdd", *switch),
        mos("mu2", "p", "u2", "up_b", "u1", *switch),
        mos("mu3", "p", "w", "v_up", "u2", *move),
        mos("md1", "n", "d1", "pulse", "0", *switch),
        mos("md2", "n", "d2", "dn", "d1", *switch),
        mos("md3", "n", "w", "v_dn", "d2", *move),
        *_comparator(params),
        # the starved inverter that drives w to its rail
        mos("mr1", "p", "r1", "low", "vdd", *switch),
        mos("mr2", "p", "w", "v_driftup", "r1", *move),
        mos("mr3", "n", "r3", "low", "0", *switch),
        mos("mr4", "n", "w", "v_driftdn", "r3", *move),
        *nor("mq2", ("pulse_b", "low"), "on", **size),
        *inverter("mq3", "on", "off", **size),
        mos("mw1", "n", "line", "on", "wx", 0.5, params.synapse.logic_length),
        mos("mw3", "n", "wx", "on", "ws", 0.5, params.synapse.logic_length),
        mos("mw4", "n", "wx", "off", "v_shift", 0.5, params.synapse.logic_length),
        mos("mw2", "n", "ws", "v_weight", "0", params.synapse.weight_width, params.synapse.weight_length),
    )
    biases = bias_ports(b for b in BIASES if b.port != "v_pwlk")
    ports = (SUPPLY, *analog_in("pulse", "up_b", "dn"), *analog_out("line", "w", "low"), *biases)
    return Circuit("plastic_cell", ports, devices)


def _comparator(params: Params) -> tuple[Device, ...]:
    """`c` is high where w is above v_wthr, `low` where it is below."""
    pair, tail = params.sizes("pair", "tail")
    return (
        mos("mb1", "n", "tail", "v_cmp", "0", *tail),
        mos("mb2", "n", "b", "w", "tail", *pair),
        mos("mb3", "n", "c", "v_wthr", "tail", *pair),
        *current_mirror("mb4", "mb5", "p", "b", "c", pair),
        # mb5 has half of I_cmp in balance and mb6 all of it: of twice the W/L, both stages turn at once
        mos("mb6", "p", "low", "c", "vdd", *params.size("second")),
        mos("mb7", "n", "low", "v_cmp", "0", *tail),
    )


BIASES = (
    gate_bias("pwlk", (3, 53), "extender.mp2"),  # PA_PWLK_P
    gate_bias("up", UP, "cell.mu3"),
    gate_bias("dn", DOWN, "cell.md3"),
    gate_bias("driftup", DRIFT_UP, "cell.mr2"),
    gate_bias("driftdn", DRIFT_DOWN, "cell.mr4"),
    gate_bias("cmp", (6, 99), "cell.mb1"),  # PA_WDRIFT_P
    gate_bias("weight", "NPA_WEIGHT_EXC_P", "cell.mw2"),
    Bias("v_wthr", "v_wthr", "voltage", THRESHOLD),
    Bias("v_shift", "v_shift", "voltage", SHIFT),
)


def build(params: Params = Params()) -> Circuit:
    """The synapse: ports event, up_b, dn (in), line, w, low (out), biases and the supply."""
    instances = (pulse_extender(params.synapse).instance("extender"), cell(params).instance("cell"))
    inputs = (*event_in("event"), *analog_in("up_b", "dn"))
    ports = (SUPPLY, *inputs, *analog_out("line", "w", "low"))
    return biased("plastic_synapse", ports, BIASES, (), instances)


FIRST = 1e-3  # s, of the first event; ours
LINE = 0.9  # V, ours: ideal voltage of the line
AFTER = 4e-3  # s, ours: of the run, after the last event

STIMULI = (
    Stimulus("up", "", 1.0, "1: events move the weight up, -1: down, 0: not", can_be_off=True),
    Stimulus("events", "", 5.0, "how many events"),
    Stimulus("rate", "Hz", 200.0, "of the events"),
    DURATION,
)
PLOTTED = ("event", "w", "cell.c", "low")


def testbench(circuit: Circuit, stimuli: Values, v_dd: float) -> Testbench:
    """`events` events at `rate` (Hz) from 1 ms on, which move w up (1), down (-1) or not (0), from a rail."""
    up, count, rate = (float(stimuli[name] or 0.0) for name in ("up", "events", "rate"))
    if up not in (-1.0, 0.0, 1.0):
        raise ParameterError(f"up: {up:g}, must be 1, 0 or -1")
    times = train("events", count, rate, FIRST)
    lines = {"up_b": 0.0 if up > 0 else v_dd, "dn": v_dd if up < 0 else 0.0, "line": LINE}
    sources = powered(v_dd, {"event": pulse(times, v_dd), **lines})
    bench = Testbench("plastic synapse", circuit, sources, stimuli["duration"] or times[-1] + AFTER)
    rail = Source("hold", "w", Constant(v_dd if up < 0 else 0.0))
    return started_at_rest(bench, ROLLS_180_IDEAL, (rail,))


def measures(result: Result) -> dict[str, float | None]:
    """Numbers of a run: `jump_V`, `drift_V_per_s`, `weight_V` at the end and `charge_C`.

    jump: that of the first event. drift: mean slope over the last 2 ms of the run. charge: drawn from the
    line in the whole run.
    """
    w, t = result["w"], result.time
    before, after = (float(x) for x in (w[t < FIRST][-1], w[t < FIRST + 0.1e-3][-1]))
    late = t > t[-1] - 2e-3
    current = drain_current(result, "cell.mw1")
    return {
        "jump_V": after - before,
        "drift_V_per_s": float((w[late][-1] - w[late][0]) / (t[late][-1] - t[late][0])),
        "weight_V": float(w[-1]),
        "charge_C": float(np.trapezoid(current, t)),
    }


def outcome(result: Result) -> str:
    """`high` or `low`: the weight at the end."""
    return "low" if result["low"][-1] > half_supply(result.machine) else "high"


BLOCK = catalogued("plastic-synapse", build, STIMULI, testbench, measures, outcome, PLOTTED, ROLLS_180)
