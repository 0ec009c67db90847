"""Synapse of the NEF chip: a low-pass of first order, and the line that brings its signal to encoders.

A converter, of whose nFETs the block has the one of the middle, draws the current `I_in = I_mid (1 + x)` from
the DPI filter of `circuits.blocks.rolls.dpi_synapse`. With its pair in weak inversion, S being what flows to
the supply over what reaches the capacitor,

    (1 + 1 / S) tau dS/dt = I_in / I_tau - 1 - S,    tau = C_syn U_T / (kappa_n I_tau)
    I_syn = g S^(kappa_p / kappa_n)

S is far above 1, so that the filter is a linear low-pass of first order whose output bends along a fixed
curve, which the neurons' tuning curves take in. The line adds up the outputs of all filters of one signal,
each with its own time constant, in an nFET, and takes the reference I_ref away. What is above the reference
comes through an nFET whose drain makes `v_pos`; what is below it leaves through a pFET and a mirror that make
`v_neg`, so that both begin at the same current. Unity-gain drivers pass both on to the gates of up to
thousands of encoder stages, whose unit copies a sixty-fourth of them.

A filter's time constant is set by I_tau and I_mid together, which keeps S and I_th. Both are small for long
ones, I_th never is: the off current of the pFET that it biases doubles every 10 K, and an I_th near it would
move the middle by a third. So I_mid is 2 nA, fifty times I_tau, and I_th a hundred off currents.

Topology, sizes and numbers are ours: I_mid 2 nA, C_syn 6 pF, 41 pA for 5 ms, I_ref 1.28 nA.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from circuits.blocks.block import Stimulus, Values, catalogued, lasting
from circuits.blocks.drive import current_into, powered, step
from circuits.blocks.measure import between
from circuits.blocks.mos import mos
from circuits.blocks.nef.encoder import UNIT
from circuits.blocks.nef.encoder import Params as EncoderParams
from circuits.blocks.ports import SUPPLY, analog_in, analog_out, bias_in, bias_ports
from circuits.blocks.rest import rested
from circuits.blocks.rolls import dpi_synapse
from circuits.blocks.sizes import Sizes, um
from circuits.circuit import Bias, Circuit
from circuits.devices import Capacitor, OperationalAmplifier, Transistor
from circuits.errors import ParameterError
from circuits.event import rising_crossing
from circuits.silicon.process import ROLLS_180, ROLLS_180_IDEAL, Polarity
from circuits.solver.power import drain_current
from circuits.solver.transient import Result
from circuits.testbench import Testbench
from circuits.units import quantity

MIDDLE = 2e-9  # A
LINE_UNITS = 64.0  # of an encoder stage that the line's own transistor is worth
TAU_CURRENT = 41e-12  # A: 5 ms
REFERENCE = LINE_UNITS * UNIT  # A
GAIN_CURRENT = 46e-12  # A, of I_th: at it the output's middle is the reference
DRIVER_GAIN, DRIVER_RESISTANCE = 1e3, 1e4  # of a line's driver, in Ohm


@dataclass(frozen=True, slots=True)
class Params(Sizes):
    """Capacitors (F) and sizes (um); ours."""

    synapse_capacitance: float = quantity(6e-12, "F")
    tau_width: float = um(0.5)
    tau_length: float = um(16.0)  # so that the slowest filter's current is above the off current
    # square, so that its off current is far below I_th, which would follow temperature otherwise
    output_width: float = um(8.0)
    output_length: float = um(8.0)
    converter_width: float = um(4.0)
    converter_length: float = um(4.0)
    mirror_width: float = um(8.0)
    mirror_length: float = um(4.0)
    split_width: float = um(0.5)
    split_length: float = um(0.5)
    cascode_width: float = um(0.5, least=0.0)  # 0 for a line without cascodes
    cascode_length: float = um(0.5)
    load_capacitance: float = quantity(100e-12, "F")  # F, of the stages' gates on a line; ours


def low_pass(params: Params = Params()) -> Circuit:
    """The filter: ports line (I_in is drawn from it), v_syn, i_out (current out), v_thr, v_tau (biases)."""
    return dpi_synapse.excitatory_filter(
        replace(
            dpi_synapse.Params(),
            synapse_capacitance=params.synapse_capacitance,
            tau_width=params.tau_width,
            tau_length=params.tau_length,
            output_width=params.output_width,
            output_length=params.output_length,
        )
    )


def line(params: Params = Params()) -> Circuit:
    """What adds up filters and splits their sum: ports i_sum (current in), v_pos, v_neg, v_ref, v_split."""
    mirror, split = params.sizes("mirror", "split")
    unit, held = EncoderParams(), params.cascode_width > 0.0
    gates = ("v_cas_n", "v_cas_p") if held else ()

    def diode(name: str, node: str) -> Transistor:
        one = mos(name, "p", node, node, "vdd", *unit.size("unit"))
        return replace(one, multiplicity=LINE_UNITS)

    def driver(name: str, node: str, out: str) -> OperationalAmplifier:
        return OperationalAmplifier(name, node, out, out, "vdd", "0", DRIVER_GAIN, DRIVER_RESISTANCE, 0.0)

    def copy(name: str, polarity: Polarity, gate: str, out: str) -> tuple[Transistor, ...]:
        """What a mirror gives, through its cascode if there is one."""
        rail = "0" if polarity == "n" else "vdd"
        if not held:
            return (mos(name, polarity, out, gate, rail, *mirror),)
        size = params.size("cascode")
        cascode = mos(f"{name}c", polarity, out, f"v_cas_{polarity}", f"{name}d", *size)
        return (mos(name, polarity, f"{name}d", gate, rail, *mirror), cascode)

    return Circuit(
        "nef_line",
        (SUPPLY, *analog_in("i_sum"), *analog_out("v_pos", "v_neg"), *bias_in("v_ref", "v_split", *gates)),
        (
            mos("ml1", "n", "i_sum", "i_sum", "0", *mirror),
            *copy("ml2", "n", "i_sum", "difference"),
            *copy("mr1", "p", "v_ref", "difference"),
            mos("mw1", "n", "above", "v_split", "difference", *split),
            mos("mw2", "p", "under", "v_split", "difference", *split),
            mos("mr2", "n", "under", "under", "0", *mirror),
            *copy("mr3", "n", "under", "below"),
            diode("mu1", "above"),
            diode("mu2", "below"),
            driver("u1", "above", "v_pos"),
            driver("u2", "below", "v_neg"),
            Capacitor("c_pos", "v_pos", "0", params.load_capacitance),
            Capacitor("c_neg", "v_neg", "0", params.load_capacitance),
        ),
    )


CASCODES = (  # V: the drains of the mirrors are then 0.3 V from their rails, as their diodes' are
    Bias("v_cas_n", "v_cas_n", "voltage", 0.7),
    Bias("v_cas_p", "v_cas_p", "voltage", 1.1),
)
BIASES = (
    Bias("i_mid", "v_mid", "gate", MIDDLE, "mv1"),
    Bias("i_tau", "v_tau", "gate", TAU_CURRENT, "filter.md3"),
    Bias("i_thr", "v_thr", "gate", GAIN_CURRENT, "filter.md4"),
    Bias("i_ref", "v_ref", "gate", REFERENCE, "line.mr1"),
    Bias("v_split", "v_split", "voltage", 0.9),  # V, half the supply
    *CASCODES,
)


def build(params: Params = Params()) -> Circuit:
    """Filter, converter and line: ports i_in (drawn beside the middle), v_pos, v_neg, biases, the supply."""
    biases = tuple(b for b in BIASES if params.cascode_width > 0.0 or b not in CASCODES)
    ports = (SUPPLY, *analog_in("i_in"), *analog_out("v_pos", "v_neg"), *bias_ports(biases))
    parts = (
        low_pass(params).instance("filter", line="i_in", i_out="i_sum"),
        line(params).instance("line"),
    )
    middle = mos("mv1", "n", "i_in", "v_mid", "0", *params.size("converter"))
    return Circuit("nef_synapse", ports, (middle,), parts, biases=biases)


STEP_TIME = 1e-3  # s
_SETTLED = 12.0  # time constants of the longest step response that is awaited, at 5 ms each

STIMULI = (
    Stimulus("step", "", 0.5, "x from 1 ms on, above -1"),
    lasting(30e-3),
)
PLOTTED = ("v_syn", "i_sum", "v_pos", "v_neg")


def testbench(circuit: Circuit, stimuli: Values, v_dd: float) -> Testbench:
    """The converter at its middle, and x = `step` from 1 ms on.

    Raises `ParameterError` for a step of -1 or below, where no current is left.
    """
    x = stimuli["step"] or 0.0
    if x <= -1.0:
        raise ParameterError(f"step: {x:g}, must be above -1, where no current is left")
    drawn = step(STEP_TIME, STEP_TIME + 1e-6, 0.0, -x * MIDDLE)
    sources = (*powered(v_dd), current_into("i_in", drawn))
    stop = stimuli["duration"] or STEP_TIME + _SETTLED * 5e-3
    return rested("NEF synapse", circuit, sources, stop, ROLLS_180_IDEAL)


def measures(result: Result) -> dict[str, float | None]:
    """Numbers of a run: `time_constant_s`, `middle_A`, `current_A` and `signal_A`.

    middle, current: of the filter's output, before the step and at the end. signal: what is left of it above
    the reference, or missing (negative). The time constant is when S, which is the current to the power of
    kappa_n / kappa_p, has made 1 - 1 / e of its step; None without a step.
    """
    current = np.abs(drain_current(result, "line.ml2"))
    process = result.machine.silicon.process
    linear = current ** (process.n.kappa / process.p.kappa)
    begin, end = float(np.interp(0.99 * STEP_TIME, result.time, linear)), float(linear[-1])
    if abs(end / begin - 1.0) < 1e-3:
        reached = None
    else:
        reached = rising_crossing(result.time, (linear - begin) / (end - begin), 1.0 - float(np.exp(-1.0)))
    return {
        "time_constant_s": between(STEP_TIME, reached),
        "middle_A": float(np.interp(0.99 * STEP_TIME, result.time, current)),
        "current_A": float(current[-1]),
        "signal_A": float(np.abs(drain_current(result, "line.mu1")[-1]))
        - float(np.abs(drain_current(result, "line.mu2")[-1])),
    }


def outcome(result: Result) -> str:
    """`up`, `down` or `still`: how the output has moved."""
    found = measures(result)
    ratio = (found["current_A"] or 0.0) / (found["middle_A"] or 1.0)
    if abs(ratio - 1.0) < 1e-3:
        return "still"
    return "up" if ratio > 1.0 else "down"


BLOCK = catalogued("nef-synapse", build, STIMULI, testbench, measures, outcome, PLOTTED, ROLLS_180)
