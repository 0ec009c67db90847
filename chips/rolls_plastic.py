"""State of a ROLLS chip's plastic array between runs, and what a run does with it.

A weight is a voltage; a bit of it, as the chip's own latch reads, is whether the comparator holds it high.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from chips.rolls_bias_file import BiasTable
from chips.rolls_chip_layout import SINCE, TAKEN, Scratch, Z
from chips.rolls_lumped import settled
from chips.rolls_plastic_biases import MOVES
from chips.rolls_plastic_kernel import settle_weights
from chips.rolls_plastic_layout import (
    PLASTIC_ROWS,
    Plastic,
    PlasticArrays,
    PlasticScratch,
)
from chips.rolls_plastic_program import Flags, binary
from chips.rolls_plastic_tables import BuiltPlastic

F64 = NDArray[np.float64]
F32 = NDArray[np.float32]


@dataclass(frozen=True, slots=True)
class PlasticState:
    """Filters and nodes, float64[PLASTIC_ROWS, n]; weights: float32[post, pre], V."""

    filters: F64
    weights: F32


def rest_of_plastic(built: BuiltPlastic, weights: Flags, step: float) -> PlasticState:
    """State without input, calcium empty, each weight at a rail: bool[post, pre]."""
    filters = np.zeros((PLASTIC_ROWS, weights.shape[0]))
    for k, bank in enumerate(built.tables.banks):
        filters[Z + k] = bank.rest
        filters[TAKEN + k], filters[SINCE + k] = settled(built.filters[k], built.loads[k], step)
    return PlasticState(filters, at_rails(built, weights))


def at_rails(built: BuiltPlastic, weights: ArrayLike) -> F32:
    """Voltages of weights at their rails; raises `ParameterError` where one is not 0 or 1."""
    return np.where(binary("weights", weights), built.tables.supply, np.float32(0.0))


def bits_of(built: BuiltPlastic, state: PlasticState) -> Flags:
    """Whether the comparators hold the weights high, bool[post, pre]."""
    return np.asarray(state.weights > built.tables.middle.T)


def arrays_of(state: PlasticState) -> PlasticArrays:
    """A copy of the state for a run."""
    weights = np.ascontiguousarray(state.weights.T)
    none = np.zeros((3, 1), np.int64)
    return PlasticArrays(state.filters.copy(), weights, np.zeros(weights.shape, np.int32), *none)


def state_of(arrays: PlasticArrays) -> PlasticState:
    """State after a run whose weights are settled."""
    return PlasticState(arrays.filters, np.ascontiguousarray(arrays.weights.T))


def settle(plastic: Plastic) -> None:
    """Bring all weights up to the step that was done last."""
    a = plastic.arrays
    settle_weights(plastic.tables, a.weights, (a.clock[0] - a.seen).astype(np.float32))
    a.seen[:] = 0
    a.clock[0] = 0


def convert(old: BuiltPlastic, new: BuiltPlastic, plastic: Plastic) -> Plastic:
    """Settle the weights, and take the array to another temperature: voltages stay."""
    settle(plastic)
    filters = plastic.arrays.filters
    for k, (f, g) in enumerate(zip(old.filters, new.filters, strict=True)):
        depth = f.fold * (old.shapes[k].log_of(filters[Z + k]) - f.start)
        filters[Z + k] = new.shapes[k].brought_at(g.start + depth / g.fold)
    return plastic._replace(tables=new.tables)


def scratch_of(filters: Scratch) -> PlasticScratch:
    """Working space; `filters` must not be the chip's."""
    return PlasticScratch(filters, *np.zeros((4, filters.excite.size), np.float32))


def plastic_cautions(biases: BiasTable, built: BuiltPlastic) -> tuple[str, ...]:
    """Where the array does not learn, or forgets, a sentence each."""
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
