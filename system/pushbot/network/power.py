"""The power of a ROLLS chip under a network, from what its spikes and events charge: a lower bound.

    P = V_dd (E + N V_dd (C_mem + C_ref + C_hold)) / T

E: charge that all synapses draw in their pulses, of every spike those of its column, and of every external
event one virtual synapse; N: spikes. Bias generator, pads, the bus and the comparators' standing currents are
not in it: the chip takes about 4 mW in the paper's experiments, which is theirs.
"""

from __future__ import annotations

import numpy as np

from chips.rolls.chip import RollsChip
from chips.rolls.program.program import level_current
from circuits.arrays import I64


def activity_power(chip: RollsChip, neurons: I64, events: int, duration: float) -> float:
    """Mean power, W, of spikes of `neurons` and of so many events at virtual synapses in `duration` s."""
    program, built = chip.program, chip.built()
    supply = chip.silicon.process.v_dd
    level = np.array([level_current(program.biases, k) for k in range(-4, 5)])
    drawn = level[np.asarray(program.levels, dtype=np.int64) + 4].sum(axis=0)  # A, by presynaptic neuron
    spikes = np.bincount(neurons, minlength=drawn.size)
    charge = float((spikes * drawn * built.lengths).sum())
    charge += events * program.biases.current("VA_EXC_N") * float(built.lengths.mean())
    sizes = chip.params.neuron
    each = sizes.membrane_capacitance + sizes.refractory_capacitance + sizes.hold_capacitance
    return supply * (charge + float(spikes.sum()) * supply * each) / duration
