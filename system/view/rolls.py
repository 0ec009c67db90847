"""What is inside a neuron of a ROLLS chip, for a film."""

from __future__ import annotations

from chips.rolls.chip import RollsChip
from chips.rolls.circuit import NAME
from chips.rolls.program.address import NEURONS
from circuits.blocks.rolls import neuron as rolls_neuron
from system.view.devices import devices_of
from system.view.film import Neuron


def neuron_inside(chip: RollsChip, name: str) -> Neuron:
    """Return a neuron with its devices on the chip's die; name: as `neuron[12]`."""
    at = int(name[name.index("[") + 1 : -1])
    place = ((NAME, ()), ("row", (NEURONS,)), ("neuron", ()))
    return Neuron(name=name, devices=devices_of(rolls_neuron.build(), chip.silicon, place, at))
