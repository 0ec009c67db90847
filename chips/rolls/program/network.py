"""A network of populations on ROLLS: projections between named groups, external inputs, and its program.

Of two projections with a level for the same pair of neurons, neither wins: a synapse has one level, so they
are refused unless they agree. (The control software lets the later one win.)
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from chips.rolls.program.address import LAB_VIRTUAL, NEURONS, VirtualSynapses
from chips.rolls.program.bias_file import BiasTable, resting_biases
from chips.rolls.program.population import Population, Projection
from chips.rolls.program.program import Program, VirtualInput
from circuits.arrays import I8
from circuits.errors import ParameterError, unknown_name


@dataclass(frozen=True, slots=True)
class PopulationInput:
    """An external input to every neuron of a population.

    name: name of the input. target: the population. synapses: how many virtual synapses of each neuron it
    reaches. inhibitory: whether these inhibit.
    """

    name: str
    target: Population
    synapses: int = 1
    inhibitory: bool = False


@dataclass(frozen=True, slots=True)
class Network:
    """Populations, which share no neuron, what connects them, and what reaches them from outside.

    Attributes
    ----------
    populations : tuple of Population
        The populations.
    projections : tuple of Projection
        What connects them.
    inputs : tuple of PopulationInput
        What reaches them from outside.
    slow : tuple of Population
        Populations whose leak is IF_TAU1; all others have IF_TAU2.

    Raises
    ------
    ParameterError
        A neuron is not on the chip, is in two populations or, at an end of a projection, input or slow leak,
        in none; a name is given twice; or a pair of neurons has two levels.
    """

    populations: tuple[Population, ...]
    projections: tuple[Projection, ...] = ()
    inputs: tuple[PopulationInput, ...] = ()
    slow: tuple[Population, ...] = field(default=())

    def __post_init__(self) -> None:
        owner = _owners(self.populations)
        for projection in self.projections:
            for group in (projection.source, projection.target):
                _check_known(group, owner, projection.name)
        for each in self.inputs:
            _check_known(each.target, owner, f"input {each.name}")
        for group in self.slow:
            _check_known(group, owner, "slow leak")
        self.levels()

    def __getitem__(self, name: str) -> Population:
        """The population of a name; raises `UnknownNameError`."""
        for population in self.populations:
            if population.name == name:
                return population
        raise unknown_name("population", name, (p.name for p in self.populations))

    def levels(self) -> I8:
        """Return the levels of all projections, int8[post, pre], 256 x 256.

        Raises `ParameterError` where a pair of neurons has two levels.
        """
        levels = np.zeros((NEURONS, NEURONS), dtype=np.int8)
        last = np.full((NEURONS, NEURONS), -1, dtype=np.int64)  # which projection gave the level
        for k, projection in enumerate(self.projections):
            at = np.ix_(projection.target.neurons, projection.source.neurons)
            before, new = levels[at], projection.levels
            clash = (before != 0) & (new != 0) & (before != new)
            if clash.any():
                row, column = np.argwhere(clash)[0]
                post, pre = projection.target.neurons[row], projection.source.neurons[column]
                raise ParameterError(
                    f"{projection.name}: level {new[row, column]} from neuron {pre} to {post}, must be"
                    f" {before[row, column]} as in {self.projections[last[post, pre]].name};"
                    " a synapse has one level: drop one of them"
                )
            levels[at] = np.where(new != 0, new, before)
            last[at] = np.where(new != 0, k, last[at])
        return levels


def network_program(
    network: Network, biases: BiasTable | None = None, virtual: VirtualSynapses = LAB_VIRTUAL
) -> Program:
    """Make the program that puts a network on the chip.

    Parameters
    ----------
    network
        The network.
    biases
        Biases of the chip; those on which it rests unless given.
    virtual
        How many virtual synapses each neuron has.

    Raises
    ------
    ParameterError
        The chip cannot do it, as `Program` says.
    """
    inputs = tuple(
        VirtualInput(each.name, each.target.neurons, each.synapses, each.inhibitory)
        for each in network.inputs
    )
    tau1 = tuple(neuron for population in network.slow for neuron in population.neurons)
    table = resting_biases() if biases is None else biases
    return Program(network.levels(), table, tau1, inputs, virtual)


def _owners(populations: tuple[Population, ...]) -> dict[int, str]:
    """Name of the population of each neuron that is in one."""
    owner: dict[int, str] = {}
    names: set[str] = set()
    for population in populations:
        if population.name in names:
            raise ParameterError(f"population.{population.name}: given twice, must be once; rename one")
        names.add(population.name)
        for neuron in population.neurons:
            if not 0 <= neuron < NEURONS:
                raise ParameterError(
                    f"population.{population.name}: neuron {neuron}, must be 0 to {NEURONS - 1};"
                    f" the chip has {NEURONS} neurons"
                )
            if neuron in owner:
                raise ParameterError(
                    f"population.{population.name}: neuron {neuron} is in {owner[neuron]} too, must be in one"
                    " population; move one of them"
                )
            owner[neuron] = population.name
    return owner


def _check_known(group: Population, owner: dict[int, str], where: str) -> None:
    for neuron in group.neurons:
        if neuron not in owner:
            raise ParameterError(
                f"{where}: neuron {neuron} of {group.name}, must be in a population of the network; add it"
            )
