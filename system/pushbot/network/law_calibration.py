"""Codes with which the Pushbot's nominal die does under the full law what its table does under the ideal one.

The table of `system.pushbot.network.biases` was found under the ideal law. Body effect bends the gain of a
DPI filter, `I_syn ~ I_th (I_w / I_tau)^(kappa_p / kappa_n)`: pFETs near the supply have a smaller kappa, and
nFETs with their gates high up a larger one. So events drive populations at 12 Hz that they drove at 170 Hz.
It also takes more current to fire a neuron with the fast leak. What is searched is not weights, whose levels
would go out of where the chip's model holds, but the fast leak and the currents I_th, which move all levels
of a filter together:

    direct current -> neurons     IF_TAU2_N (fast leak)      OL -> DR, OR -> DL    NPDPIE_THR_P
    events -> OL, OR              VDPIE_THR_P                OL, OR -| sp          NPDPII_THR_P
    exc -> exc                    IF_RFR2_N (refractory)

Neurons with the slow leak IF_TAU1_N fire under either law alike. Populations, drives and rates are those of
`system.pushbot.network.calibration`; the rate under a direct current is what the table gives under the ideal
law. What is found is the table `FULL_LAW` beside that table.
"""

from __future__ import annotations

from dataclasses import replace

from chips.rolls.calibration import Knob, Target, Task, calibrate
from chips.rolls.program.bias_file import DIRECT_CURRENT, BiasTable
from chips.rolls.program.network import Network, network_program
from chips.rolls.program.population import Population
from circuits.circuit import BiasKind
from circuits.silicon.silicon import Silicon
from system.pushbot.network.biases import STEP
from system.pushbot.network.calibration import ROUNDS, calibration_task

DIRECT = (4, 118)  # 3.0 nA, of the neurons' search: below it a rate is too steep to be searched by; ours
DIRECT_RATE = 237.0  # Hz: what the table gives under it on the nominal die, ideal law
PASSES = 2  # searches of the filters, each from where the one before has ended


def calibrate_law(
    network: Network, biases: BiasTable, silicon: Silicon, kind: BiasKind = "generator"
) -> BiasTable:
    """Search the codes of the plain network, from the table of another law, at the silicon's temperature.

    Parameters
    ----------
    network
        The plain network.
    biases
        Its table under the ideal law.
    silicon
        The nominal die of the law.
    kind
        Kind of the biases.
    """
    neurons = calibrate(neuron_task(network, biases), silicon, kind, ROUNDS, STEP)
    found = neurons.biases.with_code(DIRECT_CURRENT, *biases.code(DIRECT_CURRENT))
    for _ in range(PASSES):
        found = calibrate(filter_task(network, found), silicon, kind, ROUNDS, STEP).biases
    return found


def neuron_task(network: Network, biases: BiasTable) -> Task:
    """All neurons with the fast leak under a direct current, without any synapse."""
    slow = {n for p in network.slow for n in p.neurons}
    fast = Population("fast", tuple(n for p in network.populations for n in p.neurons if n not in slow))
    alone = network_program(replace(network, projections=()), biases.with_code(DIRECT_CURRENT, *DIRECT))
    return Task(alone, (Target(fast, DIRECT_RATE),), (Knob("IF_TAU2_N", (fast.name,), -1),), most=0)


def filter_task(network: Network, biases: BiasTable) -> Task:
    """The populations of a die's calibration, with the filters' currents as knobs."""
    knobs = (
        Knob("VDPIE_THR_P", ("OL", "OR")), Knob("IF_RFR2_N", ("exc",)), Knob("NPDPIE_THR_P", ("DL", "DR")),
        Knob("NPDPII_THR_P", ("sp",), -1),
    )  # fmt: skip
    return replace(calibration_task(network, biases), knobs=knobs, most=0)
