"""What a ranging chip reads of an echo's delay in the forest: one table for a die and a temperature.

The chip gets a call and, `delay` later, one echo. Its reading is the look-up value of the neuron that spikes
first within `WINDOW` after the echo (ours; the shipped neurons take up to 3.3 ms); none is a missed echo. A
neuron that a call alone makes fire on its die spoils the readings of echoes just before. The look-up value of
a neuron is the mean delay for which it is first,

- `nominal`: on the nominal die at 27 degC, the same for every die;
- `calibrated`: on this die at 27 degC, where it is the first for any delay, else the nominal one.

On the nominal die the readings are 0.63 ms rms off, 0.11 m: 13 windows of 2.17 ms resolve no more.

The table holds for an echo alone after its call: how earlier echoes of the same ping move a neuron is left
out. With whole trains, 6.5 echoes a ping at random places of the field of view, 71 % of the nominal die's
echoes have the table's first neuron, and 94 % that or its neighbour (`share_alike`); on two dies with
mismatch 64 and 71 % have it. A train on the chip's own kernel takes 200 us and more, a table nothing.
Between the table's delays, `STEP` apart, the nearest one counts.
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import lru_cache
from typing import Literal, NamedTuple

import numpy as np

from chips.ranging import circuit as ranging_chip
from chips.ranging.chip import shipped_model
from chips.ranging.kernel import (
    Chip,
    Plan,
    doubts,
    new_chip,
    new_plan,
    next_due,
    on_call,
    on_echo,
    start,
    take,
)
from chips.ranging.law import Neurons
from chips.ranging.model import check_box, neurons_on
from chips.validity import require_area
from circuits.arrays import F64, I64
from circuits.circuit import BiasKind
from circuits.compiled import compiled
from circuits.errors import ParameterError
from circuits.silicon.process import Process
from circuits.silicon.silicon import Silicon

Calibration = Literal["nominal", "calibrated"]
CALIBRATIONS: tuple[Calibration, ...] = ("nominal", "calibrated")
STEP = 50e-6  # s, 9 mm of range; ours
LONGEST = 30.5e-3  # s, beyond the echo of R_MAX
WINDOW = 3.5e-3  # s; ours
REFERENCE = 27.0  # degC, of look-up values
NOBODY = -1
CALL = 50e-3  # s, after which the chip is at rest

_compiled = compiled()


class Table(NamedTuple):
    """First neurons by delay, int64[delays], -1 for none, and how many delays are too near to call.

    first : number of the neuron.
    doubts : how many delays are too near to call.
    """

    first: I64
    doubts: int


def delays() -> F64:
    """Return the delays of a table, s."""
    return np.asarray(STEP * np.arange(round(LONGEST / STEP) + 1, dtype=np.float64))


def neurons_of(silicon: Silicon, area: float = 1.0, bias_kind: BiasKind = "generator") -> Neurons:
    """Neurons of the ranging chip on `silicon`, its drawn devices `area` times as large against mismatch.

    Raises `ParameterError` for silicon outside the validity box of the chip's record (`chips.validity`), and
    for an area that is none.
    """
    model = shipped_model(silicon.process, bias_kind)
    check_chip(silicon, area, bias_kind)
    return neurons_on(model, silicon.of_area(area))


def check_chip(silicon: Silicon, area: float = 1.0, bias_kind: BiasKind = "generator") -> None:
    """Ask that the ranging chip on `silicon` is inside the validity box of its record, as `neurons_of`."""
    require_area("ranging_chip", area, 0.0)  # what smaller devices deviate by is a side of the record's box
    check_box(shipped_model(silicon.process, bias_kind), silicon.of_area(area))


def first_neurons(neurons: Neurons) -> Table:
    """Which neuron spikes first after an echo of each delay."""
    plan = new_plan(neurons)
    chip = new_chip(neurons, plan)
    when = delays()
    found = np.full(when.size, NOBODY)
    _fill(neurons, plan, chip, when, found)
    return Table(found, doubts(chip))


def late_spikes(neurons: Neurons) -> tuple[F64, int]:
    """How long after an echo of each of `delays`, alone after its call, neurons spike, and the doubts.

    The first is float64[neurons, delays], s, inf for none; the second how many delays are too near to call.
    """
    plan, when = new_plan(neurons), delays()
    chip = new_chip(neurons, plan)
    found = np.full((neurons.t_inh.size, when.size), np.inf)
    _fill_late(neurons, plan, chip, when, found)
    return found, doubts(chip)


def lookup(table: Table, spare: F64 | None = None) -> F64:
    """Mean delay (s) for which each neuron is first; of `spare`, or NaN, where it never is."""
    when = delays()
    held = [when[table.first == k] for k in range(ranging_chip.NEURONS)]
    own = np.array([each.mean() if each.size else np.nan for each in held])
    return own if spare is None else np.where(np.isnan(own), spare, own)


def readings(
    silicon: Silicon, calibration: Calibration, area: float = 1.0, bias_kind: BiasKind = "generator"
) -> tuple[F64, int]:
    """Reading (s, NaN for none) of each of `delays`, and how many of them are too near to call.

    Raises `ParameterError` for a calibration or an area that is none, and as `neurons_of`.
    """
    check_chip(silicon, area, bias_kind)  # at every call: what follows is worked out once
    return _readings(silicon, calibration, area, bias_kind)


@lru_cache(maxsize=256)
def _readings(
    silicon: Silicon, calibration: Calibration, area: float, bias_kind: BiasKind
) -> tuple[F64, int]:
    table = first_neurons(neurons_of(silicon, area, bias_kind))
    values = values_of(silicon, calibration, area, bias_kind, table)
    return np.where(table.first == NOBODY, np.nan, values[table.first]), table.doubts


def values_of(
    silicon: Silicon, calibration: Calibration, area: float = 1.0, bias_kind: BiasKind = "generator",
    table: Table | None = None,
) -> F64:  # fmt: skip
    """Look-up value (s) of each neuron; table: of the chip on `silicon`, worked out unless given.

    Raises `ParameterError` for a calibration that is none.
    """
    if calibration not in CALIBRATIONS:
        raise ParameterError(f"reader: {calibration}, must be {' or '.join(CALIBRATIONS)}")
    values = _nominal_lookup(silicon.process, bias_kind)
    if calibration == "nominal":
        return values
    there = replace(silicon, temperature_c=REFERENCE)
    if table is None or silicon != there:
        table = first_neurons(neurons_of(there, area, bias_kind))
    return lookup(table, values)


@lru_cache(maxsize=4)
def _nominal_lookup(process: Process, bias_kind: BiasKind) -> F64:
    return lookup(first_neurons(neurons_of(Silicon(process), bias_kind=bias_kind)))


def share_alike(neurons: Neurons, table: Table, trains: list[F64]) -> tuple[int, int]:
    """Echoes in trains (delays of a ping, s, rising) whose first neuron is the table's; and of how many.

    The chip hears a whole train after one call. A neuron that spikes within `WINDOW` after an echo, and after
    later ones too, counts for each of them, as the reader takes it.
    """
    plan = new_plan(neurons)
    chip = new_chip(neurons, plan)
    alike, total, now = 0, 0, 0.0
    for train in trains:
        now += 2.0 * CALL
        found = np.full(train.size, NOBODY)
        _hear_train(neurons, plan, chip, now, train, found)
        index = np.rint(train / STEP).astype(np.int64)
        alike += int((found == table.first[index]).sum())
        total += train.size
    return alike, total


@_compiled
def _fill(m: Neurons, p: Plan, c: Chip, when: F64, found: I64) -> None:
    """First neuron after an echo of each delay, alone after its call."""
    for k in range(when.size):
        now = 2.0 * CALL * (k + 1)
        _hear_train(m, p, c, now, when[k : k + 1], found[k : k + 1])


@_compiled
def _hear_train(m: Neurons, p: Plan, c: Chip, now: float, train: F64, found: I64) -> None:
    """First neuron within `WINDOW` after each echo of a train whose call is at `now` s; -1 for none."""
    start(m, p, c, now - CALL)
    _go_on(m, p, c, now, now, train, found)
    on_call(m, p, c, now)
    for k in range(train.size):
        _go_on(m, p, c, now + train[k], now, train, found)
        on_echo(m, p, c, now + train[k], np.nan)
    _go_on(m, p, c, now + train[train.size - 1] + WINDOW, now, train, found)


@_compiled
def _go_on(m: Neurons, p: Plan, c: Chip, until: float, now: float, train: F64, found: I64) -> None:
    """Take the spikes up to `until` s: each is the first of the echoes in whose window it falls."""
    while True:
        due, k = next_due(c)
        if due > until:
            return
        if not take(m, p, c, k):
            continue
        for j in range(train.size):
            since = due - now - train[j]
            if found[j] < 0 and 0.0 <= since <= WINDOW:
                found[j] = k


@_compiled
def _fill_late(m: Neurons, p: Plan, c: Chip, when: F64, found: F64) -> None:
    """First spike of each neuron after an echo of each delay, alone after its call."""
    for k in range(when.size):
        now = 2.0 * CALL * (k + 1)
        start(m, p, c, now - CALL)
        _go_on_late(m, p, c, now, math.inf, found[:, k])
        on_call(m, p, c, now)
        echo = now + when[k]
        _go_on_late(m, p, c, echo, math.inf, found[:, k])
        on_echo(m, p, c, echo, np.nan)
        _go_on_late(m, p, c, echo + WINDOW, echo, found[:, k])


@_compiled
def _go_on_late(m: Neurons, p: Plan, c: Chip, until: float, echo: float, late: F64) -> None:
    """Take the spikes up to `until` s; the first of each neuron after the echo (s) counts."""
    while True:
        due, k = next_due(c)
        if due > until:
            return
        if take(m, p, c, k) and echo <= due < echo + late[k]:
            late[k] = due - echo
