"""Calibration of the Pushbot's modified network on a die, after that of the plain one.

What a neuron of an obstacle population makes of the few events of its own four columns depends on its own
leak and threshold, and what a drive makes of the ramp on other weights than in the plain network. So codes of
the plain network, changed by nominal factors, are only where the search begins: with these, drives of ten
dies that agreed in the plain network differed up to fivefold. All obstacle neurons are driven, each by events
of its own. As in `system.pushbot.network.calibration` nothing competes, and codes are searched
until the rates are those of the nominal die:

    events -> OL, OR     VA_EXC_N           ramps -> DL, DR     NPA_WEIGHT_EXC0_P (levels 2 and 4)

Inhibition (but under the full law, `modified_biases`), IF_TAU1_N, which the field needs too, the refractory
period and the other levels of the ramp stay as the plain network has them; how strongly the gyro's
populations answer is not calibrated. The knob of the drives is a weak one at these events: on die 5 a quarter
of EXC0 takes them from 272 to 242 Hz. Of OL, OR, DL and DR at most four neurons each are left out, anew.
Rates, drives and pairings are ours.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from chips.rolls.calibration import Calibration, Knob, Target, Task, calibrate
from chips.rolls.chip import Inputs
from chips.rolls.program.bias_file import BiasTable
from chips.rolls.program.network import Network, network_program
from circuits.circuit import BiasKind
from circuits.silicon.silicon import Silicon
from system.pushbot.network.biases import STEP, modified_biases
from system.pushbot.network.calibration import (
    MOST,
    START,
    START_RATE,
    driven_part,
    poisson_events,
    to_all,
    to_synapses,
)

ROUNDS = 8  # runs of the chip at most
EVENTS = 60.0  # 1/s, to each neuron of the obstacle populations
# Hz: what the codes of `system.pushbot.network.biases.MODIFIED` give on the nominal die under these events
RATES: Mapping[str, float] = {"OL": 50.0, "OR": 50.0, "DL": 220.0, "DR": 220.0}


def calibrate_modified(
    network: Network, plain: BiasTable, silicon: Silicon, kind: BiasKind = "ideal"
) -> Calibration:
    """Calibrate the modified network on the die of `silicon`, at its temperature.

    plain: what `system.pushbot.network.calibration.calibrate_pushbot` found for the plain network on that
    die.
    """
    begun = modified_biases(plain, silicon.process.effects)
    return calibrate(modified_task(network, begun), silicon, kind, ROUNDS, STEP)


def modified_task(network: Network, biases: BiasTable) -> Task:
    """What is programmed, driven and asked for."""
    targets = tuple(Target(network[name], rate) for name, rate in RATES.items())
    knobs = Knob("VA_EXC_N", ("OL", "OR")), Knob("NPA_WEIGHT_EXC0_P", ("DL", "DR"))
    program = network_program(driven_part(network), biases)
    return Task(program, targets, knobs, lambda duration: events_of(network, duration), MOST)


def events_of(network: Network, duration: float) -> Inputs:
    """Events to each neuron of OL and OR for `duration` s, its own, and those that start exc."""
    start = np.arange(round(START * START_RATE)) / START_RATE
    each = (*network["OL"].neurons, *network["OR"].neurons)
    own = (to_all(poisson_events(EVENTS, duration, k), (k,)) for k in each)
    return to_synapses(network, [to_all(start, network["exc"].neurons), *own])
