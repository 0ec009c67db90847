"""A nengo network in the chip's terms: what of it runs on neurons, and what stays in Python."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import nengo
import numpy as np
import scipy.linalg
from nengo.builder.ensemble import gen_eval_points, get_gain_bias
from nengo.builder.network import seed_network
from nengo.dists import Distribution, get_samples
from nengo.utils import least_squares_solvers as lstsq
from nengo.utils.builder import full_transform

from chips.nef.nengo.errors import RefusedError
from chips.nef.network.curves import IdealCurves
from chips.nef.network.network import Connection, Drawn, Ensemble, Network, Neurons, Node, Probe
from circuits.arrays import F64


class Plan:
    """A nengo network in the chip's terms, and what of it stays in Python."""

    def __init__(self, network: nengo.Network) -> None:
        self.source = network
        self.seeds: dict[Any, int] = {}
        seed_network(network, self.seeds, {})
        self.names = {e: f"{k}.{e.label or 'ensemble'}" for k, e in enumerate(network.all_ensembles)}
        self.ideal = _ideal(network.all_ensembles)
        self.points: dict[Any, F64] = {}
        self.drawn: dict[Any, Drawn] = {}
        self.currents: dict[Any, tuple[F64, F64]] = {}  # gains and biases of nengo's neurons
        self.sources: dict[Any, Connection | Probe | None] = {}  # connection of nengo's: ours, None of a node
        self.ensembles = tuple(self._ensemble(e) for e in network.all_ensembles)
        self.connections: list[Connection] = []
        self.nodes: list[Node] = []
        self.probes: list[Probe] = []
        self.fed: list[tuple[str, Any]] = []  # node of ours, connection from a node of nengo's
        self.read: dict[Any, str] = {}  # connection into a node, or probe: probe of ours
        for k, c in enumerate(network.all_connections):
            for end in (c.pre_obj, c.post_obj):
                self._check_there(end, str(c))
            self._connect(c, f"connection {k}")
        for k, p in enumerate(network.all_probes):
            self._check_there(p.obj, str(p))
            self._probe(p, f"probe {k}")

    def network(self) -> Network:
        """Return what runs on neurons."""
        return Network(self.ensembles, tuple(self.nodes), tuple(self.connections), tuple(self.probes))

    def _ensemble(self, e: Any) -> Ensemble:
        label = str(e)
        if e.noise is not None:
            raise RefusedError(f"{label}.noise: {e.noise}, the chip has no injected noise; leave it out")
        rng = np.random.RandomState(self.seeds[e])
        points = np.asarray(gen_eval_points(e, e.eval_points, rng=rng), dtype=float)
        drawn = isinstance(e.encoders, Distribution)
        encoders = get_samples(e.encoders, e.n_neurons, e.dimensions, rng=rng) if drawn else e.encoders
        encoders = np.array(encoders, dtype=float, ndmin=2)
        length = np.sqrt((encoders**2).sum(axis=1, keepdims=True))
        if not (length > 0.0).all():
            raise RefusedError(f"{label}.encoders: one of length 0, must point somewhere")
        if not e.normalize_encoders:
            raise RefusedError(f"{label}.normalize_encoders: False, encoders are unit vectors; leave it out")
        with np.errstate(divide="ignore", invalid="ignore"):  # what comes of it is refused
            gain, bias, rate, intercept = get_gain_bias(e, rng)
        self.points[e], self.currents[e] = points, (gain, bias)
        if not (np.asarray(intercept) < 1.0).all():
            given = "" if e.gain is None else ", by gain and bias"
            raise RefusedError(f"{label}.intercepts: {np.max(intercept):g}{given}, must be below 1")
        own = Drawn(
            np.asarray(rate, dtype=float), np.asarray(intercept, dtype=float), encoders / length, points
        )
        self.drawn[e] = own
        return Ensemble(self.names[e], e.n_neurons, e.dimensions, float(e.radius), drawn=own)

    def _check_there(self, end: Any, label: str) -> None:
        """Raise `RefusedError` for an end that is not of the network."""
        known = isinstance(end, nengo.Node | nengo.Ensemble | nengo.ensemble.Neurons)
        if known and _ensemble_of(end) not in self.seeds:
            raise RefusedError(f"{label}: {end} is not of this network; build the one that has it")

    def _connect(self, c: Any, name: str) -> None:
        label = str(c)
        if c.learning_rule is not None:
            raise RefusedError(f"{label}.learning_rule: {c.learning_rule}, the chip does not learn")
        self.sources[c] = None
        pre, post = c.pre_obj, c.post_obj
        if isinstance(post, nengo.Node):
            if not isinstance(pre, nengo.Node):
                given = self._decoded(c, label, tau_of_reading(c.synapse) or 0.0)
                self.probes.append(Probe(name, self.names[_ensemble_of(pre)], **given))
                self.sources[c], self.read[c] = self.probes[-1], name
            return
        if not isinstance(post, nengo.Ensemble | nengo.ensemble.Neurons):
            raise RefusedError(f"{label}.post: {post}, must be a node, an ensemble or its neurons")
        end: str | Neurons = self.names[_ensemble_of(post)]
        if isinstance(post, nengo.ensemble.Neurons):
            end = Neurons(self.names[post.ensemble], scaled=True)
        if isinstance(pre, nengo.Node):
            rows = matrix_of(c, label)
            transform: F64 | float = 1.0
            if isinstance(end, Neurons):
                rows, transform = self._currents(c, rows)
            self.nodes.append(Node(name, len(rows)))
            self.fed.append((name, (c, rows)))
            self.connections.append(Connection(name, end, None, transform, tau_of(c.synapse, label)))
            return
        given = self._decoded(c, label, tau_of(c.synapse, label))
        matrix = given["transform"]
        if isinstance(end, Neurons) and matrix.size and (matrix == matrix[0]).all():
            given["transform"] = matrix[:1]
        self.connections.append(Connection(self.names[_ensemble_of(pre)], end, **given))
        self.sources[c] = self.connections[-1]

    def _currents(self, c: Any, matrix: F64) -> tuple[F64, F64]:
        """What a node's value is multiplied with, float64[r, m], and currents of neurons, float64[1 or n, r].

        A column of stages is taken for each number that can differ: of a pass-through those that what ends
        at it spans, and one where all neurons get the same.
        """
        basis = None if c.function is not None else _basis(self.source, c.pre_obj, ())[c.pre_slice]
        if basis is not None and basis.shape[1] < matrix.shape[1]:
            rows, currents = np.linalg.pinv(basis), matrix @ basis
        else:
            rows, currents = matrix, np.eye(len(matrix))
        total = currents @ rows
        if total.size and np.allclose(total, total[0], rtol=1e-12, atol=0.0):
            return total[:1], np.ones((1, 1))
        return rows, currents

    def _decoded(self, c: Any, label: str, tau: float) -> dict[str, Any]:
        """Fields of a connection from an ensemble or its neurons."""
        common = {"transform": matrix_of(c, label), "synapse": tau}
        if isinstance(c.pre_obj, nengo.ensemble.Neurons):
            if c.function is not None:
                raise RefusedError(f"{label}.function: of neurons, must be of the ensemble")
            return {**common, "decoders": np.eye(c.pre_obj.size_out)}
        rng = np.random.RandomState(self.seeds.get(c, 0))
        e = c.pre_obj
        points = self.points[e]
        if c.eval_points is not None:
            points = np.asarray(gen_eval_points(e, c.eval_points, rng, c.scale_eval_points), dtype=float)
        common |= {"points": points, "function": _tabulated(c, label)}
        return {**common, **_solver(c.solver, rng, label)}

    def _probe(self, p: Any, name: str) -> None:
        target, label = p.obj, str(p)
        if isinstance(target, nengo.Ensemble) and p.attr == "decoded_output":
            size = target.size_out
            matrix = np.eye(size)[slice_of_probe(p)]
            given: dict[str, Any] = {"transform": matrix, "points": self.points[target]}
            given |= _solver(p.solver, np.random.RandomState(self.seeds[p]), label)
            tau = tau_of_reading(p.synapse) or 0.0
            self.probes.append(Probe(name, self.names[target], synapse=tau, **given))
            self.read[p] = name
        elif not (
            (isinstance(target, nengo.Node) and p.attr == "output")
            or (isinstance(target, nengo.ensemble.Neurons) and p.attr in ("output", "spikes"))
        ):
            raise RefusedError(f"{label}: {p.attr} of {target}, must be an output, or spikes of neurons")


