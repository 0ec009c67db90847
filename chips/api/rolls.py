"""The ROLLS chip:populations and what connects them, programs, biases, runs, and what a die is like."""

from chips.rolls.calibration import Calibration, Knob, Target, Task, calibrate, neuron_rates
from chips.rolls.chip import Inputs, RollsChip, Spikes
from chips.rolls.depression.program import ShortTermDepression
from chips.rolls.plastic.program import PlasticArray
from chips.rolls.portrait import Portrait, portrait
from chips.rolls.program.address import NONPLASTIC, VIRTUAL_EXCITATORY, VirtualSynapses
from chips.rolls.program.bias_file import (
    BiasEntry,
    BiasTable,
    default_biases,
    read_biases,
    resting_biases,
    shipped_biases,
    write_biases,
)
from chips.rolls.program.connectivity_picture import draw_connectivity
from chips.rolls.program.network import Network, PopulationInput, network_program
from chips.rolls.program.nir import nir_graph, write_nir
from chips.rolls.program.population import (
    Population,
    Projection,
    all_to_all,
    neural_field,
    one_to_one,
    place,
    winner_take_all,
)
from chips.rolls.program.program import Program, VirtualInput
from chips.rolls.program.words import input_words, program_of_words, program_words, programming_time
from chips.rolls.setups.populations import QUIET, table

__all__ = [  # noqa: RUF022 - in the order of the reference, grouped by its headings
    # Populations and networks
    "Population",
    "Projection",
    "place",
    "all_to_all",
    "one_to_one",
    "neural_field",
    "winner_take_all",
    "Network",
    "PopulationInput",
    "network_program",
    "draw_connectivity",
    # Programs and their words
    "Program",
    "VirtualInput",
    "VirtualSynapses",
    "NONPLASTIC",
    "VIRTUAL_EXCITATORY",
    "table",
    "QUIET",
    "input_words",
    "program_words",
    "program_of_words",
    "programming_time",
    "PlasticArray",
    "ShortTermDepression",
    # Biases
    "BiasTable",
    "BiasEntry",
    "default_biases",
    "resting_biases",
    "shipped_biases",
    "read_biases",
    "write_biases",
    # The chip in time
    "RollsChip",
    "Inputs",
    "Spikes",
    # Calibration, and what a die is like
    "calibrate",
    "Calibration",
    "Task",
    "Target",
    "Knob",
    "neuron_rates",
    "portrait",
    "Portrait",
    # Graphs of NIR
    "nir_graph",
    "write_nir",
]
