"""What ROLLS makes of a network, item by item, for the report of a mapping."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np

from chips.rolls.circuit import FILTERS
from chips.rolls.tables import Built
from chips.rolls.validity import STRONGEST, inversion
from circuits.arrays import F64
from system.mapping.dynamics import Dynamics
from system.mapping.network import Connection, matrix_of, spans
from system.mapping.report import Finding, impossible, spread, value
from system.mapping.rolls.filters import FIRST_OF, ROUNDED, SIGN, Law
from system.mapping.rolls.mapped import SERVICE, Mapped, PlacedFilter, fan_out
from system.mapping.rolls.neuron import SPAN, Curve, Wanted, one_neuron, wanted_of

FAR = 0.25  # share by which a value may be off before it counts as not there; ours
ENDS = (1.0, 4.0)  # rheobases at which a filter's current is told; ours
STRAIGHT = 1.25  # power up to which a filter is a low-pass: events gather faster where they are dense; ours
SHORTEST = 3e-14  # A s, of a filter's time constant and a rheobase: its leak is as large below; ours


def findings_of(mapped: Mapped, curves: Mapping[str, Curve], laws: Mapping[str, Law]) -> Iterator[Finding]:
    """Yield all that can be said of a mapping; curves: of its populations; laws: of its filters."""
    yield from _of_populations(mapped, curves)
    dynamics = mapped.dynamics()
    middle = float(np.exp(np.log(dynamics.cells.unit).mean()))
    for one in mapped.network.connections:
        yield from _of_connection(mapped, one, dynamics)
    for each in mapped.filters:
        yield _of_filter(each, middle, laws[each.name].error)
    for name, count in fan_out(mapped).items():
        if count:
            note = f"one becomes up to {count} of the chip, over {1e6 * SERVICE * count:.3g} us"
            yield spread(name, "events", 0.0, note)
        else:
            yield spread(name, "events", 1.0, "none of them has a synapse")


def unfit(laws: Mapping[str, Law], taus: Mapping[str, float], rheobase: float) -> Iterator[Finding]:
    """Yield filters that are no low-pass at the currents that neurons need.

    laws: of filters by name; taus: asked of them, s; rheobase: of the neurons, A.
    """
    for name, law in laws.items():
        if law.power > STRAIGHT or law.error > FAR:
            where, least = f"{name.replace('_', ' ')} synapses", max(SHORTEST / rheobase, 1.1 * taus[name])
            note = (
                "the filter's own leak is as large as what fires a neuron, so that it is no low-pass: give"
                " the synapses a longer tau, or the populations a shorter one"
            )
            yield impossible(where, "tau", taus[name], least, "s", note)


def beyond(
    mapped: Mapped, taus: Mapping[str, float], charges: Mapping[str, tuple[float, float]], built: Built
) -> Iterator[Finding]:
    """Yield what no code of the chip comes near to, or is beyond what its model was measured for.

    taus: asked of each filter, s; charges: least charge of its events that is asked for, and that there is;
    built: tables of the nominal die with every weight in use.
    """
    for one in mapped.filters:
        where, (asked, got) = f"{one.name.replace('_', ' ')} synapses", charges[one.name]
        strength = _strength(one.name, mapped, built)
        if strength > STRONGEST:
            weight = float(_of_kind(mapped, one.name).max())
            note = "lower it, or give the synapses a longer tau"
            yield impossible(
                where, "weight", weight, weight * STRONGEST / strength * min(got / asked, 1.0), "", note
            )
        elif abs(one.tau / taus[one.name] - 1.0) > FAR:
            yield impossible(
                where, "tau", taus[one.name], one.tau, "s", "no code of the chip is nearer: change it"
            )
        elif abs(got / asked - 1.0) > FAR:
            weights = _of_kind(mapped, one.name)
            weight = float(weights.max() if got < asked else weights.min())
            note = "no code of the chip is nearer: change it, or the synapses' tau"
            yield impossible(where, "weight", weight, weight * got / asked, "", note)
    populations = mapped.network.populations
    shared = float(np.average([p.refractory for p in populations], weights=[p.size for p in populations]))
    held = float(one_neuron(mapped.program.biases, 0).refractory[0])
    if shared > (1.0 + FAR) * held:
        note = "no code of the chip is nearer: change it"
        yield impossible("network", "refractory", shared, held, "s", note)


def _of_kind(mapped: Mapped, name: str) -> F64:
    """Weights of all synapses that go through a filter, above 0."""
    inside = spans(mapped.network.populations)
    found = [
        SIGN[name] * matrix_of(mapped.network, c).ravel()
        for c in mapped.network.connections
        if (c.source in inside) == (name in FILTERS[:2])
    ]
    every = np.concatenate(found)
    return every[every > 0.0]


def _of_populations(mapped: Mapped, curves: Mapping[str, Curve]) -> Iterator[Finding]:
    held = float(one_neuron(mapped.program.biases, 0).refractory[0])
    for p, placed in zip(mapped.network.populations, mapped.placed, strict=True):
        yield spread(p.name, "neurons", 0.0, f"{placed.first} to {placed.first + p.size - 1}")
        rms, worst = curve_difference(wanted_of(p), curves[p.name], placed.current)
        low, high = SPAN
        note = f"rms of the rates at {low:g} to {high:g} of what fires it, {worst:.1%} at most"
        yield spread(p.name, "rate over current", rms, note)
        yield value(p.name, "refractory", p.refractory, held, "s", "all neurons share one")


def curve_difference(wanted: Wanted, curve: Curve, current: float) -> tuple[float, float]:
    """Return root mean square and largest of the relative differences of a curve to what is asked for.

    current: A that stand for 1.
    """
    at = np.geomspace(*SPAN, 24)
    off = curve.rate(at * current) / wanted.rate(at) - 1.0
    return float(np.sqrt((off**2).mean())), float(np.abs(off).max())


def _of_connection(mapped: Mapped, one: Connection, dynamics: Dynamics) -> Iterator[Finding]:
    """Time constant and weights of a connection; weights of several between the same neurons add up."""
    wanted, got = _weights(mapped, one, dynamics)
    there = wanted != 0.0
    if not there.any():
        own = matrix_of(mapped.network, one)
        if own.any():
            yield spread(one.name, "weights", 0.0, "those between the same neurons add up to none")
        return
    tau = _tau_of(mapped, one)
    yield value(one.name, "tau", one.tau, tau, "s", "one of all synapses of its kind")
    error = float(np.sqrt(((got - wanted) ** 2).sum() / (wanted**2).sum()))
    lost = int((there & (got == 0.0)).sum())
    note = f"rms; {np.unique(wanted[there]).size} of them on {np.unique(got[got != 0.0]).size}"
    found = spread(one.name, "weights", error, note)
    if lost:
        note += f"; {lost} of {int(there.sum())} synapses are too weak to be there"
        found = replace(found, how="approximate", note=note)
    yield found


def _weights(mapped: Mapped, one: Connection, dynamics: Dynamics) -> tuple[F64, F64]:
    """Weights that are asked for between what a connection connects, and those that are there, alike.

    Both are charges over the connection's time constant, float64[2, target, source], of those that excite and
    those that inhibit.
    """
    network = mapped.network
    at, channels = spans(network.populations), spans(network.inputs)
    inner = one.source in at
    where = np.ix_(at[one.target], (at if inner else channels)[one.source])
    alike = [c for c in network.connections if (c.source, c.target) == (one.source, one.target)]
    wanted, got = np.zeros((2, 2, *matrix_of(network, one).shape))
    for tau in {c.tau for c in alike}:
        each = [matrix_of(network, c) for c in alike if c.tau == tau]
        total, size = sum(each), sum(map(np.abs, each))
        total = tau / one.tau * np.where(np.abs(total) < ROUNDED * size, 0.0, total)
        wanted += np.stack([np.maximum(total, 0.0), np.maximum(-total, 0.0)])
    current = next(p.current for p in mapped.placed if p.name == one.target)
    for f in dynamics.filters:
        own = (f.neurons if inner else f.channels)[where]
        got[int(f.sign < 0.0)] += f.tau / (one.tau * current) * own
    return wanted, got


def _tau_of(mapped: Mapped, one: Connection) -> float:
    """Time constant of the filters that a connection goes through, s: the one that is farther off."""
    first = 0 if one.source in spans(mapped.network.populations) else 2
    own, known = matrix_of(mapped.network, one), {f.name: f.tau for f in mapped.filters}
    names = [FILTERS[first + k] for k, there in enumerate(((own > 0.0).any(), (own < 0.0).any())) if there]
    taus = [known[name] for name in names if name in known] or list(known.values())
    return max(taus, key=lambda tau: abs(np.log(tau / one.tau)))


def _of_filter(one: PlacedFilter, middle: float, error: float) -> Finding:
    """By how much a filter's current is off; middle: a neuron's rheobase, A; error: of its law."""
    off = [(end * middle / one.pivot) ** (one.power - 1.0) - 1.0 for end in ENDS]
    note = (
        f"grows with power {one.power:.2f} of what comes in: {off[0]:+.0%} and {off[1]:+.0%} at {ENDS[0]:g}"
        f" and {ENDS[1]:g} of what fires a neuron, 0 % at {one.pivot / middle:.2g}; this within {error:.1%}"
    )
    return spread(f"{one.name.replace('_', ' ')} synapses", "current", max(map(abs, off)), note)


def _strength(name: str, mapped: Mapped, built: Built) -> float:
    """Largest current of a filter's weights over the specific current of its pair."""
    if name in FILTERS[2:]:
        pair = built.filters[FILTERS.index(name)].pair
        return mapped.program.biases.current(FIRST_OF[name]) / float(pair.mean())
    return inversion(built, SIGN[name] * int((mapped.program.levels.astype(np.int64) * SIGN[name]).max()))
