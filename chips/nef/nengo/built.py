"""What a nengo network has become on the chip, told as nengo tells it: samples of probes and built parts.

`data[probe]` is what the probe has seen, `data[ensemble]` nengo's `BuiltEnsemble` and `data[connection]` its
`BuiltConnection`. Gains and biases are those of nengo's own neurons at the rates and intercepts that were
drawn, as `nengo.utils.ensemble.tuning_curves` takes them; the decoders in `weights` are those that were
solved from the curves of this very chip, before they are rounded to its codes, and `solver_info` tells of
that.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import nengo
import numpy as np
from nengo.builder.connection import BuiltConnection
from nengo.builder.ensemble import BuiltEnsemble

from chips.nef.build import Built
from chips.nef.nengo.plan import Plan, Solving
from circuits.arrays import F64
from circuits.errors import UnknownNameError

_FIRST = 256  # samples for which there is room at first


class Samples:
    """What a probe has seen: rows of one array that grows, so that reading them copies nothing.

    Parameters
    ----------
    size
        How many numbers a sample has.
    """

    def __init__(self, size: int) -> None:
        self._rows, self._count = np.empty((_FIRST, size)), 0

    def append(self, value: F64) -> None:
        """Add a sample, float64[size]."""
        if self._count == len(self._rows):
            self._rows = np.concatenate([self._rows, np.empty_like(self._rows)])
        self._rows[self._count] = value
        self._count += 1

    def seen(self) -> F64:
        """Return the samples so far, float64[samples, size], which cannot be written."""
        found = self._rows[: self._count]
        found.setflags(write=False)
        return found


class Data(Mapping[Any, Any]):
    """Samples by probe, and built parts by what they were built from.

    Parameters
    ----------
    samples
        Samples of each probe.
    plan
        The nengo network in the chip's terms.
    built
        The network on its neurons.
    """

    def __init__(self, samples: Mapping[Any, Samples], plan: Plan, built: Built) -> None:
        self._samples, self._plan, self._built = samples, plan, built

    def __getitem__(self, key: Any) -> Any:
        """Return what a key has become; raises `UnknownNameError` for what is not in the network."""
        if key in self._samples:
            return self._samples[key].seen()
        if key in self._plan.names:
            return self._ensemble(key)
        if key in self._plan.sources:
            return self._connection(key)
        if key in self:
            return None
        raise UnknownNameError(f"{key}: not a probe, ensemble, connection or node of the network")

    def __contains__(self, key: object) -> bool:
        """Whether a key is a probe, ensemble, connection or node of the network."""
        return any(
            key in held for held in (self._samples, self._plan.names, self._plan.sources, self._rest())
        )

    def __iter__(self) -> Iterator[Any]:
        """Go through probes, ensembles, connections and nodes."""
        yield from self._samples
        yield from self._plan.names
        yield from self._plan.sources
        yield from self._rest()

    def __len__(self) -> int:
        """Return how many parts there are."""
        return sum(1 for _ in self)

    def _rest(self) -> list[Any]:
        """Parts of which nothing is built, for which nengo has None."""
        source = self._plan.source
        return [*source.all_nodes, source, *source.all_networks]

    def _ensemble(self, e: Any) -> BuiltEnsemble:
        drawn = self._plan.drawn[e]
        gain, bias = self._plan.currents[e]
        scaled = drawn.encoders * (gain / e.radius)[:, None]
        return BuiltEnsemble(
            drawn.points,
            drawn.encoders,
            drawn.intercept,
            drawn.rate,
            scaled,
            np.asarray(gain),
            np.asarray(bias),
        )

    def _connection(self, c: Any) -> BuiltConnection:
        own = self._plan.sources[c]
        plain = isinstance(c.transform, nengo.transforms.NoTransform)
        sample = np.ones(()) if plain else np.asarray(c.transform.sample(), dtype=float)
        if own is None or isinstance(c.pre_obj, nengo.ensemble.Neurons):
            return BuiltConnection(None, None, None if plain else sample, c.transform)
        (decoders,) = self._built.solved[own]
        points = None if isinstance(c.solver, nengo.solvers.NoSolver) else own.points
        return BuiltConnection(points, self._info(own), _times(sample, decoders.T), c.transform)

    def _info(self, own: Any) -> dict[str, Any]:
        """What nengo's solver tells; of the usual one, which is ours, its errors and its time, s."""
        if isinstance(own.solver, Solving):
            return own.solver.info
        (fit,) = self._built.fits[own]
        return {"rmses": fit.misses, "time": fit.seconds}


@dataclass(frozen=True, slots=True)
class Model:
    """What of nengo's built model a chip has.

    Attributes
    ----------
    params : mapping
        Samples and built parts, as `Simulator.data`.
    seeds : mapping
        Seed of each part that has one.
    toplevel : nengo.Network
        The network.
    dt : float
        Step of time, s.
    """

    params: Mapping[Any, Any]
    seeds: Mapping[Any, int]
    toplevel: Any
    dt: float

    def __getattr__(self, name: str) -> Any:
        """Refuse, by name, what only nengo's own simulator has; raises `AttributeError`."""
        raise AttributeError(
            f"Simulator.model.{name}: a chip has no signals and operators; params, seeds, toplevel and dt are"
            " there"
        )

    def __reduce__(self) -> Any:
        """Refuse to be pickled or copied; raises `TypeError`."""
        raise TypeError("Simulator.model: cannot be pickled or copied; pickle the network")


def _times(transform: F64, decoders: F64) -> F64:
    """A transform times decoders, float64[k, neurons]; one of a dimension is a diagonal."""
    if transform.ndim == 2:
        return np.asarray(transform @ decoders)
    return np.asarray(transform.reshape(-1, 1) * decoders if transform.ndim else transform * decoders)
