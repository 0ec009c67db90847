"""A network of populations as pure data, which a chip is asked to be.

    neuron, leak = "membrane":  tau dv/dt = i - v
            leak = "constant":  tau dv/dt = i - 1,  v >= 0
    synapse:                    tau_s di/dt = -i,   i + weight at each event
    spike where v comes to 1; then v = 0 for the refractory period

so that a current of 1 just makes a neuron fire, and a weight is in units of that current: events of `r` a
second bring a mean current of `r weight tau_s`. A weight below 0 inhibits.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Literal, TypeVar

import numpy as np

from circuits.arrays import F64
from circuits.errors import ParameterError, unknown_name
from system.option import Checked, check_options, option, required

Rule = Literal["all", "one-to-one", "random", "matrix"]
Leak = Literal["membrane", "constant"]
Matrix = tuple[tuple[float, ...], ...]
MOST = 1_000_000  # neurons or channels of a group; ours
_OF_RULES = (("weight", 1.0, ("all", "one-to-one", "random")), ("probability", 1.0, ("random",)))


@dataclass(frozen=True, slots=True)
class Group(Checked):
    """Neurons of a population, or channels of an input.

    Attributes
    ----------
    name : str
        Its name, by which connections and probes call it.
    size : int
        How many neurons or channels it has.
    """

    name: str = required("Its name")
    size: int = required("How many neurons or channels it has", least=1, most=MOST)


@dataclass(frozen=True, slots=True)
class Population(Group):
    """Neurons that are alike.

    Attributes
    ----------
    tau : float
        Time constant of the membrane, s.
    refractory : float
        Time after a spike in which a neuron does not listen, s.
    leak : str
        `membrane`, which grows with the membrane's voltage, or `constant`.

    Raises
    ------
    ParameterError
        A value is outside of its limits.
    """

    tau: float = option(20e-3, "Time constant of the membrane", unit="s", above=0.0)
    refractory: float = option(2e-3, "Time after a spike in which it does not listen", unit="s", least=0.0)
    leak: Leak = option("membrane", "Grows with the membrane's voltage, or is constant")


@dataclass(frozen=True, slots=True)
class Input(Group):
    """Channels on which events come from outside, or that send regular ones by themselves.

    Attributes
    ----------
    rate : float
        Of the regular events that each channel sends by itself, Hz; 0 where they come from outside.

    Raises
    ------
    ParameterError
        A value is outside of its limits.
    """

    rate: float = option(
        0.0,
        "Of regular events that it sends by itself; 0 for none",
        unit="Hz",
        least=0.0,
        most=10e3,
    )


@dataclass(frozen=True, slots=True)
class Connection:
    """Synapses from a population or an input to a population.

    Attributes
    ----------
    source, target : str
        Names of what is connected.
    weight : float
        Weight of every synapse; of all rules but `matrix`.
    rule : str
        Which pairs are connected: `all`, `one-to-one`, `random` or `matrix`.
    tau : float
        Time constant of the synapses, s.
    to_itself : bool
        Whether a neuron is connected to itself, within a population.
    probability : float
        Probability that a pair is connected, of `random`.
    seed : int
        Of the draws of `random`; two connections of as many neurons with one seed have the same pairs.
    matrix : tuple of tuple of float
        Weights, a row each target, of `matrix`; an array is taken too.

    Raises
    ------
    ParameterError
        A value is outside of its limits, the matrix is not a rectangle of finite numbers, or a value is given
        that is not of the rule.
    """

    source: str = required("Name of a population or an input", name="from")
    target: str = required("Name of a population", name="to")
    weight: float = option(1.0, "Of every synapse; below 0 it inhibits", unit="")
    rule: Rule = option("all", "Which pairs are connected")
    tau: float = option(10e-3, "Time constant of the synapses", unit="s", above=0.0)
    to_itself: bool = option(default=True, about="Whether a neuron of a population reaches itself")
    probability: float = option(1.0, "That a pair is connected, of random", unit="", above=0.0, most=1.0)
    seed: int = option(0, "Of the draws of random", least=0)
    matrix: Matrix = option((), "Weights, a row each target; or FILE.npz:NAME", unit="")

    def __post_init__(self) -> None:
        check_options(self, loose=("matrix",))
        try:
            given = np.array(self.matrix, dtype=np.float64)
        except (TypeError, ValueError):
            raise ParameterError(f"{self.name}.matrix: no rectangle of numbers; a row each target") from None
        if given.size and (given.ndim != 2 or not np.isfinite(given).all()):
            raise ParameterError(f"{self.name}.matrix: must have rows of finite numbers, one each target")
        if bool(given.size) != (self.rule == "matrix"):
            lacks = "missing, must be given with" if self.rule == "matrix" else "given, must not be without"
            raise ParameterError(f"{self.name}.matrix: {lacks} the rule matrix")
        object.__setattr__(self, "matrix", tuple(map(tuple, given.tolist())))
        for name, usual, rules in _OF_RULES:
            given_as = getattr(self, name)
            if given_as != usual and self.rule not in rules:
                raise ParameterError(
                    f"{self.name}.{name}: {given_as:g}, is not of the rule {self.rule}; leave it out, or take"
                    f" {' or '.join(rules)}"
                )

    @property
    def name(self) -> str:
        """Name of the connection, as `a -> b`."""
        return f"{self.source} -> {self.target}"


@dataclass(frozen=True, slots=True)
class Probe(Checked):
    """What of a network is an output: the mean rate of a population, as a filter sees it.

    Attributes
    ----------
    name : str
        Name of the output.
    population : str
        Name of the population.
    tau : float
        Time constant of the filter, s.

    Raises
    ------
    ParameterError
        The time constant is not above 0.
    """

    name: str = required("Its name")
    population: str = required("Name of the population")
    tau: float = option(50e-3, "Time constant of the filter", unit="s", above=0.0)


@dataclass(frozen=True, slots=True)
class Network:
    """A network: populations, inputs, what connects them, and its outputs.

    Attributes
    ----------
    populations : tuple of Population
        Its neurons, which are numbered one population after the other.
    inputs : tuple of Input
        What comes from outside.
    connections : tuple of Connection
        What connects them.
    probes : tuple of Probe
        Its outputs.

    Raises
    ------
    ParameterError
        There is no population, a name is given twice or cannot be shown on a line, or a connection does not
        fit what it connects.
    UnknownNameError
        A connection or probe names what is not there.
    """

    populations: tuple[Population, ...] = required("A population each", name="population")
    inputs: tuple[Input, ...] = option((), "An input each", name="input")
    connections: tuple[Connection, ...] = option((), "What connects them", name="connection")
    probes: tuple[Probe, ...] = option((), "An output each", name="probe")

    def __post_init__(self) -> None:
        if not self.populations:
            raise ParameterError("population: none, must be one or more")
        _check_names([*self.populations, *self.inputs], "")
        _check_names(self.probes, "probe.")
        for one in self.connections:
            matrix_of(self, one)
        for probe in self.probes:
            _one(self.populations, probe.population, "population")

    @property
    def neurons(self) -> int:
        """How many neurons it has."""
        return sum(p.size for p in self.populations)

    @property
    def channels(self) -> int:
        """How many channels its inputs have."""
        return sum(p.size for p in self.inputs)


G = TypeVar("G", bound=Group)


def spans(groups: Sequence[Group]) -> dict[str, range]:
    """Return the numbers of neurons (or channels) of each group by name: one group after the other."""
    found, first = {}, 0
    for group in groups:
        found[group.name] = range(first, first + group.size)
        first += group.size
    return found


def matrix_of(network: Network, one: Connection) -> F64:
    """Return the weights of a connection, float64[target, source], 0 where there is no synapse.

    Raises `UnknownNameError` for a name that is not there, and `ParameterError` for a rule or a matrix that
    does not fit.
    """
    every: list[Group] = [*network.populations, *network.inputs]
    source = _one(every, one.source, f"source of {one.name}")
    target = _one(network.populations, one.target, f"target of {one.name}")
    shape = target.size, source.size
    weights: F64
    if one.rule == "matrix":
        given: F64 = np.array(one.matrix)
        if given.shape != shape:
            raise ParameterError(
                f"{one.name}.matrix: {' x '.join(map(str, given.shape))}, must be {shape[0]} x {shape[1]};"
                " a row each target"
            )
        weights = given
    elif one.rule == "one-to-one":
        if shape[0] != shape[1]:
            raise ParameterError(f"{one.name}: {shape[1]} to {shape[0]}, must be as many for one-to-one")
        weights = np.diag(np.full(shape[0], one.weight))
    else:
        weights = np.full(shape, one.weight)
        if one.rule == "random":
            weights[np.random.default_rng(one.seed).random(shape) >= one.probability] = 0.0
    if one.source == one.target and not one.to_itself:
        np.fill_diagonal(weights, 0.0)
    return weights


def _check_names(groups: Iterable[Population | Input | Probe], path: str) -> None:
    seen: set[str] = set()
    for group in groups:
        if not group.name.strip() or not group.name.isprintable():
            raise ParameterError(f"{path}{group.name!r}: must be letters that show, on one line; rename it")
        if group.name in seen:
            raise ParameterError(f"{path}{group.name}: given twice, must be once; rename one")
        seen.add(group.name)


def _one(groups: Iterable[G], name: str, noun: str) -> G:
    known = {group.name: group for group in groups}
    if name not in known:
        raise unknown_name(noun, name, known)
    return known[name]
