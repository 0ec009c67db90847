"""Learning circuit of a neuron: it tells plastic synapses whether they may go up, or down, or neither.

* calcium: each spike of the neuron, made longer by a pulse extender, adds to the current I_ca of a DPI filter
  with a time constant of its own (`circuits.blocks.rolls.dpi_synapse`). Between pulses the far node of the
  switch to the line is held at v_shift, or it would leak more than I_tau.
* thresholds: I_ca is copied three times, each time against the current of a threshold; the node between them
  is high where I_ca is the larger one. A fourth copy, to ground, is the monitor.
* membrane: a comparator, a pair of nFETs with a mirror, compares v_mem with v_memthr.
* logic makes the two lines of the neuron's row of plastic synapses:

    up = (v_mem > v_memthr) and I_thmin < I_ca < I_thup
    dn = (v_mem < v_memthr) and I_thmin < I_ca < I_thdn

Found are the rule (learning "fusi" of teili, after Brader, Senn, Fusi 2007, which has two lower thresholds)
and the names of the biases (control software of ROLLS: SL_CAW, SL_CATAU, SL_CATHR, SL_THMIN, SL_THUP,
SL_THDN, SL_MEMTHR, SL_WTA). One lower threshold for both directions follows these names. Topology, sizes and
currents are ours.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from circuits.blocks.block import DURATION, Stimulus, Values, catalogued
from circuits.blocks.drive import powered, train
from circuits.blocks.mos import current_mirror, inverter, mos, nand
from circuits.blocks.ports import SUPPLY, analog_in, analog_out, bias_ports, biased, event_in
from circuits.blocks.rest import rested
from circuits.blocks.rolls.bias import gate_bias
from circuits.blocks.rolls.dpi_synapse import Params as SynapseParams
from circuits.blocks.rolls.dpi_synapse import pulse_extender
from circuits.blocks.sizes import Sizes, um
from circuits.circuit import Bias, Circuit
from circuits.devices import Capacitor
from circuits.devices.device import Device
from circuits.event import pulse
from circuits.lowering.supply import half_supply
from circuits.silicon.process import ROLLS_180, ROLLS_180_IDEAL
from circuits.solver.power import drain_current
from circuits.solver.transient import Result
from circuits.testbench import Testbench

# Coarse and fine codes, ours: 0.1 s of calcium, thresholds of 16, 66 and 192 pA
TAU, GAIN, STEP = (7, 10), (7, 20), (3, 100)
LEAST, MOST_DOWN, MOST_UP = (6, 40), (6, 160), (5, 60)
MEMBRANE_THRESHOLD = 0.3  # V; ours
SHIFT = 0.25  # V, as the non-plastic synapse's
THRESHOLDS = ("thmin", "thdn", "thup")


@dataclass(frozen=True, slots=True)
class Params(Sizes):
    """Sizes (um) of copies, thresholds and comparator, and the sizes of the filter; ours.

    copy: of the pFETs that copy I_ca, and of the nFETs that carry the thresholds' currents against them.
    pair: of the pair that compares v_mem with v_memthr, and of its mirror. synapse: of the pulse extender,
    the filter of calcium and the logic, as of the non-plastic synapse.
    """

    copy_width: float = um(1.0)
    copy_length: float = um(4.0)
    pair_width: float = um(1.0)
    pair_length: float = um(1.0)
    synapse: SynapseParams = field(default_factory=SynapseParams)


def gate(params: Params) -> Circuit:
    """The circuit behind the extender: ports pulse, v_mem (in), up_b (low is on), dn (out), biases."""
    biases = bias_ports(b for b in BIASES if b.port != "v_pwlk")
    ports = (SUPPLY, *analog_in("pulse", "v_mem"), *analog_out("up_b", "dn"), *biases)
    return Circuit("learning_gate", ports, (*_calcium(params), *_comparators(params), *_logic(params)))


def _calcium(params: Params) -> tuple[Device, ...]:
    s = params.synapse
    pair = s.size("pair")
    return (
        Capacitor("c_line", "line", "0", s.line_capacitance),
        Capacitor("c_ca", "vdd", "v_ca", s.synapse_capacitance),
        *inverter("mc0", "pulse", "pulse_b", width=s.logic_width, length=s.logic_length),
        mos("mc1", "n", "line", "pulse", "far", 0.5, s.logic_length),
        mos("mc3", "n", "far", "pulse", "step", 0.5, s.logic_length),
        mos("mc4", "n", "far", "pulse_b", "v_shift", 0.5, s.logic_length),
        mos("mc2", "n", "step", "v_caw", "0", *s.size("weight")),
        mos("md1", "n", "vdd", "v_cathr", "line", *pair),
        mos("md2", "n", "v_ca", "v_ca", "line", *pair),
        mos("md3", "p", "v_ca", "v_catau", "vdd", *s.size("tau")),
        mos("md4", "p", "0", "v_cathr", "vdd", *s.size("output")),
    )


def _comparators(params: Params) -> tuple[Device, ...]:
    copy, pair = params.sizes("copy", "pair")
    against = [
        device
        for name in THRESHOLDS
        for device in (
            mos(f"mk_{name}", "p", f"over_{name}", "v_ca", "vdd", *copy),
            mos(f"ms_{name}", "n", f"over_{name}", f"v_{name}", "0", *copy),
        )
    ]
    return (
        *against,
        mos("mk_mon", "p", "0", "v_ca", "vdd", *copy),
        # `m` is low where v_mem is above v_memthr
        mos("mm1", "n", "tail", "v_mcmp", "0", 0.5, 4.0),
        mos("mm2", "n", "m", "v_mem", "tail", *pair),
        mos("mm3", "n", "n", "v_memthr", "tail", *pair),
        *current_mirror("mm4", "mm5", "p", "n", "m", pair),
    )


def _logic(params: Params) -> tuple[Device, ...]:
    size = {"width": params.synapse.logic_width, "length": params.synapse.logic_length}
    return (
        *inverter("mq1", "m", "above", **size),
        *inverter("mq2", "above", "below", **size),
        *inverter("mq3", "over_thmin", "less", **size),
        *inverter("mq4", "less", "enough", **size),
        *inverter("mq5", "over_thup", "up_allowed", **size),
        *inverter("mq6", "over_thdn", "dn_allowed", **size),
        *nand("mq7", ("above", "enough", "up_allowed"), "up_b", **size),
        *nand("mq8", ("below", "enough", "dn_allowed"), "dn_b", **size),
        *inverter("mq9", "dn_b", "dn", **size),
    )


BIASES = (
    gate_bias("pwlk", (3, 53), "extender.mp2"),
    gate_bias("caw", STEP, "gate.mc2"),
    gate_bias("catau", TAU, "gate.md3"),
    gate_bias("cathr", GAIN, "gate.md4"),
    gate_bias("thmin", LEAST, "gate.ms_thmin"),
    gate_bias("thdn", MOST_DOWN, "gate.ms_thdn"),
    gate_bias("thup", MOST_UP, "gate.ms_thup"),
    gate_bias("mcmp", (4, 40), "gate.mm1"),
    Bias("v_memthr", "v_memthr", "voltage", MEMBRANE_THRESHOLD),
    Bias("v_shift", "v_shift", "voltage", SHIFT),
)


def build(params: Params = Params()) -> Circuit:
    """The learning circuit: ports event, v_mem (in), up_b (low is on), dn (out), biases and the supply."""
    instances = (pulse_extender(params.synapse).instance("extender"), gate(params).instance("gate"))
    inputs = (*event_in("event"), *analog_in("v_mem"))
    ports = (SUPPLY, *inputs, *analog_out("up_b", "dn"))
    return biased("calcium_gate", ports, BIASES, (), instances)


FIRST = 1e-3  # s, of the first spike; ours
AFTER = 0.25  # s, ours: of the run, after the last spike

STIMULI = (
    Stimulus("spikes", "", 6.0, "spikes of the neuron"),
    Stimulus("rate", "Hz", 100.0, "of the spikes"),
    Stimulus("membrane", "V", 0.5, "v_mem", can_be_off=True),
    DURATION,
)
PLOTTED = ("event", "gate.v_ca", "up_b", "dn")


def testbench(circuit: Circuit, stimuli: Values, v_dd: float) -> Testbench:
    """`spikes` spikes at `rate` (Hz) from 1 ms on, with the membrane at an ideal voltage."""
    count, rate = (float(stimuli[name] or 0.0) for name in ("spikes", "rate"))
    times = train("spikes", count, rate, FIRST)
    sources = powered(v_dd, {"event": pulse(times, v_dd), "v_mem": stimuli["membrane"] or 0.0})
    return rested("calcium gate", circuit, sources, stimuli["duration"] or times[-1] + AFTER, ROLLS_180_IDEAL)


def measures(result: Result) -> dict[str, float | None]:
    """Numbers of a run: `calcium_A` at its peak, `decay_s`, `up_s` and `dn_s`.

    decay: the time from half to a fifth of the last peak, over ln 2.5. up, dn: how long each line was active.
    """
    half = half_supply(result.machine)
    t, current = result.time, np.abs(drain_current(result, "gate.mk_mon"))
    return {
        "calcium_A": float(current.max()),
        "decay_s": _decay(t, current),
        "up_s": _time_of(t, result["up_b"] < half),
        "dn_s": _time_of(t, result["dn"] > half),
    }


def _time_of(t: np.ndarray, active: np.ndarray) -> float:
    return float(np.diff(t)[active[1:]].sum())


def _decay(t: np.ndarray, current: np.ndarray) -> float | None:
    peak = int(current.argmax())
    after, later = current[peak:], t[peak:]
    times = []
    for share in (0.5, 0.2):
        below = np.flatnonzero(after < share * after[0])
        if not below.size:
            return None
        times.append(float(later[below[0]]))
    return (times[1] - times[0]) / float(np.log(2.5))


def outcome(result: Result) -> str:
    """`up`, `dn`, `both` (one after the other) or `neither`."""
    found = measures(result)
    up, dn = bool(found["up_s"]), bool(found["dn_s"])
    return {(True, True): "both", (True, False): "up", (False, True): "dn"}.get((up, dn), "neither")


BLOCK = catalogued("calcium-gate", build, STIMULI, testbench, measures, outcome, PLOTTED, ROLLS_180)
