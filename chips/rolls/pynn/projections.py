"""Projections of PyNN on the chip: synapses with a level."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from pyNN import common, connectors
from pyNN.space import Space

from chips.rolls.pynn.cells import StaticSynapse
from chips.rolls.pynn.lacking import why_lacking
from chips.rolls.pynn.simulator import simulator
from circuits.arrays import Bools
from circuits.errors import ParameterError


@dataclass(slots=True, eq=False)
class Connection(common.Connection):  # type: ignore[misc]  # PyNN has no types
    """A synapse.

    presynaptic_index, postsynaptic_index : places within the two populations; origin, target : ids of cells.
    level : of the chip; delay : ms; label : of its projection.
    """

    presynaptic_index: int
    postsynaptic_index: int
    origin: int
    target: int
    level: int
    delay: float
    label: str

    @property
    def weight(self) -> float:
        """The level, as PyNN's weight; raises `ParameterError` for none, and after the first run."""
        return float(self.level)

    @weight.setter
    def weight(self, value: float) -> None:
        simulator.state.check_open(self.label)
        self.level = simulator.level_of(float(value), self.label)

    def as_tuple(self, *names: str) -> tuple[Any, ...]:
        """Return some of it, by name."""
        return tuple(getattr(self, name) for name in names)


class Projection(common.Projection):  # type: ignore[misc]  # PyNN has no types
    """Synapses from the cells of one population to the neurons of another."""

    _simulator = simulator
    _static_synapse_class = StaticSynapse

    def __init__(
        self, presynaptic_neurons: Any, postsynaptic_neurons: Any, connector: Any, synapse_type: Any = None,
        source: Any = None, receptor_type: str | None = None, space: Any = None, label: str | None = None,
    ) -> None:  # fmt: skip
        if not postsynaptic_neurons.receptor_types:
            raise ParameterError(
                f"pynn.{postsynaptic_neurons.label}: sources have no synapses; project to neurons"
            )
        if isinstance(synapse_type, StaticSynapse) and not isinstance(
            connector, connectors.FromListConnector
        ):
            called = label or f"{presynaptic_neurons.label}→{postsynaptic_neurons.label}"
            shape = presynaptic_neurons.size, postsynaptic_neurons.size
            _check_shape(synapse_type.parameter_space["weight"].base_value, shape, called)
        super().__init__(
            presynaptic_neurons, postsynaptic_neurons, connector, synapse_type, source, receptor_type,
            space or Space(), label,
        )  # fmt: skip
        simulator.state.check_open(self.label)
        if not isinstance(self.synapse_type, StaticSynapse):
            raise ParameterError(
                f"pynn.{self.label}: {type(self.synapse_type).__name__}, must be StaticSynapse; ROLLS has no"
                " other synapses here"
            )
        self.connections: list[Connection] = []
        self._connect(connector)
        if isinstance(connector, connectors.FromListConnector):
            _check_list(connector.conn_list, self)
        simulator.state.projections.append(self)

    def __len__(self) -> int:
        return len(self.connections)

    def _connect(self, connector: Any) -> None:
        if isinstance(connector, connectors.OneToOneConnector):  # PyNN's takes no population of one cell
            connector = connectors.ArrayConnector(np.eye(*self.shape, dtype=np.bool_), safe=connector.safe)
        elif isinstance(connector, connectors.FixedTotalNumberConnector) and not connector.with_replacement:
            connector = connectors.ArrayConnector(_distinct(connector, self), safe=connector.safe)
        elif isinstance(connector, connectors.FromFileConnector):  # to PyNN a file of one row is a row
            read = connector.file.read
            connector.file.read = lambda: np.atleast_2d(read())
        kind = type(connector)
        lacking = isinstance(connector, connectors.CSAConnector)
        try:
            if not lacking:
                connector.connect(self)
        except NotImplementedError:
            lacking = True
        if lacking:
            raise ParameterError(f"pynn.{self.label}: {kind.__name__}, {why_lacking(kind)}")

    def set(self, **attributes: Any) -> None:
        """Change weights of all synapses, until the first run.

        A weight is a number, a `RandomDistribution`, an array as `get` gives it, one number a synapse in the
        order of that array, or an expression of the distance. None is changed where one of them is no level.
        """
        simulator.state.check_open(self.label)
        for name in attributes:
            if name != "weight":
                raise ParameterError(f"pynn.{self.label}.{name}: cannot be changed; ROLLS has weights alone")
        super().set(**attributes)

    def __getitem__(self, place: int) -> Connection:
        return self.connections[place]

    def _set_attributes(self, parameter_space: Any) -> None:
        parameter_space.evaluate()
        weights = parameter_space["weight"]
        given = [weights[each.presynaptic_index, each.postsynaptic_index] for each in self.connections]
        for weight in given:
            simulator.level_of(float(weight), self.label)
        for synapse, weight in zip(self.connections, given, strict=True):
            synapse.weight = weight

    def _convergent_connect(
        self, presynaptic_indices: Any, postsynaptic_index: int, location_selector: Any = None, **given: Any
    ) -> None:
        origins = np.atleast_1d(presynaptic_indices)
        weights, delays = (np.broadcast_to(given[name], origins.shape) for name in ("weight", "delay"))
        if (delays > simulator.state.dt).any():
            raise ParameterError(
                f"pynn.{self.label}: delay {delays.max():g} ms, must be {simulator.state.dt:g} ms, the step;"
                " synapses of ROLLS have no delay, leave it out"
            )
        cells, target = self.pre.all_cells, int(self.post.all_cells[postsynaptic_index])
        self.connections += [
            Connection(
                int(k),
                int(postsynaptic_index),
                int(cells[k]),
                target,
                simulator.level_of(float(weight), self.label),
                float(delay),
                self.label,
            )
            for k, weight, delay in zip(origins, weights, delays, strict=True)
        ]


