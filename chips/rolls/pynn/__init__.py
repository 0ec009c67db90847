"""PyNN's API on a ROLLS chip: `import chips.rolls.pynn as sim` in the place of another back-end; an extra.

A population's neurons are neurons of the chip, a source is a column of synapses that events from outside
reach, a weight is one of the chip's levels, 1 to 4. What PyNN asks and the chip lacks is refused in a line.
"""

from pyNN.connectors import (
    AllToAllConnector,
    ArrayConnector,
    CloneConnector,
    DisplacementDependentProbabilityConnector,
    DistanceDependentProbabilityConnector,
    FixedNumberPostConnector,
    FixedNumberPreConnector,
    FixedProbabilityConnector,
    FixedTotalNumberConnector,
    FromFileConnector,
    FromListConnector,
    IndexBasedProbabilityConnector,
    OneToOneConnector,
)
from pyNN.random import NumpyRNG, RandomDistribution
from pyNN.space import Grid2D, Grid3D, Line, RandomStructure, Space

from chips.rolls.pynn.cells import RollsNeuron, SpikeSourceArray, SpikeSourcePoisson, StaticSynapse
from chips.rolls.pynn.control import (
    connect,
    counts,
    create,
    end,
    get_current_time,
    get_max_delay,
    get_min_delay,
    get_time_step,
    initialize,
    num_processes,
    program,
    rank,
    record,
    reset,
    run,
    run_for,
    run_until,
    setup,
)
from chips.rolls.pynn.lacking import __getattr__
from chips.rolls.pynn.populations import Assembly, Population, PopulationView
from chips.rolls.pynn.projections import Projection

__all__ = [
    "AllToAllConnector",
    "ArrayConnector",
    "Assembly",
    "CloneConnector",
    "DisplacementDependentProbabilityConnector",
    "DistanceDependentProbabilityConnector",
    "FixedNumberPostConnector",
    "FixedNumberPreConnector",
    "FixedProbabilityConnector",
    "FixedTotalNumberConnector",
    "FromFileConnector",
    "FromListConnector",
    "Grid2D",
    "Grid3D",
    "IndexBasedProbabilityConnector",
    "Line",
    "NumpyRNG",
    "OneToOneConnector",
    "Population",
    "PopulationView",
    "Projection",
    "RandomDistribution",
    "RandomStructure",
    "RollsNeuron",
    "Space",
    "SpikeSourceArray",
    "SpikeSourcePoisson",
    "StaticSynapse",
    "__getattr__",
    "connect",
    "counts",
    "create",
    "end",
    "get_current_time",
    "get_max_delay",
    "get_min_delay",
    "get_time_step",
    "initialize",
    "num_processes",
    "program",
    "rank",
    "record",
    "reset",
    "run",
    "run_for",
    "run_until",
    "setup",
]
