"""Populations of neurons, and the weight levels between them.

A projection holds a level for every pair, 0 where there is no synapse: levels[target, source]. A neural field
is a population whose neurons excite their neighbours and inhibit the others, by their distance d in the
population's order:

    level(d) = near[d]  for d < len(near),   far  for d <= reach,   0  beyond

with `reach` None for global inhibition. A winner-take-all of several populations excites within each one and
inhibits between them. Sources: Milde et al. 2017, section 2.4.1 (each neuron excites itself and its two to
four nearest neighbours, and inhibits the rest directly).
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from chips.rolls.program.address import NEURONS
from chips.rolls.program.program import HIGHEST_LEVEL
from circuits.errors import ParameterError

Levels = NDArray[np.signedinteger[Any]]


@dataclass(frozen=True, slots=True)
class Population:
    """A named group of neurons of the chip.

    name: name of the population. neurons: numbers of its neurons, each once, in their order in the group.

    Raises `ParameterError` where there are no neurons, or one is there twice.
    """

    name: str
    neurons: tuple[int, ...]

    def __post_init__(self) -> None:
        object.__setattr__(self, "neurons", tuple(int(n) for n in self.neurons))
        if not self.neurons or len(set(self.neurons)) < len(self.neurons):
            raise ParameterError(
                f"population.{self.name}: {len(self.neurons)} neurons, must be one or more, each once;"
                " remove doubles"
            )

    def __len__(self) -> int:
        return len(self.neurons)

    def part(self, start: int, stop: int) -> Population:
        """Return the neurons `start` to `stop` - 1 of the population, counted in it.

        Raises `ParameterError` where it has no such neurons.
        """
        if not 0 <= start < stop <= len(self):
            raise ParameterError(
                f"population.{self.name}.part: {start} to {stop}, must be within 0 to {len(self)};"
                " begin before the end"
            )
        return Population(f"{self.name}[{start}:{stop}]", self.neurons[start:stop])


@dataclass(frozen=True, slots=True, eq=False)
class Projection:
    """Synapses from one population to another.

    Raises `ParameterError` for a level that is not -4 to 4, and for levels of another shape.

    Attributes
    ----------
    source, target
        The populations.
    levels
        Weight levels, int8[target, source], 0 for none.
    """

    source: Population
    target: Population
    levels: Levels

    def __post_init__(self) -> None:
        given = np.asarray(self.levels)
        if given.dtype.kind not in "iu":
            raise ParameterError(f"{self.name}: {given.dtype} levels, must be whole numbers; convert them")
        if given.shape != (len(self.target), len(self.source)):
            raise ParameterError(
                f"{self.name}: levels of {' x '.join(map(str, given.shape))}, must be {len(self.target)} x"
                f" {len(self.source)}; rows are targets"
            )
        wrong = np.abs(given.astype(np.int64)) > HIGHEST_LEVEL
        if wrong.any():
            raise ParameterError(
                f"{self.name}: level {given[wrong][0]}, must be -4 to 4; the chip has eight weights, so share"
                " one, or change the weight biases"
            )
        object.__setattr__(self, "levels", given.astype(np.int8))

    @property
    def name(self) -> str:
        """Name of the projection, as `ol -> dr`."""
        return f"{self.source.name} -> {self.target.name}"


def place(sizes: Mapping[str, int], blacklist: Collection[int] = ()) -> dict[str, Population]:
    """Put populations on the chip, one after the other from neuron 0 on.

    Parameters
    ----------
    sizes
        Number of neurons of each population by its name.
    blacklist
        Neurons that no population gets.

    Raises
    ------
    ParameterError
        The chip has too few neurons.
    """
    free = [n for n in range(NEURONS) if n not in blacklist]
    placed, begin = {}, 0
    for name, size in sizes.items():
        if begin + size > len(free):
            raise ParameterError(
                f"population.{name}: {size} neurons, must be <= {len(free) - begin}, which are left of"
                f" {len(free)}; make populations smaller"
            )
        placed[name] = Population(name, tuple(free[begin : begin + size]))
        begin += size
    return placed


def all_to_all(source: Population, target: Population, level: int) -> Projection:
    """Connect every neuron of `source` to every one of `target`; within one population to itself too.

    Parameters
    ----------
    level
        Level of all these synapses, from -4 to 4.
    """
    return Projection(source, target, np.full((len(target), len(source)), level))


def one_to_one(source: Population, target: Population, level: int) -> Projection:
    """Connect each neuron of `source` to that of the same place in `target`.

    Raises `ParameterError` for populations of different sizes.

    Parameters
    ----------
    level
        Level of all these synapses, from -4 to 4.
    """
    if len(source) != len(target):
        raise ParameterError(
            f"{source.name} -> {target.name}: {len(source)} and {len(target)} neurons, must be as many;"
            " take a part of one"
        )
    return Projection(source, target, level * np.eye(len(target), dtype=np.int64))


def with_probability(
    source: Population, target: Population, level: int, probability: float, seed: int
) -> Projection:
    """Connect each pair of neurons of two populations at random.

    Parameters
    ----------
    source, target
        The populations.
    level
        Level of all these synapses, from -4 to 4.
    probability
        Probability with which a pair is connected, drawn by itself.
    seed
        Seed of the draws.

    Raises
    ------
    ParameterError
        The probability is beyond 0 to 1.
    """
    if not 0.0 <= probability <= 1.0:
        raise ParameterError(
            f"{source.name} -> {target.name}: probability {probability:g}, must be 0 to 1; give a share"
        )
    chosen = np.random.default_rng(seed).random((len(target), len(source))) < probability
    return Projection(source, target, level * chosen)


def without_self(projection: Projection) -> Projection:
    """Return the projection without synapses from a neuron to itself."""
    same = np.equal.outer(projection.target.neurons, projection.source.neurons)
    return Projection(projection.source, projection.target, np.where(same, 0, projection.levels))


def neural_field(
    population: Population,
    near: Sequence[int],
    far: int,
    reach: int | None = None,
    boundary: str = "open",
) -> Projection:
    """Return the projection that makes a neural field of a population.

    Raises `ParameterError` for another boundary, and a reach that ends before `near` does.

    Parameters
    ----------
    population
        The population, whose neurons stand in a row.
    near
        Levels by distance from 0 on.
    far
        Level beyond these.
    reach
        Distance up to which `far` holds; everywhere unless given.
    boundary
        `open`, or `ring` where the last neuron is the first one's neighbour.
    """
    if reach is not None and reach < len(near) - 1:
        raise ParameterError(
            f"{population.name}.reach: {reach}, must be >= {len(near) - 1}, as far as near goes; cut near"
        )
    if boundary not in {"open", "ring"}:
        raise ParameterError(f"{population.name}.boundary: {boundary}, must be open or ring; choose one")
    size = len(population)
    distance = np.abs(np.subtract.outer(np.arange(size), np.arange(size)))
    if boundary == "ring":
        distance = np.minimum(distance, size - distance)
    by_distance = np.zeros(max(size, len(near)), dtype=np.int64)
    by_distance[: size if reach is None else reach + 1] = far
    by_distance[: len(near)] = near
    return Projection(population, population, by_distance[distance])


def winner_take_all(
    populations: Iterable[Population], excitation: int, inhibition: int
) -> tuple[Projection, ...]:
    """Connect every population to itself with excitation, and to each other one with inhibition.

    All neurons are connected to all. A level of 0 leaves its projections out.

    Parameters
    ----------
    populations
        The populations.
    excitation
        Level within a population, 0 to 4.
    inhibition
        Level between two of them, -4 to 0.

    Raises
    ------
    ParameterError
        The excitation is below 0, or the inhibition above.
    """
    if excitation < 0 or inhibition > 0:
        raise ParameterError(
            f"winner_take_all: excitation {excitation}, inhibition {inhibition}, must be >= 0 and <= 0;"
            " inhibitory levels are negative"
        )
    groups = tuple(populations)
    pairs = [(a, b, excitation if a is b else inhibition) for a in groups for b in groups]
    return tuple(all_to_all(a, b, level) for a, b, level in pairs if level)