def _check_list(rows: Any, projection: Projection) -> None:
    """Raise `ParameterError` for a row with a cell that a projection does not have, which PyNN leaves out."""
    if not len(rows):
        return
    cells = np.asarray(rows, dtype=np.float64)[:, :2]
    there = (cells >= 0.0) & (cells < projection.shape) & (cells == np.round(cells))
    wrong = np.flatnonzero(~there.all(axis=1))
    if wrong.size:
        (pre, post), last = cells[wrong[0]], [size - 1 for size in projection.shape]
        raise ParameterError(
            f"pynn.{projection.label}: listed from {pre:g} to {post:g}, must be from cells 0 to {last[0]}"
            f" to cells 0 to {last[1]}"
        )


def _distinct(connector: Any, projection: Projection) -> Bools:
    """The pairs of a `FixedTotalNumberConnector` that are to differ; PyNN draws some of them again.

    Raises `ParameterError` where there are not as many, and where one shall not have its opposite.
    """
    itself = connector.allow_self_connections
    if itself not in {True, False}:
        raise ParameterError(
            f"pynn.{projection.label}.allow_self_connections: {itself}, must be True or False; draw the pairs"
            " yourself, for an ArrayConnector"
        )
    there: Bools = np.ones(projection.shape, dtype=np.bool_)
    if not itself and projection.pre == projection.post:
        np.fill_diagonal(there, val=False)
    pairs = np.flatnonzero(there)
    count = connector.n if isinstance(connector.n, int) else round(connector.n.next())
    if count > pairs.size:
        raise ParameterError(
            f"pynn.{projection.label}: {count} pairs, must be at most {pairs.size}; take fewer"
        )
    found: Bools = np.zeros(projection.shape, dtype=np.bool_)
    found.flat[connector.rng.permutation(pairs)[:count]] = True
    return found


def _check_shape(weights: Any, shape: tuple[int, int], label: str) -> None:
    """Raise `ParameterError` for an array of weights of another shape, of which PyNN takes a corner."""
    given = np.shape(weights) if isinstance(weights, np.ndarray) else ()
    if given and given != shape:
        told, asked = (" x ".join(map(str, each)) for each in (given, shape))
        raise ParameterError(f"pynn.{label}.weight: an array of {told}, must be {asked}; mend it")
