"""The Pushbot's network on ROLLS: its populations, the words that program it, and what a blacklist moves."""

from __future__ import annotations

from chips.rolls.program.network import network_program
from chips.rolls.program.words import input_words, program_of_words, program_words, programming_time
from system.pushbot.network.plain import NOTEBOOK, pushbot_network


def main() -> None:
    """Print where the populations stand, how long programming takes, and the words of one camera event."""
    network = pushbot_network(NOTEBOOK)
    program = network_program(network)
    for population in network.populations:
        print(f"{population.name:7} neurons {population.neurons[0]} to {population.neurons[-1]}")
    words = program_words(program)
    print(f"{words.size} words, at least {programming_time(words):.2f} s")
    print(f"written as read: {(program_of_words(words).levels == program.levels).all()}")
    moved = network_program(pushbot_network(NOTEBOOK, blacklist=(70,)))
    print(f"without neuron 70: {program_words(moved, program).size} words")
    print(f"an event of column 3: {input_words(program, 'dvs_columns', 88 + 3).ravel().tolist()}")


if __name__ == "__main__":
    main()
