"""A network put on ROLLS: neurons, time constants, weights and inputs, on codes that the nominal die has.

All neurons share a refractory period and one of two leaks, all synapses of a kind (excitatory, inhibitory,
and both kinds of virtual ones) a filter, and all synapses of a sign four weights. What is asked for in more
ways is drawn together; `Finding` says by how much it is off.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from chips.rolls.calibration import code_for
from chips.rolls.circuit import FILTERS
from chips.rolls.program.address import NEURONS
from chips.rolls.program.bias_file import BiasTable, resting_biases
from chips.rolls.program.program import Program, VirtualInput
from chips.rolls.tables import Built
from circuits.arrays import F64, I64
from system.mapping.dynamics import Usual
from system.mapping.network import Network, Population, matrix_of, spans
from system.mapping.report import Finding, check_possible, impossible
from system.mapping.rolls.filters import (
    AT,
    BAND,
    EXTRA,
    FIRST_OF,
    PULSE_LENGTH,
    ROUNDED,
    SIGN,
    Law,
    built_of,
    charges_of,
    every_level,
    laws,
    with_filters,
)
from system.mapping.rolls.findings import beyond, findings_of, unfit
from system.mapping.rolls.levels import Levels, Repeats, levels_of, repeats_of
from system.mapping.rolls.mapped import Mapped, Placed, PlacedFilter, virtual_inputs
from system.mapping.rolls.neuron import (
    Curve,
    Wanted,
    curve_of,
    matched,
    wanted_of,
    with_leak,
    with_refractory,
)

PULSE = 1.5e-9  # A, of NPA_PWLK_P: pulses of 0.08 ms, within the chip's step; ours
SLOPE = 0.16  # d of the neuron's law, before its codes are known
LONGEST = 0.3  # s, of a membrane: leaks of 2 pA; ours
ROUNDS = 4  # of the search of the weights' codes
_LOWEST = 1e-15  # A, below what any code brings

Charges = Mapping[str | int, float]
Sets = Mapping[str, Levels | Repeats]


@dataclass(frozen=True, slots=True)
class Neurons:
    """Biases with the neurons' codes, and of each population its curve, A that stand for 1, and leak."""

    biases: BiasTable
    curves: Mapping[str, Curve]
    currents: Mapping[str, float]
    slow: Mapping[str, bool]


class Asked(NamedTuple):
    """What is asked of a filter.

    name : its name; charge : what an event is to bring, float64[target, source], A s; tau : s.
    """

    name: str
    charge: F64
    tau: float


class Weighted(NamedTuple):
    """Biases with the codes of all weights, the nominal die's tables with each in use, and charges, C."""

    biases: BiasTable
    built: Built
    charges: Charges


def map_on_rolls(network: Network, usual: Usual | None = None) -> Mapped:
    """Put a network on ROLLS; raises `ParameterError` with limit and remedy for what cannot be there.

    usual: rates at whose currents its filters are to agree with the network; at twice a rheobase without.
    """
    check_possible(tuple(_too_much(network)))
    neurons = _neurons(network)
    asked = tuple(_asked(network, neurons))
    check_possible(tuple(_both_ways(network, asked)))
    biases = with_filters(neurons.biases, {a.name: a.tau for a in asked})
    middle = _middle(network, neurons)
    found = laws(biases, middle, [a.name for a in asked])
    check_possible(tuple(unfit(found, {a.name: a.tau for a in asked}, middle)))
    if usual is not None:
        found = {a.name: found[a.name].about(_usual_current(a, usual, middle)) for a in asked}
    sets = {a.name: _chosen(a, found[a.name]) for a in asked}
    weighted = _with_weights(biases, sets)
    filters = tuple(_filter(name, found[name], weighted.charges) for name in sets)
    excite, inhibit = (_repeats(network, sets.get(name)) for name in FILTERS[2:])
    inputs = virtual_inputs(network.neurons, excite, inhibit)
    program = _program(network, neurons, weighted.biases, sets, inputs)
    mapped = Mapped(network, _placed(network, neurons), filters, program, excite, inhibit, ())
    least = {
        name: (float(np.atleast_1d(chosen[0])[0]), float(_charges(name, weighted.charges)[0]))
        for name, chosen in sets.items()
    }
    check_possible(tuple(beyond(mapped, {a.name: a.tau for a in asked}, least, weighted.built)))
    return replace(mapped, findings=tuple(findings_of(mapped, neurons.curves, found)))


def _too_much(network: Network) -> Iterator[Finding]:
    """What is refused before anything is measured."""
    if network.neurons > NEURONS:
        yield impossible("network", "neurons", network.neurons, NEURONS, "", "make populations smaller")
    for p in network.populations:
        if p.tau > LONGEST:
            note = "the chip's devices leak as much themselves: take a shorter one"
            yield impossible(p.name, "tau", p.tau, LONGEST, "s", note)


