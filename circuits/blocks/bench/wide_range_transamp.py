"""Wide-range transconductance amplifier: the currents of a pair are mirrored to an output at both rails.

    I_out = I_b tanh(kappa (v_plus - v_minus) / 2 U_T)

Both currents of the nFET pair go through pFET mirrors; that of v_minus is turned round by an nFET mirror and
drawn from the output. So the output is no drain of the pair, and reaches within a few U_T of either rail.

Source: topology, sizes and the bias's code are the laboratory's.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

from circuits.blocks.bench.amplifier import STIMULI, AmplifierSizes, open_sweep, output_measures, switches
from circuits.blocks.bench.bias import MASTERS, coded_bias
from circuits.blocks.block import catalogued
from circuits.blocks.mos import current_mirror, mos
from circuits.blocks.ports import SUPPLY, analog_in, analog_out, bias_in, biased
from circuits.circuit import Circuit
from circuits.devices import Transistor
from circuits.silicon.process import ROLLS_180


@dataclass(frozen=True, slots=True)
class Params(AmplifierSizes):
    """Sizes, um: n is that of the pair, the tail and the nFET mirror, p that of the pFET mirrors."""


def devices(params: Params) -> tuple[Transistor, ...]:
    """Its transistors between v_plus, v_minus, v_tail, v_out and the rails; params: their sizes."""
    n, p = params.sizes("n", "p")
    return (
        mos("mb", "n", "v_s", "v_tail", "0", *n),
        mos("m1", "n", "v_p1", "v_plus", "v_s", *n),
        mos("m2", "n", "v_p2", "v_minus", "v_s", *n),
        mos("m3", "p", "v_p1", "v_p1", "vdd", *p),
        mos("m4", "p", "v_p2", "v_p2", "vdd", *p),
        mos("m5", "p", "v_out", "v_p1", "vdd", *p),
        mos("m6", "p", "v_n", "v_p2", "vdd", *p),
        *current_mirror("m7", "m8", "n", "v_n", "v_out", n),
    )


BIASES = (coded_bias("tail", MASTERS[3], 85, "mb", (1.0, 1.0)),)


def amplifier(params: Params) -> Circuit:
    """The amplifier without its bias: ports v_plus, v_minus, v_out, v_tail and the supply; params: sizes."""
    ports = (SUPPLY, *analog_in("v_plus", "v_minus"), *analog_out("v_out"), *bias_in("v_tail"))
    return Circuit("wide_range_transamp", ports, devices(params))


def build(params: Params = Params()) -> Circuit:
    """The amplifier: ports v_plus, v_minus, v_out, v_tail (bias) and the supply; params: sizes."""
    ports = (SUPPLY, *analog_in("v_plus", "v_minus"), *analog_out("v_out"))
    return biased("wide_range_transamp", ports, BIASES, devices(params))


PLOTTED = ("v_plus", "v_out")
testbench = partial(open_sweep, "wide-range transamp")

BLOCK = catalogued(
    "wide-range-transamp", build, STIMULI, testbench, output_measures, switches, PLOTTED, ROLLS_180
)
