"""Transconductance amplifier of five transistors, with nFETs or with pFETs at its inputs, in three copies.

    I_out = I_b tanh(kappa (v_plus - v_minus) / 2 U_T)

A pair on a tail current, whose current of v_plus is mirrored to the output, the drain of the other side. That
drain cannot pass the pair's source: where v_plus is the lower one the open output of the nFET form follows it
with a slope of about kappa, and that of the pFET form where v_plus is the higher one.

The chip has three copies. `v_out` is the open output of one. That of another loads an nFET diode to ground,
whose mirror draws `i_plus`, what the output gives; that of the third a pFET diode to the supply, which a
pFET and an nFET mirror hand on to `i_minus`, what it takes. A diode stands nearer to its rail than the pair's
source can: far from balance the transistor at v_minus then conducts backwards from the pair's source (or to
it), and what is read is more than the tail's current.

Source: topology, sizes and the bias's code are the laboratory's, the loads after its sketch. The sizes of the
loads and mirrors are ours, those of the amplifier's own mirrors, and so is the voltage of the readout.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from circuits.arrays import F64
from circuits.blocks.bench.amplifier import STIMULI, AmplifierSizes, open_sweep, output_measures, switches
from circuits.blocks.bench.bias import MASTERS, coded_bias
from circuits.blocks.bench.curve import crossing, slope
from circuits.blocks.block import Block, Stimulus, catalogued
from circuits.blocks.mos import current_mirror, mos
from circuits.blocks.ports import SUPPLY, analog_in, analog_out, bias_in
from circuits.blocks.sizes import um
from circuits.circuit import Bias, Circuit
from circuits.devices import Transistor
from circuits.silicon.process import ROLLS_180, Polarity
from circuits.solver.power import drain_current
from circuits.solver.transient import Result

FULL = 0.3  # V between the inputs, where the pair has steered all of its current
FOLLOWING = (0.14, 0.46)  # V between the inputs, where the open output follows one of them


@dataclass(frozen=True, slots=True)
class Params(AmplifierSizes):
    """Sizes of each copy and of the readout, um.

    n, p: of a copy's nFETs and pFETs, of which one polarity is the pair with its tail and the other the
    mirror. readout_n, readout_p: of the loads of the second and third copies, and of the mirrors behind them.
    """

    readout_n_width: float = um(1.0)
    readout_n_length: float = um(1.0)
    readout_p_width: float = um(3.4)
    readout_p_length: float = um(1.0)


def stage(polarity: Polarity, params: Params) -> Circuit:
    """One amplifier with inputs of a polarity: ports v_plus, v_minus, v_out, v_tail and the supply."""
    n, p = params.sizes("n", "p")
    pair, mirror = (n, p) if polarity == "n" else (p, n)
    rail = "0" if polarity == "n" else "vdd"
    load: Polarity = "p" if polarity == "n" else "n"
    return Circuit(
        f"transamp_{polarity}_stage",
        (SUPPLY, *analog_in("v_plus", "v_minus"), *analog_out("v_out"), *bias_in("v_tail")),
        (
            mos("mb", polarity, "v_s", "v_tail", rail, *pair),
            mos("m1", polarity, "v_d", "v_plus", "v_s", *pair),
            mos("m2", polarity, "v_out", "v_minus", "v_s", *pair),
            *current_mirror("m3", "m4", load, "v_d", "v_out", mirror),
        ),
    )


def readout(params: Params) -> tuple[Transistor, ...]:
    """The loads of the second and third copies, and the mirrors behind them; params: their sizes."""
    n, p = params.sizes("readout_n", "readout_p")
    return (
        *current_mirror("mp1", "mp2", "n", "v_source", "i_plus", n),
        *current_mirror("mm1", "mm2", "p", "v_sink", "v_turn", p),
        *current_mirror("mm3", "mm4", "n", "v_turn", "i_minus", n),
    )


def bias_of(polarity: Polarity) -> Bias:
    """The tail's bias, at code 85 of 30 nA, in the first copy's tail of a polarity."""
    return coded_bias("tail", MASTERS[3], 85, "open.mb", (1.0, 1.0) if polarity == "n" else (3.4, 1.0))


def build(polarity: Polarity, params: Params) -> Circuit:
    """The three copies: ports v_plus, v_minus, v_out, i_plus, i_minus (currents in), v_tail, the supply."""
    one = stage(polarity, params)
    copies = (
        one.instance("open"),
        one.instance("plus", v_out="v_source"),
        one.instance("minus", v_out="v_sink"),
    )
    outputs = analog_out("v_out", "i_plus", "i_minus")
    ports = (SUPPLY, *analog_in("v_plus", "v_minus"), *outputs, *bias_in("v_tail"))
    return Circuit(f"transamp_{polarity}", ports, readout(params), copies, biases=(bias_of(polarity),))


def with_nfets(params: Params = Params()) -> Circuit:
    """The copies with nFETs at their inputs; params: sizes."""
    return build("n", params)


def with_pfets(params: Params = Params()) -> Circuit:
    """The copies with pFETs at their inputs; params: sizes."""
    return build("p", params)


def measures(result: Result) -> dict[str, float | None]:
    """Numbers of a run: those of an open output, `follower_slope`, and those of the other copies' currents.

    follower_slope: of the open output over v_plus where it follows. `offset_V`: v_plus less v_minus at which
    i_plus and i_minus are equal. `transconductance_S`: the steepest rise of their difference there.
    `source_A`, `sink_A`: i_plus and i_minus at 0.3 V of either sign. None where the sweep does not get there.
    """
    over = result["v_plus"] - result["v_minus"]
    plus, minus = (np.abs(drain_current(result, name)) for name in ("mp2", "mm4"))
    offset = crossing(over, plus - minus, 0.0)
    return {
        **output_measures(result),
        "follower_slope": _following(result, over),
        "offset_V": offset,
        "transconductance_S": None if offset is None else _slope_at(over, plus - minus, offset),
        "source_A": float(np.interp(FULL, over, plus)),
        "sink_A": float(np.interp(-FULL, over, minus)),
    }


def _following(result: Result, over: F64) -> float | None:
    """Slope of the open output on the side on which the pair's own source holds it."""
    nfets = result.machine.testbench.circuit.name == "transamp_n"
    away = -over if nfets else over
    return slope(over, result["v_out"], (away > FOLLOWING[0]) & (away < FOLLOWING[1]))


def _slope_at(over: F64, current: F64, at: float) -> float | None:
    return slope(over, current, np.abs(over - at) < 0.0101)


def _block(polarity: Polarity, made: Callable[..., Circuit]) -> Block:
    stimuli = (*STIMULI, Stimulus("out", "V", 1.2, "where both currents are read"))
    testbench = partial(open_sweep, f"transamp {polarity}", held=("i_plus", "i_minus"))
    plotted = ("v_plus", "v_out", "v_source", "v_sink")
    name = f"transamp-{polarity}"
    return catalogued(name, made, stimuli, testbench, measures, switches, plotted, ROLLS_180)


N = _block("n", with_nfets)
P = _block("p", with_pfets)