def _neurons(network: Network) -> Neurons:
    """Choose the codes of both leaks and the refractory period."""
    groups = _groups(network)
    biases = resting_biases().with_code("NPA_PWLK_P", *code_for(PULSE))
    for _ in range(len(groups)):  # the second time the threshold is known to both leaks
        for slow, group in enumerate(groups):
            biases = with_leak(biases, slow, matched(_together(group), SLOPE).tau)
    biases = with_refractory(biases, _together(network.populations).refractory)
    found = {p.name: (p, slow) for slow, group in enumerate(groups) for p in group}
    curves = {name: curve_of(biases, slow) for name, (_, slow) in found.items()}
    currents = {
        name: curves[name].rheobase / matched(wanted_of(p), curves[name].slope, curves[name]).scale
        for name, (p, _) in found.items()
    }
    return Neurons(biases, curves, currents, {name: bool(slow) for name, (_, slow) in found.items()})


def _groups(network: Network) -> tuple[tuple[Population, ...], ...]:
    """Populations by their leak, the faster first: one group, or two that are split where T differ most."""
    each = sorted(
        ((matched(wanted_of(p), SLOPE).tau, p) for p in network.populations), key=lambda found: found[0]
    )
    gaps = [slower / faster for (faster, _), (slower, _) in pairwise(each)]
    populations = tuple(p for _, p in each)
    if max(gaps, default=1.0) <= 1.0:
        return (populations,)
    cut = int(np.argmax(gaps)) + 1
    return populations[:cut], populations[cut:]


def _together(group: Sequence[Population]) -> Wanted:
    """One neuron for several populations: the means of what they ask for, by their sizes."""
    sizes = [p.size for p in group]
    tau = float(np.exp(np.average(np.log([p.tau for p in group]), weights=sizes)))
    refractory = float(np.average([p.refractory for p in group], weights=sizes))
    return Wanted(tau, refractory, group[0].leak == "constant")


def _middle(network: Network, neurons: Neurons) -> float:
    """Rheobase about which filters are straight: the geometric mean over all neurons, A."""
    sizes = [p.size for p in network.populations]
    each = np.log([neurons.curves[p.name].rheobase for p in network.populations])
    return float(np.exp(np.average(each, weights=sizes)))


@dataclass(frozen=True, slots=True)
class Together:
    """Connections whose events decay alike, from neurons or from channels.

    inner : whether from neurons; tau : s; members : their numbers in the network; charge : what an event is
    to bring, A s, float64[n, sources]; below 0 it inhibits.
    """

    inner: bool
    tau: float
    members: tuple[int, ...]
    charge: F64


def asked_charges(
    network: Network, currents: Mapping[str, float], matrices: Sequence[F64]
) -> tuple[Together, ...]:
    """Return what events are to bring, of neurons and of channels and each time constant by itself.

    Weights of one pair add up there. currents: A that stand for 1, by population; matrices: of the
    connections.
    """
    at, channels = spans(network.populations), spans(network.inputs)
    kinds: dict[tuple[bool, float], list[int]] = {}
    for k, one in enumerate(network.connections):
        kinds.setdefault((one.source in at, one.tau), []).append(k)
    found = []
    for (inner, tau), members in kinds.items():
        sources = at if inner else channels
        charge, size = np.zeros((2, network.neurons, network.neurons if inner else network.channels))
        for k in members:
            one = network.connections[k]
            where = np.ix_(at[one.target], sources[one.source])
            charge[where] += currents[one.target] * tau * matrices[k]
            size[where] += currents[one.target] * tau * np.abs(matrices[k])
        charge[np.abs(charge) < ROUNDED * size] = 0.0
        found.append(Together(inner, tau, tuple(members), charge))
    return tuple(found)


def charges_by(asked: Sequence[Together], network: Network) -> dict[str, F64]:
    """Return what an event is to bring through each filter, A s, float64[n, sources], 0 or above."""
    found = {}
    for name in FILTERS:
        inner, sign = name in FILTERS[:2], SIGN[name]
        empty = np.zeros((network.neurons, network.neurons if inner else network.channels))
        found[name] = sum((np.maximum(sign * a.charge, 0.0) for a in asked if a.inner == inner), empty)
    return found


def _asked(network: Network, neurons: Neurons) -> Iterator[Asked]:
    """What is asked of each filter that is in use."""
    each = asked_charges(network, neurons.currents, [matrix_of(network, c) for c in network.connections])
    for name, charge in charges_by(each, network).items():
        if charge.any():
            alike = [a for a in each if a.inner == (name in FILTERS[:2])]
            shares = [float(np.maximum(SIGN[name] * a.charge, 0.0).sum()) / a.tau for a in alike]
            tau = float(np.exp(np.average(np.log([a.tau for a in alike]), weights=shares)))
            yield Asked(name, charge, tau)


