"""From the description of a network and its neurons' tuning curves to the arrays that are simulated.

Every end of a connection is a slot: a dimension of a population, or a current into its neurons, which is an
encoder of another kind. What goes to one slot with one time constant is added up before it is filtered, in
one lane; transforms are part of the decoders. Nodes and probes have lanes of their own, which no slot takes.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from time import perf_counter

import numpy as np

from chips.nef.calibration import USUAL
from chips.nef.chip import HEADROOM, Conditions
from chips.nef.kernel import ChipNet
from chips.nef.network.curves import TAU_RC, TAU_REF, Curves
from chips.nef.network.demand import check_demand
from chips.nef.network.kernel import DT, Net
from chips.nef.network.network import Connection, Ensemble, EnsembleArray, Network, Neurons, Probe, label
from chips.nef.network.solve import missed
from chips.nef.noise import noise_of, redrawn
from chips.nef.noise_kernel import NefNoise
from chips.nef.place import Placed, Row, at, bends_of, place, row_of_currents, with_decoders
from chips.nef.population import Population, evaluate, populate
from chips.nef.whole.kernel import Bends
from chips.noise import SiliconNoise
from circuits.arrays import F64, I64
from circuits.errors import ParameterError, TopologyError

_NOWHERE = -1  # slot of a lane that is read


@dataclass(frozen=True, slots=True, eq=False)
class Fit:
    """How well decoders fit.

    misses: root mean square of what they miss of each result over the points, in its unit, float64[results];
    seconds: for which they were sought, s.
    """

    misses: F64
    seconds: float


@dataclass(frozen=True, slots=True, eq=False)
class Built:
    """A network on neurons, ready to run.

    Attributes
    ----------
    network : Network
        The network.
    net : Net
        Arrays of the kernel.
    populations : mapping of str to tuple of Population
        Populations of each ensemble or array, by its name.
    drive : array
        Weights by which values of nodes act on lanes, dimensionless, float64[lanes, values of all nodes].
    given : mapping of str to slice
        Columns of a node there, by its name.
    read : mapping of str to slice
        Lanes of a node's input or of a probe, by its name.
    solved : mapping of Connection or Probe to tuple of array
        Decoders of what is decoded, value a Hz, float64[neurons, results] of each population before it.
    fits : mapping of Connection or Probe to tuple of Fit
        How well these fit, where they were solved for.
    placed : Placed or None
        Its codes on a chip; None of ideal neurons.
    chip : ChipNet or None
        What these are where it is run; None of ideal neurons.
    noise : NefNoise or None
        Noise of the chip's devices there.
    bends : Bends or None
        What the law with second-order effects bends there; None without such effects.
    where : Conditions or None
        Where it is run; None of ideal neurons.
    """

    network: Network
    net: Net
    populations: Mapping[str, tuple[Population, ...]]
    drive: F64
    given: Mapping[str, slice]
    read: Mapping[str, slice]
    solved: Mapping[Connection | Probe, tuple[F64, ...]]
    fits: Mapping[Connection | Probe, tuple[Fit, ...]]
    placed: Placed | None = None
    chip: ChipNet | None = None
    noise: NefNoise | None = None
    where: Conditions | None = None
    bends: Bends | None = None

    def neurons(self, name: str) -> slice:
        """Return the numbers of the neurons of the ensemble or array that is called `name`."""
        held = self.populations[name]
        return slice(held[0].first, held[-1].first + held[-1].ensemble.neurons)


def build(
    network: Network, curves: Curves, seed: int, taus: tuple[float, float] = (TAU_RC, TAU_REF)
) -> Built:
    """Draw the neurons of a network, and solve for its decoders.

    On the `Conditions` of a chip it is put there, and run there unless `moved` elsewhere. These calibrate the
    chip, so that `chips.nef.network.demand.check_demand` is for who makes them.

    Parameters
    ----------
    network
        The network.
    curves
        Curves of the neurons: ideal ones, or a chip's `Conditions`.
    seed
        Seed of everything that is drawn.
    taus
        Membrane time constant and refractory period of ideal neurons, s.

    Raises
    ------
    UnknownNameError
        A connection names what is not there.
    TopologyError
        A node has a function on its connection.
    ParameterError
        A function's result has the wrong shape or is not finite; a transform misfits; a rate is too high; a
        chip has no room.
    """
    if isinstance(curves, Conditions):
        check_demand(network, curves.chip)
    populations: dict[str, tuple[Population, ...]] = {}
    first = line = 0
    for part in network.ensembles:
        held = []
        for ensemble in _members(part):
            held.append(populate(ensemble, curves, first, seed, None, line, slowest_into(network, part.name)))
            first += ensemble.neurons
            line += ensemble.dimensions
        populations[part.name] = tuple(held)
    wiring = _Wiring(network, curves, seed, populations)
    for node in network.nodes:
        wiring.read[node.name] = wiring.reading(node.size_in, 0.0)
    for connection in network.connections:
        wiring.connect(connection)
    for probe in network.probes:
        wiring.probe(probe)
    built = Built(
        network, wiring.net(taus), populations, wiring.drive(), wiring.given, wiring.read, wiring.solved,
        wiring.fits,
    )  # fmt: skip
    if not isinstance(curves, Conditions):
        return built
    tau = np.array([tau for _, tau in wiring.lanes])
    placed = place(built.net, wiring.all, wiring.rows, tau, curves)
    return _on(built, placed, wiring.all, curves)


def moved(built: Built, chip: Conditions) -> Built:
    """Return the network with its codes and decoders on a chip as it is elsewhere, as at another temperature.

    Raises `ParameterError` for a network on ideal neurons.
    """
    if built.placed is None:
        raise ParameterError("network: on ideal neurons, which have no temperature; build it on a chip")
    held = [p for part in built.populations.values() for p in part]
    return _on(built, built.placed, held, chip)


def noisy(built: Built, noise: SiliconNoise) -> Built:
    """Return the network with noise of its chip's devices; `built` itself on ideal neurons."""
    if built.chip is None or built.where is None:
        return built
    where = replace(built.where, chip=replace(built.where.chip, noise=noise))
    return replace(built, where=where, noise=noise_of(built.chip, where))


