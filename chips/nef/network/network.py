"""Networks of the Neural Engineering Framework as plain data: what is represented, and computed.

An `Ensemble` of neurons represents a vector x; a `Connection` decodes a function f of it, transforms it by a
matrix T, low-passes it, and adds it to what another represents; a recurrent one makes dynamics. `Node`s are
the world: their values come from outside, or from a Python function of what is connected to them; a `Probe`
reads. Parts name each other, so that networks are joined by `join` and said once for any neurons:
`chips.nef.build` puts them on tuning curves.

Source: Stöckel 2017, section II.B; Eliasmith and Anderson, "Neural Engineering" (2003).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from circuits.arrays import F64
from circuits.errors import ParameterError, TopologyError, UnknownNameError, unknown_name

Function = Callable[[F64], F64]  # float64[points, dimensions] -> float64[points, results]
REGULARISATION = 0.1  # nengo's default
Solver = Callable[[F64, F64], F64]
Callback = Callable[[float, F64], F64]  # time in s, float64[size_in] -> float64[size_out]


@dataclass(frozen=True, slots=True, eq=False)
class Drawn:
    """Neurons that are given one by one instead of drawn.

    rate, intercept: float64[n], as of an ensemble; encoders: of any length above 0, float64[n, d]; points:
    where functions are fitted, float64[m, d].
    """

    rate: F64
    intercept: F64
    encoders: F64
    points: F64


@dataclass(frozen=True, slots=True, eq=False)
class Ensemble:
    """Neurons that together represent a vector x.

    A neuron with unit encoder e, gain and bias from its maximum rate and its intercept gets the current

        J = gain <e, x> / radius + bias

    Attributes
    ----------
    name : str
        Name of the ensemble.
    neurons : int
        How many neurons it has.
    dimensions : int
        Length of x.
    radius : float
        Largest length of x that is represented well, in the unit of x.
    max_rates : (float, float)
        Rates at <e, x> = radius, drawn evenly from low to high, Hz.
    intercepts : (float, float)
        <e, x> / radius where a neuron begins to fire, dimensionless, drawn evenly from low to high.
    encoders : sequence
        Encoders of any length above 0, dimensionless, float64[k, dimensions], taken in turn; drawn evenly in
        all directions if empty.
    drawn : Drawn or None
        Its neurons, if they are chosen already.

    Raises
    ------
    ParameterError
        A number breaks its rule, or the encoders have another shape or length 0.
    """

    name: str
    neurons: int
    dimensions: int = 1
    radius: float = 1.0
    max_rates: tuple[float, float] = (200.0, 400.0)
    intercepts: tuple[float, float] = (-1.0, 0.9)
    encoders: Sequence[Sequence[float]] = ()
    drawn: Drawn | None = None

    def __post_init__(self) -> None:
        for name in ("neurons", "dimensions"):
            if getattr(self, name) < 1:
                raise ParameterError(f"{self.name}.{name}: {getattr(self, name)}, must be at least 1")
        if not 0.0 < self.radius < np.inf:
            raise ParameterError(f"{self.name}.radius: {self.radius:g}, must be above 0 and finite")
        low, high = self.max_rates
        if not 0.0 < low <= high < np.inf:
            raise ParameterError(f"{self.name}.max_rates: {low:g} to {high:g} Hz, must be above 0, low first")
        low, high = self.intercepts
        if not -1.0 <= low <= high < 1.0:
            raise ParameterError(f"{self.name}.intercepts: {low:g} to {high:g}, must be from -1 to below 1")
        given = np.asarray(self.encoders, dtype=float)
        if given.size and (given.ndim != 2 or given.shape[1] != self.dimensions):
            raise ParameterError(f"{self.name}.encoders: shape {given.shape}, must be (k, {self.dimensions})")
        if given.size and not (np.hypot.reduce(given, axis=1) > 0.0).all():
            raise ParameterError(f"{self.name}.encoders: one of length 0, must point somewhere")


@dataclass(frozen=True, slots=True, eq=False)
class EnsembleArray:
    """Ensembles that are alike, of one dimension each, and together represent a vector.

    A function on a connection from it takes each number by itself.

    Attributes
    ----------
    each : Ensemble
        What the ensembles are like; its name is the array's.
    ensembles : int
        How many there are.

    Raises
    ------
    ParameterError
        There is none, or they have more than one dimension.
    """

    each: Ensemble
    ensembles: int

    def __post_init__(self) -> None:
        if self.ensembles < 1 or self.each.dimensions != 1:
            raise ParameterError(
                f"{self.each.name}: {self.ensembles} ensembles of {self.each.dimensions} dimensions, must be"
                " at least one, of one dimension"
            )

    @property
    def name(self) -> str:
        """Name of the array."""
        return self.each.name


@dataclass(frozen=True, slots=True, eq=False)
class Node:
    """An end of a network towards the world.

    name: what it is called. size_out: length of what it gives. size_in: length of what is connected to it.
    output: makes what it gives, from the time (s) and what comes in; without it the value is set from
    outside, 0 at first.
    """

    name: str
    size_out: int = 0
    size_in: int = 0
    output: Callback | None = None


@dataclass(frozen=True, slots=True)
class Neurons:
    """The neurons of an ensemble or array themselves, as the end of a connection: currents, not a vector.

    A current of 1 is an ideal neuron's threshold. A transform of one row acts on all neurons alike.

    Attributes
    ----------
    name : str
        Name of the ensemble or array.
    scaled : bool
        Whether a neuron gets the current times its gain, as nengo has it: -2 then silences any within its
        radius.
    """

    name: str
    scaled: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class Connection:
    """What `post` gets of `pre`: T f(x), through a low-pass.

    Attributes
    ----------
    pre : str
        Name of an ensemble, array or node.
    post : str or Neurons
        Name of what it goes to, or the neurons that it goes to.
    function : function or None
        f, of an ensemble's vector; the vector itself if None.
    transform : number or array
        T, dimensionless: a number, or float64[size of post, size of f].
    synapse : float
        Time constant of the low-pass, s; 0 for none.
    points : array or None
        Where f is fitted, in the unit of x, float64[n, dimensions]; drawn evenly in the ensemble's ball
        unless given.
    regularisation : float
        Regularisation of the fit, a share of the highest rate.
    solver : function or None
        Makes decoders, float64[neurons, k], of rates at the points (Hz, float64[m, neurons]) and values there
        (float64[m, k]), in the place of regularised least squares.
    decoders : array or None
        Value for each Hz, float64[neurons, k], in the place of a function.

    Raises
    ------
    ParameterError
        The time constant is negative or infinite, or the regularisation not above 0.
    """

    pre: str
    post: str | Neurons
    function: Function | None = None
    transform: ArrayLike = 1.0
    synapse: float = 0.005
    points: F64 | None = None
    regularisation: float = REGULARISATION
    solver: Solver | None = None
    decoders: F64 | None = None

    def __post_init__(self) -> None:
        if not 0.0 <= self.synapse < np.inf:
            raise ParameterError(f"{label(self)}.synapse: {self.synapse:g} s, must be >= 0 and finite")
        if not 0.0 < self.regularisation < np.inf:
            raise ParameterError(f"{label(self)}.regularisation: {self.regularisation:g}, must be above 0")


@dataclass(frozen=True, slots=True, eq=False)
class Probe:
    """Reads T f(x) of an ensemble or array, through a low-pass.

    Attributes
    ----------
    name : str
        Name of the probe.
    target : str
        Name of the ensemble or array.
    function : function or None
        f, of the ensemble's vector; the vector itself if None.
    transform : number or array
        T, dimensionless: a number, or float64[size, size of f].
    synapse : float
        Time constant of the low-pass, s; 0 for none.
    points : array or None
        Where f is fitted, in the unit of x, float64[n, dimensions]; drawn evenly in the ensemble's ball
        unless given.
    regularisation : float
        Regularisation of the fit, a share of the highest rate.
    solver : function or None
        Makes decoders, as of `Connection`.
    decoders : array or None
        Value for each Hz, float64[neurons, k], in the place of a function.
    """

    name: str
    target: str
    function: Function | None = None
    transform: ArrayLike = 1.0
    synapse: float = 0.01
    points: F64 | None = None
    regularisation: float = REGULARISATION
    solver: Solver | None = None
    decoders: F64 | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Network:
    """A network: its parts by name, and the connections between them.

    Attributes
    ----------
    ensembles : tuple of Ensemble or EnsembleArray
        Its neurons.
    nodes : tuple of Node
        Its ends towards the world.
    connections : tuple of Connection
        What connects them.
    probes : tuple of Probe
        What is read of it.

    Raises
    ------
    TopologyError
        Two parts have one name.
    """

    ensembles: tuple[Ensemble | EnsembleArray, ...] = ()
    nodes: tuple[Node, ...] = ()
    connections: tuple[Connection, ...] = ()
    probes: tuple[Probe, ...] = ()

    def __post_init__(self) -> None:
        names = [p.name for p in (*self.ensembles, *self.nodes, *self.probes)]
        for name in names:
            if names.count(name) > 1:
                raise TopologyError(f"{name}: twice in a network; give each part a name of its own")

    @property
    def neurons(self) -> int:
        """How many neurons the network takes."""
        return sum(neurons_of(e) for e in self.ensembles)

    def ensemble(self, name: str) -> Ensemble | EnsembleArray:
        """Return the ensemble or array called `name`; raises `UnknownNameError` where there is none."""
        for found in self.ensembles:
            if found.name == name:
                return found
        raise self._unknown("ensemble", name)

    def node(self, name: str) -> Node:
        """Return the node called `name`; raises `UnknownNameError` where there is none."""
        for found in self.nodes:
            if found.name == name:
                return found
        raise self._unknown("node", name)

    def _unknown(self, kind: str, name: str) -> UnknownNameError:
        return unknown_name(kind, name, [p.name for p in (*self.ensembles, *self.nodes)])


def join(parts: Iterable[Network]) -> Network:
    """Return one network of several, whose connections may name parts of the others."""
    held = list(parts)
    return Network(
        tuple(e for p in held for e in p.ensembles),
        tuple(n for p in held for n in p.nodes),
        tuple(c for p in held for c in p.connections),
        tuple(r for p in held for r in p.probes),
    )


def neurons_of(part: Ensemble | EnsembleArray) -> int:
    """Return how many neurons an ensemble or array has."""
    return part.neurons if isinstance(part, Ensemble) else part.ensembles * part.each.neurons


def label(connection: Connection) -> str:
    """Return what errors call a connection."""
    post = connection.post
    return f"{connection.pre}->{post if isinstance(post, str) else f'{post.name}.neurons'}"