def _both_ways(network: Network, asked: Sequence[Asked]) -> Iterator[Finding]:
    """Pairs of neurons with synapses of both signs, of which the chip has one a pair."""
    charges = {a.name: a.charge for a in asked}
    if not all(name in charges for name in FILTERS[:2]):
        return
    both = int(np.logical_and(*(charges[name] > 0.0 for name in FILTERS[:2])).sum())
    if both:
        note = (
            "the chip has one synapse from a neuron to another, which excites or inhibits: give both the same"
            " tau, so that they add up, leave one out, or take a population between"
        )
        yield impossible("network", "pairs that excite and inhibit", both, 0, "", note)


def _usual_current(asked: Asked, usual: Usual, middle: float) -> float:
    """Mean current of a filter at usual rates, over neurons by their current, A; middle: a rheobase, A."""
    each = asked.charge @ (usual.neurons if asked.name in FILTERS[:2] else usual.channels)
    mean = float((each**2).sum() / each.sum()) if each.any() else AT * middle
    return float(np.clip(mean, BAND[0] * middle, 2.0 * BAND[1] * middle))


def _chosen(asked: Asked, law: Law) -> Levels | Repeats:
    return chosen_of(asked.name, asked.charge / law.gain)


def chosen_of(name: str, charge: F64) -> Levels | Repeats:
    """Return the levels, or the repeats, of a filter that charges of 0 or above are brought by."""
    return repeats_of(charge) if name in FILTERS[2:] else levels_of(charge)


def _steps(name: str, charges: F64) -> dict[str, float]:
    """Charge that each bias of a filter's weights brings; charges: of levels 1 to 4, or of one event."""
    steps = charges[:1] if charges.size == 1 else [charges[0], *(charges[1:3] - charges[0])]
    return {bias: float(x) for bias, x in zip((FIRST_OF[name], *EXTRA.get(name, ())), steps, strict=True)}


def _with_weights(biases: BiasTable, sets: Sets) -> Weighted:
    """Search the codes of all weights."""
    wanted: dict[str, float] = {}
    for name, chosen in sets.items():
        wanted |= _steps(name, np.atleast_1d(np.asarray(chosen[0])))
    found = _weighted(biases, {bias: charge / PULSE_LENGTH for bias, charge in wanted.items()})
    before: dict[str, Point] = {}
    for _ in range(ROUNDS - 1):
        has: dict[str, float] = {}
        for name in sets:
            has |= _steps(name, _charges(name, found.charges))
        now = {bias: Point(found.biases.current(bias), has[bias]) for bias in wanted}
        currents = {bias: _next(now[bias], before.get(bias), wanted[bias]) for bias in wanted}
        found, before = _weighted(found.biases, currents), now
    return found


class Point(NamedTuple):
    """Current of a weight's bias, A, and the charge that it brings, C."""

    current: float
    charge: float


def _next(now: Point, before: Point | None, wanted: float) -> float:
    """Current that brings a charge, on the line through two points, as devices leak too, or in proportion."""
    if before is not None and (now.current - before.current) * (now.charge - before.charge) > 0.0:
        slope = (now.charge - before.charge) / (now.current - before.current)
        return max(now.current + (wanted - now.charge) / slope, _LOWEST)
    return now.current * wanted / max(now.charge, 1e-3 * wanted)


def _weighted(biases: BiasTable, currents: Mapping[str, float]) -> Weighted:
    """With weights of some currents, A."""
    for bias, current in currents.items():
        biases = biases.with_code(bias, *code_for(current))
    program = every_level(biases)
    built = built_of(program)
    return Weighted(biases, built, charges_of(program, built))


def _charges(name: str, charges: Charges) -> F64:
    """Charges of a filter's levels 1 to 4, or of one event, C."""
    return np.array([charges[SIGN[name] * k] for k in (1, 2, 3, 4)] if name in EXTRA else [charges[name]])


def _filter(name: str, law: Law, charges: Charges) -> PlacedFilter:
    weights = law.weight(_charges(name, charges))
    return PlacedFilter(name, law.tau, law.power, law.pivot, tuple(weights.tolist()))


def _placed(network: Network, neurons: Neurons) -> tuple[Placed, ...]:
    found = []
    for name, at in spans(network.populations).items():
        curve = neurons.curves[name]
        found.append(
            Placed(
                name, at.start, neurons.slow[name], curve.tau, curve.slope, curve.rheobase, curve.refractory,
                neurons.currents[name],
            )
        )  # fmt: skip
    return tuple(found)


def _program(
    network: Network, neurons: Neurons, biases: BiasTable, sets: Sets, inputs: tuple[VirtualInput, ...]
) -> Program:
    levels, n = np.zeros((NEURONS, NEURONS), dtype=np.int8), network.neurons
    for name in (each for each in FILTERS[:2] if each in sets):
        levels[:n, :n] += (SIGN[name] * sets[name].chosen).astype(np.int8)
    slow = tuple(k for name, at in spans(network.populations).items() if neurons.slow[name] for k in at)
    return Program(levels, biases, slow, inputs)


def _repeats(network: Network, chosen: Levels | Repeats | None) -> I64:
    if chosen is None:
        return np.zeros((network.channels, network.neurons), dtype=np.int64)
    return np.ascontiguousarray(chosen.chosen.T)
