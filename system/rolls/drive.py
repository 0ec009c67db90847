"""What drives a whole ROLLS die: regular events of every neuron, through one excitatory virtual synapse each.

No neuron is connected to another, and I_dc is off, whatever a bias file says.
"""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from chips.rolls.chip import NO_INPUTS, Inputs
from chips.rolls.program.address import NEURONS, VIRTUAL_EXCITATORY
from chips.rolls.program.bias_file import DIRECT_CURRENT, OFF, BiasTable
from chips.rolls.program.program import Program, VirtualInput

ALL = tuple(range(NEURONS))


def program_of(table: BiasTable) -> Program:
    """Return the program of a die that is driven, at the codes of a table."""
    levels = np.zeros((NEURONS, NEURONS), np.int8)
    return Program(levels, table.with_code(DIRECT_CURRENT, *OFF), inputs=(VirtualInput("drive", ALL),))


def regular_events(rate: float, duration: float, seed: int, off: Collection[int] = ()) -> Inputs:
    """Return regular events of every neuron, each with a phase of its own.

    Parameters
    ----------
    rate
        Events of a neuron, Hz.
    duration
        Of the run, s.
    seed
        Draws the phases.
    off
        Neurons that get none.
    """
    phase = np.random.default_rng(seed).uniform(0.0, 1.0, NEURONS)
    count = int(rate * duration)
    driven = np.array([k for k in ALL if k not in off], dtype=np.int64)
    if count == 0 or not driven.size:
        return NO_INPUTS
    times = (np.arange(count)[:, None] + phase[driven][None, :]) / rate
    neurons = np.tile(driven, (count, 1))
    order = np.argsort(times, axis=None)
    synapse = np.full(times.size, VIRTUAL_EXCITATORY, np.int64)
    return Inputs(times.ravel()[order], neurons.ravel()[order], synapse)
