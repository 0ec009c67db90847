"""What predicts each circuit's measurements, and all that is not known of any of them."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

from circuits.arrays import F64
from circuits.errors import DataError
from circuits.extraction.coach.bench import Bench, bench_unknowns, process_unknowns
from circuits.extraction.coach.conditions import Condition
from circuits.extraction.coach.joint import Fit, Measured, Model, fit
from circuits.extraction.coach.readings import (
    amplifier,
    bump,
    converter,
    fet,
    follower,
    neuron,
    pair,
    ring,
    synapse,
)
from circuits.extraction.coach.table import Table
from circuits.extraction.coach.unknown import Unknown, before
from circuits.silicon.process import Process

_FET = Model(fet.predict, fet.usable, fet.noise)
_OPEN = Model(amplifier.predict_open, amplifier.usable, amplifier.noise)
_NEURON = Model(neuron.predict, neuron.usable, neuron.noise)
MODELS: Mapping[str, Model] = {
    "nfet": _FET,
    "pfet": _FET,
    "converter": Model(converter.predict, converter.usable, converter.noise),
    "differential-pair": Model(pair.predict, pair.usable, pair.noise),
    "bump-antibump": Model(bump.predict, bump.usable, bump.noise),
    "transamp-n": _OPEN,
    "transamp-p": _OPEN,
    "wide-range-transamp": _OPEN,
    "transamp-n-copies": Model(amplifier.predict_copies, amplifier.usable, amplifier.noise),
    "follower-integrator": Model(follower.predict, follower.usable, follower.noise),
    "ring-converters": Model(ring.predict_converters, ring.usable_counts, ring.noise),
    "ring-inputs": Model(ring.predict_inputs, ring.usable_counts, ring.noise),
    "dpi-synapse": Model(synapse.predict, synapse.usable, synapse.noise),
    "axon-hillock": _NEURON,
    "adaptive-neuron": _NEURON,
    "winner-take-all-ring": Model(ring.predict, ring.usable, ring.noise),
}
"""What predicts the measurements of each circuit."""
_CONVERTED: Mapping[str, Callable[[Mapping[str, F64]], dict[str, F64]]] = {
    "differential-pair": pair.converted,
    "bump-antibump": bump.converted,
    "transamp-n-copies": amplifier.converted,
}
_MATCHED = ("differential_pair.m1.v_t0", "differential_pair.m2.v_t0")
_PAIR_AREA = 1e-12  # m^2


def unknowns_of(conditions: Mapping[str, Condition], base: Process) -> tuple[Unknown, ...]:
    """All that is not known of some measurements, before any of them is looked at.

    Parameters
    ----------
    conditions
        What was set, by name.
    base
        The process about which its numbers are spread; its `pair_a_vt` is the deviations' law.
    """
    a_vt = base.pair_a_vt
    return (
        *process_unknowns(base),
        *bench_unknowns(),
        *fet.unknowns(conditions),
        *converter.unknowns(conditions),
        *pair.unknowns(conditions, a_vt),
        *bump.unknowns(conditions),
        *amplifier.unknowns(conditions),
        *follower.unknowns(conditions, a_vt),
        *ring.unknowns(conditions, a_vt),
        *synapse.unknowns(conditions),
        *neuron.unknowns(conditions),
    )


def complete(condition: Condition, found: Mapping[str, F64]) -> dict[str, F64]:
    """Readings with the columns that the files make of them."""
    more = _CONVERTED.get(condition.circuit)
    return {**found, **(more(found) if more else {})}


def predicted(bench: Bench, condition: Condition, table: Table) -> dict[str, F64]:
    """Readings of a measurement, by column, without noise."""
    return MODELS[condition.circuit].predict(bench, condition, table)


def measured(data: Mapping[str, tuple[Condition, Table]]) -> list[Measured]:
    """Measurements with the points of each that may be fitted.

    Raises
    ------
    DataError
        A measurement has no point that may be.
    """
    found = []
    for condition, given in data.values():
        table = given
        model = MODELS[condition.circuit]
        if model is _NEURON:
            table = neuron.features(condition, table)
        kept = model.usable(condition, table)
        if not any(points.any() for points in kept.values()):
            raise DataError(f"{condition.file}: no point in the usable range of its meter; leave it out")
        found.append(Measured(condition, table, model, kept))
    return found


def matching(values: Mapping[str, float]) -> tuple[float, float]:
    """A_VT of a pair and its standard error, V m, by the spread of what should be alike on the die.

    Parameters
    ----------
    values
        Unknowns by name: the ring's 16 inputs with their mirrors and readout, and the pair's offset.
    """
    total, variance = ring.matching(values)
    squares = float(((total - total.mean()) ** 2).sum()) / variance
    offset = values[_MATCHED[0]] - values[_MATCHED[1]]
    squares += offset**2 * _PAIR_AREA
    freedom = total.size  # of which the mean takes one, and the pair's offset brings one
    value = math.sqrt(squares / freedom)
    return value, value / math.sqrt(2.0 * freedom)


def fit_all(
    data: Mapping[str, tuple[Condition, Table]],
    conditions: Mapping[str, Condition],
    base: Process,
    start: Mapping[str, float] | None = None,
    factors: Mapping[tuple[str, str], float] | None = None,
    rounds: int = 3,
) -> Fit:
    """Fit all that is not known to measurements; as `circuits.extraction.coach.joint.fit`."""
    prior = before(unknowns_of(conditions, base))
    return fit(measured(data), prior, base, start, factors, rounds)
