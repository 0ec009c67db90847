"""Pixel of an event camera: a photoreceptor, an amplifier of changes since a reset, and two comparators.

The photoreceptor's voltage goes through C_1 to the amplifier's input, C_2 leads back from its output: v_diff
moves by -C_1 / C_2 times a change. A reset joins input and output, where the amplifier's pFET carries I_diff.
The comparators are copies of the amplifier with other currents: `on` rises where that pFET would carry I_on,
`off` falls where it would carry less than I_off. With the change of the light in e-folds,

    theta_on = (C_2 / C_1) (kappa_n / kappa_p^2) ln(I_on / I_diff),    theta_off with I_off, below 0

kappa_n is the photoreceptor's; kappa_p is the follower's and the amplifier's. The switch that is off leaks,
so that without a reset the pixel comes to an event by itself.

Source: topology and sizes after the chip's figure (C_1 22 um and C_2 5 um square, a ratio of 19.4; pFETs 3.4
um by 1 um over nFETs 2 um square). The reset is the testbench's, and its switch and the biases are ours;
there is no measurement. P. Lichtsteiner, C. Posch, T. Delbruck, "A 128x128 120 dB 15 us latency asynchronous
temporal contrast vision sensor" (2008), has the circuit.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from circuits.blocks.bench import photoreceptor
from circuits.blocks.bench.bias import MASTERS, coded_bias
from circuits.blocks.bench.curve import slope
from circuits.blocks.block import Stimulus, Values, catalogued, lasting
from circuits.blocks.drive import current_into, powered
from circuits.blocks.mos import mos
from circuits.blocks.ports import SUPPLY, analog_in, biased, event_out
from circuits.blocks.rest import rested
from circuits.blocks.sizes import Sizes, um
from circuits.circuit import Circuit
from circuits.devices import Capacitor
from circuits.devices.source import PiecewiseLinear
from circuits.event import falling_crossing, rising_crossing
from circuits.lowering.supply import half_supply
from circuits.silicon.process import ROLLS_180
from circuits.solver.transient import Result
from circuits.testbench import Testbench
from circuits.units import quantity

RESET_S, EDGE = 5e-3, 1e-6  # s, of a reset, and of its edges; ours
POINTS = 120  # of a change of light


@dataclass(frozen=True, slots=True)
class Params(Sizes):
    """Capacitors (F) and sizes (um).

    The input's capacitor is C_1, the feedback's C_2. p, n: of the amplifier of changes, and of the
    comparators, which are its copies. switch: of the pFET that resets it. The photoreceptor has sizes of its
    own.
    """

    photodiode_capacitance: float = quantity(0.1e-12, "F")
    input_capacitance: float = quantity(0.98e-12, "F")
    feedback_capacitance: float = quantity(50.6e-15, "F")
    p_width: float = um(3.4)
    p_length: float = um(1.0)
    n_width: float = um(2.0)
    n_length: float = um(2.0)
    switch_width: float = um(0.5)
    switch_length: float = um(0.5)


SQUARE = (2.0, 2.0)
BIASES = (
    coded_bias("prb", MASTERS[2], 100, "receptor.m_pr", (3.4, 1.0)),
    coded_bias("sfb", MASTERS[2], 100, "receptor.m_b2", (3.4, 1.0)),
    photoreceptor.BIASES[2],
    coded_bias("dfb", MASTERS[2], 20, "m_dn", SQUARE),
    coded_bias("on", MASTERS[2], 200, "m_on", SQUARE),
    coded_bias("off", MASTERS[2], 2, "m_off", SQUARE),
)


def build(params: Params = Params()) -> Circuit:
    """The pixel: ports v_pd (photocurrent out), hold (low resets), on, off (out), biases, the supply."""
    p, n = params.sizes("p", "n")
    receptor = photoreceptor.build(photoreceptor.Params(photodiode_capacitance=params.photodiode_capacitance))
    devices = (
        Capacitor("c1", "v_sf", "v_x", params.input_capacitance),
        Capacitor("c2", "v_diff", "v_x", params.feedback_capacitance),
        mos("m_dp", "p", "v_diff", "v_x", "vdd", *p),
        mos("m_dn", "n", "v_diff", "v_dfb", "0", *n),
        mos("m_rst", "p", "v_x", "hold", "v_diff", *params.size("switch")),
        mos("m_onp", "p", "on", "v_diff", "vdd", *p),
        mos("m_on", "n", "on", "v_on", "0", *n),
        mos("m_offp", "p", "off", "v_diff", "vdd", *p),
        mos("m_off", "n", "off", "v_off", "0", *n),
    )
    ports = (SUPPLY, *analog_in("v_pd", "hold"), *event_out("on", "off"))
    return biased("dvs_pixel", ports, BIASES, devices, (receptor.instance("receptor"),))


STIMULI = (
    Stimulus("photocurrent", "A", 10e-12, "before the change"),
    Stimulus("change", "", 0.6, "e-folds by which it grows, and then falls back"),
    lasting(0.4),
)
PLOTTED = ("v_pd", "v_sf", "v_diff", "on", "off")


def testbench(circuit: Circuit, stimuli: Values, v_dd: float) -> Testbench:
    """Light that grows by so many e-folds, and after a second reset falls back; each takes half of the run.

    Raises `ParameterError` for no photocurrent, and for a change of more than 20 e-folds.
    """
    dark, folds = stimuli["photocurrent"] or 0.0, stimuli["change"] or 0.0
    photoreceptor.check_light(dark, folds)
    stop = stimuli["duration"] or 0.0
    half = 0.5 * stop
    up = photoreceptor.light(2.0 * RESET_S, 0.95 * half, dark, folds, POINTS)
    down = photoreceptor.light(half + 2.0 * RESET_S, stop, dark * math.exp(folds), -folds, POINTS)
    time, level = (np.concatenate(pair) for pair in zip(up, down, strict=True))
    wave = PiecewiseLinear((0.0, *time.tolist()), (-dark, *(-level).tolist()))
    sources = (*powered(v_dd, {"hold": _resets(half, v_dd)}), current_into("v_pd", wave))
    return rested("DVS pixel", circuit, sources, stop, ROLLS_180, watch=("on",))


def _resets(half: float, v_dd: float) -> PiecewiseLinear:
    """Low from the beginning and from half of the run on, each for 5 ms."""
    time = (0.0, RESET_S, RESET_S + EDGE, half, half + EDGE, half + RESET_S, half + RESET_S + EDGE)
    return PiecewiseLinear(time, (0.0, 0.0, v_dd, v_dd, 0.0, 0.0, v_dd))


def measures(result: Result) -> dict[str, float | None]:
    """Numbers of a run: `theta_on`, `theta_off` and `amplifier_gain`, all plain numbers.

    theta_on: e-folds of light since the first reset at which `on` rises. theta_off: those since the second
    reset at which `off` falls, below 0. amplifier_gain: slope of v_diff over v_sf
    while the light begins to grow. None where there is no event.
    """
    time, half = result.time, half_supply(result.machine)
    middle = 0.5 * float(time[-1])
    first, second = (time > RESET_S) & (time < middle), time > middle + RESET_S
    on = rising_crossing(time[first], result["on"][first], half)
    off = falling_crossing(time[second], result["off"][second], half)
    machine = result.machine
    light, level = machine.polylines[machine.source_names.index("v_pd")]
    logarithm = np.log(np.abs(level))
    early = (time > 2.0 * RESET_S + 0.1 * middle) & (time < 0.4 * middle)
    return {
        "theta_on": None if on is None else float(np.interp(on, light, logarithm) - logarithm[0]),
        "theta_off": None
        if off is None
        else float(np.interp(off, light, logarithm) - np.interp(middle, light, logarithm)),
        "amplifier_gain": slope(result["v_sf"], result["v_diff"], early),
    }


def outcome(result: Result) -> str:
    """`both`, `on`, `off` or `none`: which events the light has made."""
    found = measures(result)
    on, off = found["theta_on"] is not None, found["theta_off"] is not None
    return ("none", "off", "on", "both")[2 * on + off]


BLOCK = catalogued("dvs-pixel", build, STIMULI, testbench, measures, outcome, PLOTTED, ROLLS_180)
