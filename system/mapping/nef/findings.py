"""What the NEF chip makes of a network of values on the nominal die: each finding has a number.

rates      tuning curves, as counted on the bench, beside those of the ideal neurons that are drawn alike
function   what is decoded of these beside f(x), over the points of the fit, as a share of f's largest value
weights    decoding weights after they are rounded to the chip's codes
synapse    time constants of the filters
reach      what may arrive at an ensemble of others, beside the full scale where converters clip
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from chips.nef.build import Built
from chips.nef.chip import HEADROOM
from chips.nef.network.network import Connection, Probe, label
from chips.nef.population import Population, evaluate
from circuits.arrays import F64
from circuits.errors import ParameterError
from system.mapping.report import Finding, spread, value

OFF = 0.25  # by which a filter may be faster than it was asked to be; ours, as on ROLLS


def check_synapses(built: Built) -> None:
    """Raise `ParameterError` for a time constant that the chip's slowest filter does not come near."""
    if built.where is None:
        return
    for c in built.network.connections:
        got = float(built.where.filters(np.array([c.synapse])).tau[0])
        if got < (1.0 - OFF) * c.synapse:
            raise ParameterError(
                f"{label(c)}.synapse: {c.synapse:g} s, must be <= {got / (1.0 - OFF):.3g} s, the slowest"
                f" filter of the chip has {got:.3g} s; lower it"
            )


def findings_of(built: Built, ideal: Built) -> Iterator[Finding]:
    """Give the findings of a network on the nominal die; ideal: the same on ideal neurons."""
    network = built.network
    for name, (own,) in built.populations.items():
        (other,) = ideal.populations[name]
        off = float(np.sqrt(np.mean((own.rates - other.rates) ** 2) / np.mean(other.rates**2)))
        yield spread(name, "rates", off, "rms of the tuning curves, of ideal neurons that are drawn alike")
    every: list[Connection | Probe] = [*network.connections, *network.probes]
    for one in every:
        if one in built.solved:
            where = one.name if isinstance(one, Probe) else label(one)
            errors = [_decoding(where, each, one) for each in (built, ideal)]
            note = f"rms over f's largest value; ideal neurons {errors[1]:.2%}"
            yield spread(where, "function", errors[0], note)
    yield from _weights(built)
    yield from _synapses(built)
    yield from _reaches(built)


def decoded(built: Built, one: Connection | Probe, where: str) -> tuple[F64, F64]:
    """Return what a function should be at the points of its fit, and what is decoded, float64[m, k]."""
    p = _before(built, one)
    return evaluate(one.function, p.points, where), p.rates @ built.solved[one][0]


def _before(built: Built, one: Connection | Probe) -> Population:
    return built.populations[one.target if isinstance(one, Probe) else one.pre][0]


def _decoding(where: str, built: Built, one: Connection | Probe) -> float:
    wanted, got = decoded(built, one, where)
    most = float(np.abs(wanted).max())
    return float(np.sqrt(np.mean((got - wanted) ** 2))) / most if most else 0.0


def _weights(built: Built) -> Iterator[Finding]:
    """How far decoding weights are off those that were solved, root mean square over the largest."""
    if built.placed is None or not built.net.decoder.size:
        return
    solved, written = built.net.decoder, built.placed.net.decoder
    off = float(np.sqrt(np.mean((written - solved) ** 2)) / max(float(np.abs(solved).max()), 1e-300))
    yield spread("network", "weights", off, "rms over the largest, rounded to 10 bits")


def _synapses(built: Built) -> Iterator[Finding]:
    if built.where is None:
        return
    for tau in sorted({c.synapse for c in built.network.connections}):
        got = float(built.where.filters(np.array([tau])).tau[0])
        note = "of a filter, the fastest is 0.5 ms" if got > tau else "of a filter, the slowest is 0.5 s"
        yield value("filters", "synapse", tau, got, "s", note if abs(got - tau) > 0.01 * tau else "")


def _reaches(built: Built) -> Iterator[Finding]:
    """Ensembles at which more may arrive than their converters take; what inputs bring is not known."""
    network = built.network
    nodes = [node.name for node in network.nodes]
    for name, (p,) in built.populations.items():
        come = [c for c in network.connections if c.post == name and c.pre not in nodes]
        most = sum((_largest(built, c, p.ensemble.dimensions) for c in come), np.zeros(p.ensemble.dimensions))
        reach, full = float(np.max(most, initial=0.0)), HEADROOM * p.ensemble.radius
        if reach > full:
            note = "what other ensembles may bring together is clipped; a larger radius takes it"
            yield value(name, "reach", reach, full, "", note)


def _largest(built: Built, c: Connection, size: int) -> F64:
    """Largest size of each number that a connection brings, float64[size]."""
    wanted, _ = decoded(built, c, label(c))
    given = np.asarray(c.transform, dtype=float)
    return np.asarray(np.abs(wanted @ (given * np.eye(size) if given.ndim == 0 else given).T).max(axis=0))