def _ideal(ensembles: list[Any]) -> IdealCurves:
    """Time constants of all neurons; refuses what is no LIF, and neurons that differ."""
    found = set()
    for e in ensembles:
        kind = e.neuron_type
        if type(kind) is not nengo.LIF or kind.min_voltage != 0.0 or kind.amplitude != 1.0:
            raise RefusedError(f"{e}.neuron_type: {kind}, must be LIF with its usual voltage and amplitude")
        found.add((float(kind.tau_rc), float(kind.tau_ref)))
    if len(found) > 1:
        raise RefusedError(f"network: neurons of {len(found)} kinds of LIF, must all be alike")
    return IdealCurves(*found.pop()) if found else IdealCurves()


class Solving:
    """A solver of nengo's as a connection takes it; `info` is what it told of its last solution."""

    def __init__(self, solver: Any, rng: np.random.RandomState) -> None:
        self.info: dict[str, Any] = {}
        self._solver, self._rng = solver, rng

    def __call__(self, rates: F64, values: F64) -> F64:
        """Return decoders, float64[neurons, k], of values, float64[m, k], at rates of float64[m, neurons]."""
        found, self.info = self._solver(rates, values, rng=self._rng)
        return np.asarray(found)


def _solver(solver: Any, rng: np.random.RandomState, label: str) -> dict[str, Any]:
    """Fields of a connection or probe for a solver of nengo's."""
    if solver.weights:
        raise RefusedError(f"{label}.solver: {solver}, must not solve for weights")
    usual = type(solver) is nengo.solvers.LstsqL2 and type(solver.solver) is lstsq.Cholesky
    if usual and solver.reg > 0.0:
        return {"regularisation": solver.reg}
    return {"solver": Solving(solver, rng)}