def drawn_anew(built: Built, noise: SiliconNoise) -> Built:
    """Return the network with the draws of a seed and a trial, which shares all else with `built`.

    noise: differs from that of `built` by its seed and its trial alone; without any `built` stays as it is.
    """
    if built.noise is None or built.where is None:
        return built
    return replace(built, noise=redrawn(built.noise, built.where, noise))


def exchanged(built: Built, other: Built) -> Built:
    """Return a network on its chip with the decoders that were solved for the same network on another.

    Raises `ParameterError` for a network on ideal neurons.
    """
    if built.placed is None:
        raise ParameterError("network: on ideal neurons, whose decoders no die has; build it on a chip")
    held = [p for part in built.populations.values() for p in part]
    placed = with_decoders(built.placed, other.net)
    return _on(built, placed, held, placed.calibrated)


def _on(built: Built, placed: Placed, held: list[Population], where: Conditions) -> Built:
    """A network with its codes on a chip as it is `where`."""
    chip = at(placed, held, where)
    return replace(
        built,
        placed=placed,
        chip=chip,
        noise=noise_of(chip, where),
        where=where,
        bends=bends_of(placed, where),
    )


def slowest_into(network: Network, name: str) -> float:
    """Return the longest time constant of what brings an ensemble its vector, s; `USUAL` for nothing."""
    return max((c.synapse for c in network.connections if c.post == name), default=USUAL)


def _members(part: Ensemble | EnsembleArray) -> list[Ensemble]:
    if isinstance(part, Ensemble):
        return [part]
    return [replace(part.each, name=f"{part.name}[{k}]") for k in range(part.ensembles)]


