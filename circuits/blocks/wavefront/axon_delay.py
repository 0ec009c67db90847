"""Axonal delay element: its output follows the firing of a cell after a delay proportional to a code.

The code is from 1 to 31. While `fired` is low, `mr` holds the ramp at the supply. Once it is high, the
starved sink `ms` discharges what hangs on the ramp, until the ramp passes v_ref and the comparator steps
`delayed`:

    D = [(C_0 + C_o + w) (V_dd - v_ref) - C_o V_dd] / I + t_c,      w = code C_u

A converter that splits currents would give a delay of 1/code. Switched capacitors make the delay affine in
the code, because charge is linear in the capacitance. Bit k ties its capacitor C_k to the supply by the pFET
`mb`. While the bit is off, that plate follows the ramp on the parasitic C_p of its switches, so that the bit
adds `C_k^2 / (C_k + C_p)`; C_k is chosen so that this is 2^k C_u. The switches are pFETs, because an nFET to
ground would leak 10^4 times more at these thresholds, and would be turned on by a plate that a falling ramp
pulls below ground. At rest `mp` holds the plates at the supply, whatever the bits were.

C_o takes a fixed charge off the ramp as the cell fires, after `mr` has let go. It cancels the delay of the
parasitics C_0 and of the comparator, so that the delay is proportional to the code, within 1.2 us on the
nominal die at 27 degC. The share of the parasitics scales with 1/I and cancels at every current; that of the
comparator does not: the offset is 1 us at a unit of 10 us, and -2.8 % of a unit at 1 ms. The integral
non-linearity, the largest distance from the best line over the 31 codes, is 0.037 % of full scale (0.032 to
0.043 % from -10 to 65 degC). It comes from the delay of the comparator, which depends on the slope of the
ramp, and from the edge that releases floating plates.

The element is ready again 2 us after the reset, a fiftieth of a unit. The bits are read while it runs.

Source: a delay that follows a cost, Hwu et al. 2018, equations (4) and (5). The circuit and all numbers are
ours. Capacitors deviate on dies of `--variation full` alone.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from circuits.blocks.block import DURATION, Stimulus, Values, catalogued
from circuits.blocks.drive import elements, powered
from circuits.blocks.latency.synapse import comparator_stages
from circuits.blocks.measure import between, fall, rise, spiking
from circuits.blocks.mos import UM, inverter, mos
from circuits.blocks.ports import SUPPLY, biased, event_in, event_out
from circuits.blocks.sizes import Sizes
from circuits.circuit import Bias, Circuit, Port
from circuits.devices import Capacitor, Device, Transistor
from circuits.devices.source import PiecewiseLinear
from circuits.errors import ParameterError
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.solver.transient import Result
from circuits.testbench import Testbench
from circuits.units import quantity

BITS = 5
HIGHEST = (1 << BITS) - 1  # code; 0 is a blocked cell
UNIT = 100e-6  # s a unit of the code, nominal, 27 degC
REFERENCE = 2.0  # V
SWITCH = (3.0, 1.5)  # um, of every bit, and of its reset


@dataclass(frozen=True, slots=True)
class Params(Sizes):
    """Capacitors (F) and size of the sink (m); ours."""

    unit_capacitance: float = quantity(100e-15, "F")  # C_u
    offset_capacitance: float = quantity(157e-15, "F")  # C_o
    sink_width: float = quantity(12e-6, "m")
    sink_length: float = quantity(12e-6, "m")


BIASES = (
    Bias("i_delay", "v_delay", "gate", 3.0046e-9, "ms"),  # ours: 100 us a unit
    Bias("i_cmp", "v_cmp", "gate", 100e-9, "mc0"),
    Bias("v_ref", "v_ref", "voltage", REFERENCE),
)


def bit_capacitance(weight: float) -> float:
    """C_k (F) of a bit that adds `weight` F to the ramp, from `weight = C_k^2 / (C_k + C_p)`."""
    parasitic = parasitic_capacitance()
    return 0.5 * (weight + math.sqrt(weight**2 + 4.0 * weight * parasitic))


def parasitic_capacitance() -> float:
    """C_p (F): of both switches on the plate of a bit that is off."""
    model = AMI_1500_IDEAL.p
    return 2.0 * (model.overlap_capacitance + model.junction_capacitance) * SWITCH[0] * UM


def code_voltages(code: float, v_dd: float) -> tuple[float, ...]:
    """Voltages of v_code for a code, float[5], V, the least bit first.

    Raises `ParameterError` for a code that is no whole number from 0 to 31.
    """
    if code != int(code) or not 0 <= code <= HIGHEST:
        raise ParameterError(f"code: {code:g}, must be a whole number from 0 to {HIGHEST}")
    return tuple(v_dd if int(code) >> k & 1 else 0.0 for k in range(BITS))


def build(params: Params = Params()) -> Circuit:
    """The element: ports fired (event in), delayed (event out), v_code[5], biases and the supply.

    v_code takes the bits of the code, the least first, as levels of the supply from the memory that holds the
    map; no bias sets it.
    """
    code = Port("v_code", "bias", "in", (BITS,))
    ports = (SUPPLY, *event_in("fired"), *event_out("delayed"), code)
    return biased("axon_delay", ports, BIASES, (*_ramp(params), *_comparator()))


def _ramp(params: Params) -> tuple[Device, ...]:
    """Reset, sink, capacitors with their switches, and the fixed charge."""
    devices: list[Device] = [
        *inverter("mf", "fired", "fired_n", width=3.0, length=1.5),
        *inverter("mh", "fired_n", "hold", width=3.0, length=1.5),
        mos("mr", "p", "ramp", "hold", "vdd", 3, 1.5),
        Transistor("ms", "n", "ramp", "v_delay", "0", "0", *params.size("sink")),
        mos("mdp", "p", "step", "hold", "vdd", 6, 1.5),
        mos("mdn", "n", "step", "hold", "0", 3, 12),
        Capacitor("c_o", "step", "ramp", params.offset_capacitance),
    ]
    for k in range(BITS):
        devices += inverter(f"mi{k}", f"v_code[{k}]", f"off{k}", width=3.0, length=1.5)
        devices.append(mos(f"mb{k}", "p", f"plate{k}", f"off{k}", "vdd", *SWITCH))
        devices.append(mos(f"mp{k}", "p", f"plate{k}", "hold", "vdd", *SWITCH))
        weight = 2**k * params.unit_capacitance
        devices.append(Capacitor(f"c{k}", "ramp", f"plate{k}", bit_capacitance(weight)))
    return tuple(devices)


def _comparator() -> tuple[Device, ...]:
    """Differential pair, a second stage that is balanced with it, and two inverters."""
    return (
        *comparator_stages("ramp", 12),
        *inverter("mo", "y", "z", width=3.0, length=1.5),
        *inverter("mq", "z", "delayed", width=3.0, length=1.5),
    )


FIRE_TIME = 20e-6  # s, ours: when the testbench's cell fires
EDGE = 0.1e-6  # s

STIMULI = (
    Stimulus("code", "", 7.0, "cost code, 0 to 31"),
    DURATION,
)
PLOTTED = ("fired", "ramp", "x", "y", "delayed")


def testbench(circuit: Circuit, stimuli: Values, v_dd: float) -> Testbench:
    """`fired` rises at 20 us, and falls for the last tenth of a run of twice the nominal delay.

    `duration` is another length of the run, s.
    """
    code = stimuli["code"] or 0.0
    bits = code_voltages(code, v_dd)
    stop = stimuli["duration"] or FIRE_TIME + 2.0 * (code + 1.0) * UNIT
    reset = FIRE_TIME + 0.9 * (stop - FIRE_TIME)
    edges = (0.0, FIRE_TIME, FIRE_TIME + EDGE, reset, reset + EDGE)
    fired = PiecewiseLinear(edges, (0.0, 0.0, v_dd, v_dd, 0.0))
    sources = powered(v_dd, {"fired": fired, **elements(circuit.port("v_code"), dict(enumerate(bits)))})
    return Testbench("axon delay", circuit, sources, stop, watch=("delayed",))


def measures(result: Result) -> dict[str, float | None]:
    """Numbers of a run: `delay_s` and `recovery_s`.

    delay: from half the supply at `fired` to half at `delayed`. recovery: likewise back, after the reset.
    None where there is no such edge in the run.
    """
    return {
        "delay_s": between(rise(result, "fired"), rise(result, "delayed")),
        "recovery_s": between(fall(result, "fired"), fall(result, "delayed")),
    }


outcome = spiking("delayed", "none", "delayed")

BLOCK = catalogued("axon-delay", build, STIMULI, testbench, measures, outcome, PLOTTED)
