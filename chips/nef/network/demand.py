"""What a network takes of a chip, as its description tells it before anything is calibrated or drawn.

A slot is a dimension of a population, or a current into its neurons. Each has a line, and a filter for each
time constant of what goes there; a population's neurons have encoder columns for all of its own.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from chips.nef.chip import NefChip, check_columns, check_filters, check_lines, check_room
from chips.nef.network.network import Connection, Ensemble, EnsembleArray, Network, Neurons

_Slot = tuple[str, object]  # of each member of an ensemble: its name, and what of it


class Demand(NamedTuple):
    """What a network takes.

    dimensions, currents: of each member of an ensemble, by the ensemble's name; filters, lines: in all.
    """

    dimensions: dict[str, int]
    currents: dict[str, int]
    filters: int
    lines: int


def check_demand(network: Network, chip: NefChip) -> None:
    """Raise `ParameterError` for a network that the chip has no room for."""
    found = demand_of(network)
    check_room(network.ensembles[-1].name if network.ensembles else "", network.neurons, chip)
    for name, dimensions in found.dimensions.items():
        check_columns(name, dimensions, found.currents[name])
    check_filters(found.filters)
    check_lines(found.lines)


def demand_of(network: Network) -> Demand:
    """Return what a network takes; ends that it does not have, and transforms that misfit, take nothing."""
    dimensions = {p.name: 1 if isinstance(p, EnsembleArray) else p.dimensions for p in network.ensembles}
    members = {p.name: 1 if isinstance(p, Ensemble) else p.ensembles for p in network.ensembles}
    slots: dict[str, set[_Slot]] = {name: set() for name in dimensions}
    filters: set[tuple[_Slot, float]] = set()
    for k, one in enumerate(network.connections):
        name = one.post.name if isinstance(one.post, Neurons) else one.post
        if name not in dimensions:
            continue
        ends = (
            _ends(one, k) if isinstance(one.post, Neurons) else [(name, d) for d in range(dimensions[name])]
        )
        slots[name].update(ends if isinstance(one.post, Neurons) else ())
        filters.update((end, one.synapse) for end in ends)
    currents = {name: len(held) for name, held in slots.items()}
    return Demand(
        dimensions,
        currents,
        sum(members[slot[0]] for slot, _ in filters),
        sum(members[name] * (dimensions[name] + currents[name]) for name in dimensions),
    )


def _ends(one: Connection, number: int) -> list[_Slot]:
    """Currents into neurons that connection `number` brings: one that many may share, or some of its own."""
    post, given = one.post, np.atleast_2d(np.asarray(one.transform, dtype=float))
    if not isinstance(post, Neurons) or given.ndim != 2:
        return []
    if given.shape[0] == 1:
        return [(post.name, ("all", post.scaled))]
    return [(post.name, (number, column)) for column in range(given.shape[1])]
