"""State of a ROLLS chip's plastic array between runs, and what a run does with it.

A weight is a voltage; a bit of it, as the chip's own latch reads, is whether the comparator holds it high.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from chips.rolls.layout import ZERO, Scratch
from chips.rolls.lumped.filter import move_filters, rest_filters
from chips.rolls.plastic.biases import MOVES
from chips.rolls.plastic.kernel import settle_weights
from chips.rolls.plastic.layout import (
    PLASTIC_ROWS,
    Plastic,
    PlasticArrays,
    PlasticScratch,
)
from chips.rolls.plastic.tables import BuiltPlastic
from chips.rolls.program.bias_file import BiasTable
from circuits.arrays import F32, F64, I32, Bools

LONGEST = 1 << 30  # steps that a weight's age is counted up to, five days


@dataclass(frozen=True, slots=True)
class PlasticState:
    """State of the plastic array.

    filters: filters and nodes, float64[PLASTIC_ROWS, n]; weights: V, float32[post, pre], as they were at
    their last events, `pending` steps ago, int32[post, pre]; `voltages` gives them as they are now. So a run
    in pieces is the run.
    """

    filters: F64
    weights: F32
    pending: I32


def rest_of_plastic(built: BuiltPlastic, weights: Bools, step: float) -> PlasticState:
    """Return the state without input: calcium empty, each weight at a rail; weights: bool[post, pre]."""
    filters = np.zeros((PLASTIC_ROWS, weights.shape[0]))
    rest_filters(filters, built, built.tables.banks, step)
    supply = built.tables.supply
    return PlasticState(filters, np.where(weights, supply, ZERO), np.zeros(weights.shape, np.int32))


def voltages(built: BuiltPlastic, state: PlasticState) -> F32:
    """Return the voltages of the weights, V, float32[post, pre]."""
    found = np.ascontiguousarray(state.weights.T)
    steps = np.ascontiguousarray(state.pending.T, dtype=np.float32)
    settle_weights(built.tables, found, steps, np.zeros(found.shape[1], np.float32))
    return np.ascontiguousarray(found.T)


def bits_of(built: BuiltPlastic, state: PlasticState) -> Bools:
    """Return whether the comparators hold the weights high, bool[post, pre]."""
    return np.asarray(state.weights > built.tables.middle.T)


def arrays_of(state: PlasticState) -> PlasticArrays:
    """Return a copy of the state for a run."""
    weights = np.ascontiguousarray(state.weights.T)
    none = np.zeros((3, 1), np.int64)
    return PlasticArrays(state.filters.copy(), weights, np.ascontiguousarray(-state.pending.T), *none)


def state_of(arrays: PlasticArrays) -> PlasticState:
    """Return the state after a run."""
    pending = np.minimum(arrays.clock[0] - arrays.seen.T, LONGEST).astype(np.int32)
    return PlasticState(arrays.filters, np.ascontiguousarray(arrays.weights.T), pending)


def settle(plastic: Plastic) -> None:
    """Bring all weights up to the step that was done last."""
    a = plastic.arrays
    settle_weights(plastic.tables, a.weights, (a.clock[0] - a.seen).astype(np.float32), plastic.scratch.lift)
    a.seen[:] = 0
    a.clock[0] = 0


def convert(old: BuiltPlastic, new: BuiltPlastic, plastic: Plastic) -> Plastic:
    """Settle the weights and return the array at another temperature; its voltages stay."""
    settle(plastic)
    move_filters(plastic.arrays.filters, old, new)
    return plastic._replace(tables=new.tables)


def scratch_of(filters: Scratch) -> PlasticScratch:
    """Return the working space; `filters` must not be the chip's."""
    return PlasticScratch(filters, *np.zeros((5, filters.excite.size), np.float32))


def plastic_cautions(biases: BiasTable, built: BuiltPlastic) -> tuple[str, ...]:
    """Return, in sentences, where the array does not learn, or forgets."""
    found = [
        f"plastic: {name} has fine code 0, so that no event moves a weight that way and weights only drift;"
        " take the codes of with_learning"
        for name in MOVES
        if biases.is_off(name)
    ]
    for name, rate in (("up", built.cells.rise), ("down", built.cells.fall)):
        lost = int((rate <= 0.0).sum())
        if lost:
            found.append(
                f"plastic: {lost} weights leak more than they drift {name}, and forget; raise the drift"
            )
    return tuple(found)
