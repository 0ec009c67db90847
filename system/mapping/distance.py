"""How far two runs of a network are apart: rates, spike trains, outputs.

    van Rossum   D^2 = 1 / tau * integral of (f - g)^2 dt,  f = sum of e^(-(t - t_k) / tau) after each spike

so that one spike more or less, far from others, adds 1/2 to D^2 (van Rossum 2001). The integral is exact: of
two spikes t and u it is e^(-|t - u| / tau) / 2, summed over all pairs with the sign of their trains.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from circuits.arrays import F64, Bools
from system.mapping.dynamics import STEP, Trains, population_rates, rates_of
from system.mapping.network import Network, Probe, spans

TAU = 20e-3  # s, of the distance between spike trains; ours


@dataclass(frozen=True, slots=True)
class Distance:
    """How far a run is from another.

    rates : mean rate of each population less that of the other, Hz; trains : van Rossum distance of a
    neuron's spike trains, root mean square over each population; outputs : root mean square of the
    difference of each output over its largest value in the other run, NaN where that is 0.
    """

    rates: dict[str, float]
    trains: dict[str, float]
    outputs: dict[str, float]


def distance(network: Network, one: Trains, other: Trains, begin: float, end: float) -> Distance:
    """Return how far `one` is from `other`; rates and outputs are from `begin` to `end`, s."""
    means = [population_rates(network, rates_of(run, network.neurons, begin, end)) for run in (one, other)]
    trains = {}
    for name, at in spans(network.populations).items():
        squares = [van_rossum(times_of(one, k), times_of(other, k), TAU) ** 2 for k in at]
        trains[name] = float(np.sqrt(np.mean(squares)))
    outputs = {}
    for probe in network.probes:
        a, b = (output(network, probe, run, end) for run in (one, other))
        outputs[probe.name] = apart(a, b, np.arange(a.size) * STEP >= begin)
    return Distance({k: means[0][k] - means[1][k] for k in means[0]}, trains, outputs)


def apart(one: F64, other: F64, late: Bools) -> float:
    """Return the root mean square of a difference over the other's largest size, both float64[n, ...].

    late: which of the n count, bool[n]. It is NaN where the other is 0 throughout.
    """
    most = float(np.abs(other[late]).max(initial=0.0))
    off = float(np.sqrt(np.mean((one - other)[late] ** 2)))
    return off / most if most else float("nan")


def times_of(run: Trains, neuron: int) -> F64:
    """Return the times of a neuron's spikes, s."""
    return np.asarray(run.times[run.neurons == neuron])


def van_rossum(one: F64, other: F64, tau: float) -> float:
    """Return the van Rossum distance of two spike trains (s) with a time constant (s)."""
    times = np.concatenate((one, other))
    signs = np.concatenate((np.ones(one.size), -np.ones(other.size)))
    order = np.argsort(times, kind="stable")
    times, signs = times[order], signs[order]
    fall = np.exp(-np.diff(times, prepend=times[:1]) / tau)
    before, cross = 0.0, 0.0  # what is left of all spikes before one, and sum over all pairs
    for sign, share in zip(signs, fall, strict=True):
        before *= share
        cross += sign * before
        before += sign
    return float(np.sqrt(max(0.5 * (times.size + 2.0 * cross), 0.0)))


def output(network: Network, probe: Probe, run: Trains, end: float) -> F64:
    """Return what a probe sees at steps of `STEP` from 0 to `end` s: filtered mean rate, Hz, float64[n]."""
    at = spans(network.populations)[probe.population]
    mine = (run.neurons >= at.start) & (run.neurons < at.stop)
    edges = np.arange(round(end / STEP) + 1) * STEP
    counts = np.histogram(run.times[mine], edges)[0] / (len(at) * probe.tau)
    seen: F64
    fall, seen, level = np.exp(-STEP / probe.tau), np.zeros(counts.size), 0.0
    for k, count in enumerate(counts):
        level = level * fall + count
        seen[k] = level
    return seen
