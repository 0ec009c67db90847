"""Spikes that are run side by side."""

from __future__ import annotations

import numpy as np

from chips.rolls.circuit import Params, chip
from chips.rolls.neuron.model import neurons_of
from chips.rolls.parts import devices_at, gate_voltages, part_gates, row_place
from chips.rolls.program.bias_file import default_biases
from chips.rolls.tables import prepare
from circuits.blocks.rolls import neuron as rolls_neuron
from circuits.silicon.die import Die
from circuits.silicon.process import ROLLS_180_IDEAL
from circuits.silicon.silicon import Silicon


def test_a_neuron_has_the_bits_that_it_has_by_itself() -> None:
    params, silicon = Params(), Silicon(ROLLS_180_IDEAL, 27.0, Die(number=1000))
    gates = part_gates("neuron", gate_voltages(chip(params, default_biases(), "gate"), silicon))
    place = row_place(40, ("neuron", ()))  # more than there are lanes
    d = devices_at(rolls_neuron.build(params.neuron), place, silicon, gates)
    capacitance = prepare(params, silicon.process).neuron
    together = neurons_of(d, capacitance)
    assert (together.kick > 0.0).all()
    assert (together.refractory > together.delay).all()
    for k in (0, 31, 39):
        alone = neurons_of(d.taken(np.array([k])), capacitance)
        for name in ("delay", "delay_exponent", "refractory", "kick"):
            assert getattr(alone, name)[0] == getattr(together, name)[k]