def _basis(network: Any, node: Any, seen: tuple[Any, ...]) -> F64:
    """Columns that span what a node can give, float64[size_out, r]: of a pass-through what ends at it."""
    whole = np.eye(node.size_out)
    if node.output is not None or node in seen:
        return whole
    found = []
    for c in network.all_connections:
        if c.post_obj is node:
            given = matrix_of(c, str(c))
            if isinstance(c.pre_obj, nengo.Node) and c.function is None:
                given = given @ _basis(network, c.pre_obj, (*seen, node))[c.pre_slice]
            found.append(given)
    if not found:
        return np.zeros((node.size_out, 0))
    every = np.hstack(found)
    return whole if np.linalg.matrix_rank(every) == len(every) else scipy.linalg.orth(every)


def _ensemble_of(end: Any) -> Any:
    return end.ensemble if isinstance(end, nengo.ensemble.Neurons) else end


def slice_of_probe(p: Any) -> Any:
    """Return what a probe sees of its target."""
    return slice(None) if p.slice is None else p.slice


def matrix_of(c: Any, label: str) -> F64:
    """Return a connection's transform with its slice at the end.

    It is float64[size of post, size of what comes]; label: what errors call the connection.
    """
    if not isinstance(c.transform, nengo.Dense | nengo.transforms.NoTransform):
        raise RefusedError(f"{label}.transform: {type(c.transform).__name__}, must be dense")
    if isinstance(c.transform, nengo.Dense) and isinstance(c.transform.init, Distribution):
        raise RefusedError(f"{label}.transform: drawn from {c.transform.init}, must be numbers")
    sliced = isinstance(c.pre_obj, nengo.ensemble.Neurons)
    return np.asarray(full_transform(c, slice_pre=sliced, allow_scalars=False), dtype=float)


def tau_of(synapse: Any, label: str) -> float:
    """Return the time constant of a synapse, s, 0 for none; label: what errors call its connection."""
    if synapse is None:
        return 0.0
    tau = tau_of_reading(synapse)
    if tau is None:
        raise RefusedError(f"{label}.synapse: {synapse}, must be a low-pass or None")
    return tau


def tau_of_reading(synapse: Any) -> float | None:
    """Return the time constant of a low-pass, s; None of no synapse, and of others, which nengo filters."""
    usual = type(synapse) is nengo.Lowpass and synapse.analog and synapse.method == "zoh"
    return float(synapse.tau) if usual else None


def _tabulated(c: Any, label: str) -> Callable[[F64], F64]:
    """A connection's function on all points at once."""
    part, function = c.pre_slice, c.function

    def values(points: F64) -> F64:
        if function is None:
            return np.asarray(points[:, part])
        if isinstance(function, np.ndarray):
            return np.asarray(function, dtype=float)
        found = [function(x) for x in points[:, part]]
        if any(y is None for y in found):
            raise RefusedError(f"{label}.function: gives None, must give numbers")
        return np.array(
            [np.hstack(y) if isinstance(y, list | tuple) else np.ravel(y) for y in found], dtype=float
        )

    return values
