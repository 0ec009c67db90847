"""Gradients of metrics that search over a stimulus, at the edges at which the search ended.

At an edge a spike barely comes or does not. Beside it, where none comes, what decides on it still rises to
a peak, which is a smooth function P of the parameters p and of the searched stimulus x. At the edge P has one
value, whatever the die, so that the edge moves by

    dx/dp = - (dP/dp) / (dP/dx)

from one run and one run backwards. On the other side the spike's time would do too, but not as near: it goes
with the root of the distance. The rebound neuron's edges are within 0.6 % so, 100 us away.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from circuits.blocks.metric import Edge
from circuits.gradient.gradient import GRADIENT_RTOL, Gradients, gradients_of
from circuits.gradient.measure import Extreme
from circuits.gradient.stimulus import own_moves

_FARTHEST = 64.0  # times the resolution of a search: how far beside its edge no spike is looked for; ours


def gradients_at_edges(
    name: str, unit: str, value: float, edges: Sequence[Edge], *, rtol: float = GRADIENT_RTOL
) -> Gradients:
    """Return the gradients of a metric that is a sum of edges, one run and one run backwards for each.

    Parameters
    ----------
    name, unit, value
        The metric.
    edges
        Where its search ended, at least one.
    rtol
        Local error of a step of the transients, relative to the larger of |v| and 1 V.

    Raises
    ------
    SolverError
        The solver gives up, or the way backwards is singular.
    """
    parts = [_at(edge, rtol) for edge in edges]
    by, notes = sum(part.by for part in parts), dict.fromkeys(note for part in parts for note in part.notes)
    told = "; ".join(filter(None, notes))
    return replace(
        parts[0], measures=(name,), units=(unit,), values=np.array([value]), notes=(told,), by=np.asarray(by)
    )


def _at(edge: Edge, rtol: float) -> Gradients:
    """What moves an edge, times its weight; NaN where it is not known."""
    stimulus, peak = f"source.{edge.source}.time", Extreme(edge.node, begin=edge.begin, rivals=False)
    away, found = edge.resolution, None
    while found is None or (_spikes(found, edge.port) and away < _FARTHEST * edge.resolution):
        machine = edge.beside(away)
        moves = [move for move in own_moves(machine) if move.step.label == stimulus]
        found = gradients_of(machine, (peak,), rtol=rtol, moves=moves)
        away *= 2.0
    own = found.labels.index(stimulus)
    slope, note = float(found.by[0, own]), found.notes[0]
    if _spikes(found, edge.port):
        slope, note = np.nan, f"{edge.source}: a spike comes on both sides of the edge"
    elif not slope or not np.isfinite(slope):
        slope, note = np.nan, note or f"{edge.source}: does not move the peak of {edge.node} at the edge"
    keep = [k for k in range(len(found.labels)) if k != own]
    return replace(
        found, notes=(note,), sigma=found.sigma[keep], by=edge.weight * -found.by[:, keep] / slope,
        labels=tuple(found.labels[k] for k in keep), of_units=tuple(found.of_units[k] for k in keep),
    )  # fmt: skip


def _spikes(found: Gradients, port: str) -> bool:
    """Whether a spike came at a port in the run."""
    return found.result is not None and found.result.spikes[port].size > 0
