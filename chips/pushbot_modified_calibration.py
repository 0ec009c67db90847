"""Calibration of the Pushbot's modified network on a die, after that of the plain one.

What a neuron of an obstacle population makes of the few events of its own four columns depends on its own
leak and threshold, and what a drive makes of the ramp on other weights than in the plain network. So codes of
the plain network, changed by nominal factors, are only where the search begins: with these, drives of ten
dies that agreed in the plain network differed up to fivefold. All obstacle neurons are driven, each by events
of its own. As in `chips.pushbot_calibration` nothing competes, and codes are searched at 27 degC until the
rates are those of the nominal die:

    events -> OL, OR     VA_EXC_N           ramps -> DL, DR     NPA_WEIGHT_EXC0_P (levels 2 and 4)
    OL, OR -| sp         NPA_WEIGHT_INH_N

The other inhibitory weights follow by the factor of INH. IF_TAU1_N, which the field needs too, the refractory
period and the weaker levels of the ramp stay as the plain network has them; how strongly the gyro's
populations answer is not calibrated. Of OL, OR, DL, DR and sp at most four neurons each are left out, anew.
Rates, drives and pairings are ours.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from chips.pushbot_biases import STEP, modified_biases
from chips.pushbot_calibration import (
    CELSIUS,
    MOST,
    START,
    START_RATE,
    driven_part,
    poisson_events,
    to_all,
    to_synapses,
)
from chips.rolls_bias_file import BiasTable
from chips.rolls_calibration import Calibration, Knob, Target, Task, calibrate, code_for
from chips.rolls_chip import Inputs
from chips.rolls_network import Network, network_program
from circuits.blocks.rolls_bias import current_of
from circuits.circuit import BiasKind
from circuits.silicon import Silicon

ROUNDS = 8  # runs of the chip at most
EVENTS = 30.0  # 1/s, to each neuron of the obstacle populations
# Hz: what the codes of `chips.pushbot_biases.MODIFIED` give on the nominal die under these events
RATES: Mapping[str, float] = {"OL": 17.0, "OR": 17.0, "DL": 120.0, "DR": 120.0, "sp": 234.0}
FOLLOW = ("NPA_WEIGHT_INH0_N", "NPA_WEIGHT_INH1_N")  # weights that go with NPA_WEIGHT_INH_N


def calibrate_modified(
    network: Network, plain: BiasTable, silicon: Silicon, kind: BiasKind = "generator"
) -> Calibration:
    """Calibrate the modified network on the die of `silicon`, at 27 degC.

    plain: what `chips.pushbot_calibration.calibrate_pushbot` found for the plain network on that die.
    """
    begun = modified_biases(plain)
    found = calibrate(
        modified_task(network, begun), replace(silicon, temperature_c=CELSIUS), kind, ROUNDS, STEP
    )
    table = found.biases
    factor = current_of(table.code("NPA_WEIGHT_INH_N")) / current_of(begun.code("NPA_WEIGHT_INH_N"))
    for name in FOLLOW:
        table = table.with_code(name, *code_for(current_of(begun.code(name)) * factor))
    return replace(found, biases=table)


def modified_task(network: Network, biases: BiasTable) -> Task:
    """What is programmed, driven and asked for."""
    targets = tuple(Target(network[name], rate) for name, rate in RATES.items())
    knobs = (
        Knob("VA_EXC_N", ("OL", "OR")), Knob("NPA_WEIGHT_EXC0_P", ("DL", "DR")),
        Knob("NPA_WEIGHT_INH_N", ("sp",), -1),
    )  # fmt: skip
    program = network_program(driven_part(network), biases)
    return Task(program, targets, knobs, lambda duration: events_of(network, duration), MOST)


def events_of(network: Network, duration: float) -> Inputs:
    """Events to each neuron of OL and OR for `duration` s, its own, and those that start exc."""
    start = np.arange(round(START * START_RATE)) / START_RATE
    each = (*network["OL"].neurons, *network["OR"].neurons)
    own = (to_all(poisson_events(EVENTS, duration, k), (k,)) for k in each)
    return to_synapses(network, [to_all(start, network["exc"].neurons), *own])