class _Wiring:
    """Slots, lanes and decoders as they are collected."""

    def __init__(
        self, network: Network, curves: Curves, seed: int, populations: Mapping[str, tuple[Population, ...]]
    ) -> None:
        self.network, self.curves, self.seed = network, curves, seed
        self.by_name = populations
        self.all = [p for held in populations.values() for p in held]
        self.number = {id(p): k for k, p in enumerate(self.all)}
        self.rows = [
            [
                Row(own, HEADROOM * p.ensemble.radius, 1)
                for own in ((p.gain / p.ensemble.radius)[:, None] * p.encoders).T
            ]
            for p in self.all
        ]
        self.lanes: list[tuple[tuple[int, int], float]] = []  # population and slot in it, time constant
        self.shared: dict[tuple[tuple[int, int], float], int] = {}
        self.uniform: dict[tuple[int, bool], int] = {}  # population, scaled: slot of a current into all of it
        self.decoders: list[dict[int, F64]] = [{} for _ in self.all]
        self.driven: list[tuple[int, int, float]] = []
        self.read: dict[str, slice] = {}
        self.solved: dict[Connection | Probe, tuple[F64, ...]] = {}
        self.fits: dict[Connection | Probe, tuple[Fit, ...]] = {}
        self.lower: dict[tuple[int, float], F64] = {}  # population, regularisation: as of `_lower`
        self.given: dict[str, slice] = {}
        column = 0
        for node in network.nodes:
            self.given[node.name] = slice(column, column + node.size_out)
            column += node.size_out
        self.columns = column

    def reading(self, size: int, synapse: float) -> slice:
        """New lanes that no slot takes."""
        begin = len(self.lanes)
        self.lanes += [((_NOWHERE, 0), synapse)] * size
        return slice(begin, begin + size)

    def probe(self, probe: Probe) -> None:
        """Read a function of an ensemble."""
        as_connection = Connection(
            probe.target, probe.name, probe.function, probe.transform, probe.synapse, probe.points,
            probe.regularisation, probe.solver, probe.decoders,
        )  # fmt: skip
        values = self._decoders(as_connection, probe)
        self.solved[probe] = tuple(decoders for _, decoders, _ in values)
        matrix = _matrix(as_connection, self._size(values))
        lanes = self.reading(len(matrix), probe.synapse)
        self.read[probe.name] = lanes
        self._spread(values, matrix, [[k] for k in range(lanes.start, lanes.stop)])

    def connect(self, c: Connection) -> None:
        """Wire a connection."""
        if c.pre in self.by_name:
            values = self._decoders(c, c)
            self.solved[c] = tuple(decoders for _, decoders, _ in values)
            matrix, ends = self._ends(c, self._size(values))
            self._spread(values, matrix, ends)
            return
        node = self.network.node(c.pre)
        if c.function is not None:
            raise TopologyError(f"{label(c)}.function: on a node, must be on an ensemble; let the node do it")
        matrix, ends = self._ends(c, node.size_out)
        begin = self.given[c.pre].start
        for row, lanes in zip(matrix, ends, strict=True):
            self.driven += [(lane, begin + j, float(w)) for lane in lanes for j, w in enumerate(row) if w]

    def _decoders(self, c: Connection, key: Connection | Probe) -> list[tuple[int, F64, slice]]:
        """Of each population before a connection: number, float64[n, k], and which results they are.

        key: what `fits` calls it.
        """
        part = self.network.ensemble(c.pre)
        found, fits, at = [], [], 0
        for held in self.by_name[part.name]:
            p = held
            if c.decoders is not None:
                found.append((self.number[id(held)], c.decoders, slice(at, at + c.decoders.shape[1])))
                at += c.decoders.shape[1]
                continue
            if c.points is not None:
                points = np.asarray(c.points, dtype=float)
                p = populate(p.ensemble, self.curves, p.first, self.seed, points, p.line, p.tau)
            values = evaluate(c.function, p.points, label(c))
            if not isinstance(part, Ensemble) and values.shape[1] != 1:
                raise ParameterError(
                    f"{label(c)}.function: {values.shape[1]} results of a number of an array, must be 1"
                )
            if not p.rates.any():
                raise ParameterError(
                    f"{label(c)}: no neuron of {held.ensemble.name} fires at the points where its function is"
                    " fitted; choose others, or other intercepts"
                )
            begun = perf_counter()
            solved = c.solver(p.rates, values) if c.solver else p.decoders(values, self._lower(c, held, p))
            seconds = perf_counter() - begun
            fits.append(Fit(missed(p.rates, solved, values), seconds))
            found.append((self.number[id(held)], solved, slice(at, at + values.shape[1])))
            at += values.shape[1]
        self.fits[key] = tuple(fits)
        return found

    def _lower(self, c: Connection, held: Population, p: Population) -> F64:
        """What all functions that are fitted with one regularisation at a population's points share.

        p: `held` at the connection's points.
        """
        if p is not held:
            return p.factor(c.regularisation)
        key = (id(held), c.regularisation)
        if key not in self.lower:
            self.lower[key] = p.factor(c.regularisation)
        return self.lower[key]

    @staticmethod
    def _size(values: list[tuple[int, F64, slice]]) -> int:
        return int(values[-1][2].stop)

    def _spread(self, values: list[tuple[int, F64, slice]], matrix: F64, ends: list[list[int]]) -> None:
        """Add decoders times the matrix, float64[results, size], to the lanes of each result."""
        for number, decoders, which in values:
            weights = np.einsum("nk,rk->nr", decoders, matrix[:, which])
            held = self.decoders[number]
            for column, lanes in zip(weights.T, ends, strict=True):
                if column.any():
                    for lane in lanes:
                        held[lane] = held[lane] + column if lane in held else column

    def _ends(self, c: Connection, size: int) -> tuple[F64, list[list[int]]]:
        """Matrix from a vector of `size` to results, float64[results, size], and each result's lanes."""
        if isinstance(c.post, Neurons):
            return self._into_neurons(c, c.post, size)
        matrix = _matrix(c, size)
        if c.post in self.by_name:
            held = [self.number[id(p)] for p in self.by_name[c.post]]
            slots = [(k, d) for k in held for d in range(self.all[k].ensemble.dimensions)]
            ends = [[self._lane(s, c.synapse)] for s in slots]
        else:
            self.network.node(c.post)
            at = self.read[c.post]
            ends = [[k] for k in range(at.start, at.stop)]
            for k in range(at.start, at.stop):
                self.lanes[k] = ((_NOWHERE, 0), c.synapse)
        if len(ends) != len(matrix):
            raise ParameterError(
                f"{label(c)}.transform: {len(matrix)} results, must be the {len(ends)} that the end takes"
            )
        return matrix, ends

    def _into_neurons(self, c: Connection, post: Neurons, size: int) -> tuple[F64, list[list[int]]]:
        """As `_ends`, for currents: one result into all neurons, or a column of the transform a number."""
        self.network.ensemble(post.name)
        held = [self.number[id(p)] for p in self.by_name[post.name]]
        given = np.atleast_2d(np.asarray(c.transform, dtype=float))
        if given.shape == (1, size):
            slots = [(k, self._uniform(k, scaled=post.scaled)) for k in held]
            return _matrix(c, size), [[self._lane(slot, c.synapse) for slot in slots]]
        counts = [self.all[k].ensemble.neurons for k in held]
        if given.shape != (sum(counts), size) or not np.isfinite(given).all():
            raise ParameterError(
                f"{label(c)}.transform: shape {given.shape}, must be (1, {size}) or ({sum(counts)}, {size})"
            )
        parts = np.split(given, np.cumsum(counts)[:-1])
        ends: list[list[int]] = [[] for _ in range(size)]
        for k, part in zip(held, parts, strict=True):
            for j in range(size):
                self.rows[k].append(self._currents(part[:, j] * (self.all[k].gain if post.scaled else 1.0)))
                ends[j].append(self._lane((k, len(self.rows[k]) - 1), c.synapse))
        return np.eye(size), ends

    def _currents(self, values: F64) -> Row:
        """Stages of a slot of currents; ideal neurons have no limit."""
        if isinstance(self.curves, Conditions):
            return row_of_currents(values, self.curves)
        return Row(values, math.inf, 1)

    def _uniform(self, k: int, *, scaled: bool) -> int:
        p = self.all[k]
        if (k, scaled) not in self.uniform:
            self.rows[k].append(self._currents(p.gain if scaled else np.ones(p.ensemble.neurons)))
            self.uniform[k, scaled] = len(self.rows[k]) - 1
        return self.uniform[k, scaled]

    def _lane(self, slot: tuple[int, int], synapse: float) -> int:
        key = (slot, synapse)
        if key not in self.shared:
            self.shared[key] = len(self.lanes)
            self.lanes.append(key)
        return self.shared[key]

    def drive(self) -> F64:
        """What nodes put on lanes, float64[lanes, values]."""
        found = np.zeros((len(self.lanes), self.columns))
        for lane, column, weight in self.driven:
            found[lane, column] += weight
        return found

    def net(self, taus: tuple[float, float]) -> Net:
        """Arrays of the kernel."""
        slot = np.cumsum([0, *(len(r) for r in self.rows)])
        sizes = [p.ensemble.neurons for p in self.all]
        row = [0, *np.cumsum([n for n, rows in zip(sizes, self.rows, strict=True) for _ in rows])]
        blocks = [0, *np.cumsum([n * len(d) for n, d in zip(sizes, self.decoders, strict=True)])]
        columns = [np.stack([*d.values()], axis=1).ravel() for d in self.decoders if d]
        return Net(
            begin=_whole([0, *np.cumsum(sizes)]),
            slot=_whole(slot),
            bias=_joined([p.bias for p in self.all]),
            row=_whole(row[:-1]),
            encoder=_joined([r.values for rows in self.rows for r in rows]),
            lane=_whole(np.cumsum([0, *(len(d) for d in self.decoders)])),
            reaches=_whole([lane for d in self.decoders for lane in d]),
            decoder=_joined(columns) / DT,
            block=_whole(blocks[:-1]),
            keep=np.array([math.exp(-DT / tau) if tau > 0.0 else 0.0 for _, tau in self.lanes]),
            goes=_whole([_NOWHERE if k == _NOWHERE else slot[k] + j for (k, j), _ in self.lanes]),
            tau_rc=taus[0],
            tau_ref=taus[1],
        )


def _matrix(c: Connection, size: int) -> F64:
    """The transform as float64[results, size]."""
    given = np.asarray(c.transform, dtype=float)
    if not np.isfinite(given).all():
        raise ParameterError(f"{label(c)}.transform: not finite, must be numbers")
    if given.ndim == 0:
        return np.asarray(given * np.eye(size))
    if given.ndim != 2 or given.shape[1] != size:
        raise ParameterError(f"{label(c)}.transform: shape {given.shape}, must be (results, {size})")
    return given


def _whole(values: object) -> I64:
    return np.asarray(values, dtype=np.int64)


def _joined(parts: list[F64]) -> F64:
    return np.concatenate(parts) if parts else np.zeros(0)
