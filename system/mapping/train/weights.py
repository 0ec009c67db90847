"""The weights that are trained: those that a network gives as a matrix, as a chip has them.

Forwards each is what the mapping makes of it, on each die: so many events of virtual synapses, or a level.
Backwards it counts as if it were that itself (straight through).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from chips.rolls.circuit import FILTERS
from circuits.arrays import F64, I64, Bools
from circuits.errors import ParameterError
from system.mapping.network import Network, matrix_of, spans
from system.mapping.rolls.filters import SIGN
from system.mapping.rolls.levels import Repeats
from system.mapping.rolls.map import Together, asked_charges, charges_by, chosen_of
from system.mapping.rolls.mapped import Mapped, PlacedFilter
from system.mapping.train.form import Weights
from system.mapping.train.ratios import Ratios


class OnDies(NamedTuple):
    """Weights of all filters on dies, and by how much each asked-for charge moves them, of the same shape."""

    weights: tuple[Weights, ...]
    slopes: tuple[F64, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Trainable:
    """What can be trained of a network.

    mapped : the network on the chip; matrices : of all connections, float64[target, source]; free : which
    entries are trained; least, most : bounds of each connection's.
    """

    mapped: Mapped
    matrices: tuple[F64, ...]
    free: tuple[Bools, ...]
    least: tuple[float, ...]
    most: tuple[float, ...]

    def on_dies(self, matrices: Sequence[F64], dies: Sequence[Ratios]) -> OnDies:
        """Return the weights as dies have them, from matrices of all connections."""
        network, found, slopes = self.mapped.network, [], []
        charges = charges_by(self._charges(matrices), network)
        for one in self.mapped.filters:
            jump, chosen = _jumps(one.name, charges[one.name] / one.tau)
            ratio = np.stack([_ratio(d.weights[one.name], chosen, self.mapped.neurons) for d in dies])
            both = [np.zeros((len(dies), network.neurons, k)) for k in (network.neurons, network.channels)]
            both[_kind(one)] = jump * ratio
            found.append(Weights(*both))
            slopes.append(ratio / one.tau)
        return OnDies(tuple(found), tuple(slopes))

    def derivatives(self, matrices: Sequence[F64], on: OnDies, found: Sequence[Weights]) -> tuple[F64, ...]:
        """Return the derivatives by the matrices, of those by the weights on dies."""
        network, currents = self.mapped.network, self._currents()
        at, channels = spans(network.populations), spans(network.inputs)
        sources, by = {**at, **channels}, [np.zeros(m.shape) for m in matrices]
        for asked in self._charges(matrices):
            rise = np.zeros_like(asked.charge)
            for one, slope, each in zip(self.mapped.filters, on.slopes, found, strict=True):
                if asked.inner == (_kind(one) == 0):
                    sign = SIGN[one.name]
                    share = np.heaviside(sign * asked.charge, 0.5)  # at 0 both signs are as near
                    rise += sign * share * (each[_kind(one)] * slope).sum(axis=0)
            for k in asked.members:
                c = network.connections[k]
                by[k] = currents[c.target] * c.tau * rise[np.ix_(at[c.target], sources[c.source])]
        return tuple(by)

    def moved(self, matrices: Sequence[F64], by: Sequence[F64]) -> tuple[F64, ...]:
        """Return matrices moved, within their bounds."""
        every = zip(matrices, by, self.free, self.least, self.most, strict=True)
        return tuple(
            np.where(free, np.clip(m + change, least, most), m) for m, change, free, least, most in every
        )

    def network(self, matrices: Sequence[F64]) -> Network:
        """Return the network with other matrices."""
        every = zip(self.mapped.network.connections, matrices, self.free, strict=True)
        found = (replace(c, matrix=m) if free.any() else c for c, m, free in every)  # type: ignore[arg-type]
        return replace(self.mapped.network, connections=tuple(found))

    def _charges(self, matrices: Sequence[F64]) -> tuple[Together, ...]:
        return asked_charges(self.mapped.network, self._currents(), matrices)

    def _currents(self) -> dict[str, float]:
        return {p.name: p.current for p in self.mapped.placed}


def trainable(mapped: Mapped) -> Trainable:
    """Return what can be trained of a mapped network; raises `ParameterError` where nothing can.

    These are entries other than 0 of the connections with a matrix. They stay within the largest one that
    connections of their kind (from neurons or from channels) have, and have the signs that are there.
    """
    network = mapped.network
    at, names = spans(network.populations), {f.name for f in mapped.filters}
    matrices = tuple(matrix_of(network, c) for c in network.connections)
    free = tuple(
        (m != 0.0) & (c.rule == "matrix") for c, m in zip(network.connections, matrices, strict=True)
    )
    if not any(each.any() for each in free):
        raise ParameterError("connection: none with weights in a matrix, which are trained; give it one")
    least, most = [], []
    for c in network.connections:
        inner = c.source in at
        alike = zip(network.connections, matrices, strict=True)
        largest = max(float(np.abs(m).max()) for other, m in alike if (other.source in at) == inner)
        excite, inhibit = (name in names for name in (FILTERS[:2] if inner else FILTERS[2:]))
        least.append(-largest if inhibit else 0.0)
        most.append(largest if excite else 0.0)
    return Trainable(mapped, matrices, free, tuple(least), tuple(most))


def _kind(one: PlacedFilter) -> int:
    """Whether a filter's events come from channels, by number: the place in `Weights`."""
    return int(one.name in FILTERS[2:])


def _jumps(name: str, charge: F64) -> tuple[F64, I64]:
    """Jumps of S that the mapping makes of those asked for (A), and the events or level of each."""
    if not charge.any():
        return charge, np.zeros(charge.shape, np.int64)
    found = chosen_of(name, charge)
    if isinstance(found, Repeats):
        return np.asarray(found.charge * found.chosen, dtype=np.float64), found.chosen
    return np.concatenate((np.zeros(1), found.charges))[found.chosen], found.chosen


def _ratio(weights: F64, chosen: I64, at: I64) -> F64:
    """Ratios of a die for what was chosen, float64 of its shape; at: neurons of the chip."""
    rows = np.arange(chosen.shape[0])[:, None]
    if weights.ndim == 2:
        cumulative = weights[:, at]
        return np.asarray(cumulative[chosen, rows])
    return np.asarray(weights[:, at][chosen, rows, np.arange(chosen.shape[1])[None]])
