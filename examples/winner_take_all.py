"""Two populations of a ROLLS chip inhibit each other: the one that hears more events silences the other."""

from __future__ import annotations

import numpy as np

from chips.api import open_chip
from chips.api.rolls import (
    VIRTUAL_EXCITATORY,
    Network,
    PopulationInput,
    network_program,
    place,
    winner_take_all,
)
from circuits.api import Die
from system.api.play import Ranges, RateCode, VoteDecoder

RATES = ((400.0, 100.0), (100.0, 400.0))  # Hz, of the events to each neuron of left and right, for 0.3 s each


def main() -> None:
    """Who wins on three dies, and how many spikes a neuron both have."""
    sides = place({"left": 32, "right": 32})
    network = Network(
        tuple(sides.values()),
        winner_take_all(tuple(sides.values()), excitation=0, inhibition=-1),
        tuple(PopulationInput(name, side) for name, side in sides.items()),
    )
    inputs = [[n + (VIRTUAL_EXCITATORY << 8) for n in side.neurons] for side in sides.values()]
    vote = VoteDecoder([side.neurons for side in sides.values()])
    for number in (1000, 1001, 1003):
        chip = open_chip("rolls", Die("A", number), program=network_program(network))
        code, told = RateCode(Ranges((0.0, 0.0), (1.0, 1.0), inputs), most=1000.0), []
        for rates in RATES:
            chip.send(*code.events(np.array(rates) / 1000.0, chip.time, 0.3))
            told.append(list(sides)[vote.action(chip.advance(0.3), chip.time, 0.3)])
        print(f"die A/{number}: {' then '.join(told)} wins")


if __name__ == "__main__":
    main()
