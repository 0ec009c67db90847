"""Calibration of a selection: its tail current, and what its cells must be given to be equals.

On the bench a decision is made again and again: currents are put into the cells, and the line that rises
tells the winner. All without noise, as most of many decisions have it.

    tail      what the winner's share copies where it wins by far; the code of `i_tail` brings it to the
              design's
    tie       a cell and the one in the middle get the same, all others less; by halves that share of the
              middle's excitation is found at which the cell begins to win
    excite    the board that drives the excitations multiplies each by its share, so that equals tie
    off       a cell that never wins, or always, is given nothing

All cells share one line, so that no code can trim one of them: without a board that multiplies, offsets of
4 % rms stay. What stays in any case: the mirrors of the risks, each of a pair of devices of its own, and the
time of a decision, which the tail hardly moves. A share that is found at one excitation is a little off at
another.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from chips.codes import Codes, Measured, attempted, codes_near, left_off
from chips.selection.kernel import Selection
from chips.selection.model import decision, selection
from circuits.arrays import F64
from circuits.bias import rebias
from circuits.blocks.selection.winner_take_all import OTHERS, STANDING, Params, build
from circuits.circuit import BiasKind, Circuit
from circuits.generator.code import codes_of, currents_of
from circuits.silicon.silicon import Silicon

NAME = "selection-chip"  # of the calibration
ROUNDS = 4  # in which the tail is measured and moved; ours
EXCITATION = 50e-9  # A, of the middle cell; the forest's constant one
WIDEST = 0.4  # ln of a cell's share, beyond which it is left out: ten times what mismatch makes; ours
HALVES = 10  # of the search for a tie, to 0.8e-3 of the share; ours
CLEAR = 0.2  # contrast of a decision that is timed; ours
DECISIONS = 64  # of which each answer is what most gave; ours
REST = 1e-3  # s, of a decision and of what comes before it; ours
OFF = 0.1  # share of a number beyond which it is told to stay off; ours
_LINE = "i_tail"


@dataclass(frozen=True, slots=True)
class Design:
    """What a selection is calibrated for.

    params: its cells, and the width and reach of its projection. area: area of its drawn devices over the
    circuit's, a ratio.
    """

    params: Params
    area: float = 1.0


def calibrate(silicon: Silicon, kind: BiasKind, design: Design) -> Codes:
    """Calibrate the selection of a design on a silicon, at its temperature.

    A chip whose line has no code for its current cannot be used.

    Arguments are those of `chips.codes.attempted`; design: its cells. Raises
    `OutsideBoxError` where its model was not measured.
    """
    return attempted(NAME, silicon, kind, design, lambda begun: _found(begun, silicon, design))


def _found(begun: Codes, silicon: Silicon, design: Design) -> Codes:
    """Codes of the chip on a silicon."""
    wanted = selection(Silicon(silicon.process.under("ideal")), design.params)
    tried = _tried(silicon, begun.key.bias_kind, design, wanted.tail)
    current, chip = min(tried.items(), key=lambda each: abs(math.log(each[1].tail / wanted.tail)))
    usual = next(iter(tried.values()))
    shares = ties(chip)
    off = tuple(map(int, np.flatnonzero(~np.isfinite(shares))))
    excite = _even(shares)
    measured = (
        Measured("tail", "A", wanted.tail, usual.tail, chip.tail),
        Measured("time", "s", clear_time(wanted), clear_time(usual), clear_time(chip, excite)),
        *_tied(shares, ties(chip, excite)),
    )  # fmt: skip
    return replace(
        begun, biases=codes_near({_LINE: current}), off={"cell": off},
        trims={"excite": tuple(map(float, excite))}, measured=measured,
        bench_s=REST * DECISIONS * (len(tried) + 2 * HALVES * shares.size),
        unmended=left_off(measured, OFF), failed="no cell wins" if len(off) > shares.size - 2 else "",
    )  # fmt: skip


def biased(params: Params, kind: BiasKind, current: float | None = None) -> Circuit:
    """Return the circuit of a selection with a bias of a kind; current: of its tail, A."""
    return rebias(build(params), {} if current is None else {_LINE: current}, kind)


def circuit_at(codes: Codes, params: Params) -> Circuit:
    """Return the circuit of a selection at codes."""
    return biased(params, codes.key.bias_kind, float(np.asarray(codes.current(_LINE))))


def ties(chip: Selection, excite: F64 | None = None) -> F64:
    """Return what each cell must be given to tie with the middle one, over that, float64[N].

    NaN for a cell that never wins within `WIDEST`, or always; excite: shares by which the board multiplies
    each excitation, 1 unless given.
    """
    cells = chip.excite_beta.size
    board = np.ones(cells) if excite is None else excite
    return np.array([1.0 if k == cells // 2 else _tie(chip, board, k) for k in range(cells)])


def clear_time(chip: Selection, excite: F64 | None = None) -> float:
    """Return the mean time of decisions in which each cell in turn wins by `CLEAR`, s, NaN where one is lost.

    excite: as of `ties`.
    """
    cells = chip.excite_beta.size
    board = np.ones(cells) if excite is None else excite
    given = EXCITATION * np.where(np.eye(cells) > 0.0, 1.0, 1.0 - CLEAR) * board
    made = [decision(chip, row, np.full(cells, STANDING)) for row in given]
    right = all(each.winner == k for k, each in enumerate(made))
    return float(np.mean([each.time for each in made])) if right else math.nan


def _tried(silicon: Silicon, kind: BiasKind, design: Design, wanted: float) -> dict[float, Selection]:
    """The chip by the nominal currents of the codes that were tried, A, the usual one first."""
    found: dict[float, Selection] = {}
    current = _nearest(float(np.asarray(build(design.params).bias(_LINE).value)))
    while len(found) < ROUNDS and current not in found:
        circuit = biased(design.params, kind, current)
        found[current] = selection(silicon, design.params, circuit, area=design.area)
        current = _nearest(current * wanted / found[current].tail)
    return found


def _nearest(current: float) -> float:
    return float(currents_of(codes_of(np.array(current))))


def _tie(chip: Selection, board: F64, cell: int) -> float:
    """What a cell must be given over the middle one's excitation to win; NaN outside of `WIDEST`."""
    middle = board.size // 2

    def wins(share: float) -> bool:
        given = np.full(board.size, OTHERS)
        given[middle], given[cell] = 1.0, math.exp(share)
        return decision(chip, EXCITATION * given * board, np.full(board.size, STANDING)).winner == cell

    low, high = -WIDEST, WIDEST
    if wins(low) or not wins(high):
        return math.nan
    for _ in range(HALVES):
        half = 0.5 * (low + high)
        low, high = (low, half) if wins(half) else (half, high)
    return math.exp(0.5 * (low + high))


def _even(shares: F64) -> F64:
    """What the board multiplies by, float64[N]: shares with a mean of 1, and 0 for a cell that is off."""
    there = np.isfinite(shares)
    return np.where(there, shares / np.mean(shares[there]), 0.0)


def _tied(before: F64, after: F64) -> Iterator[Measured]:
    """The tie of each cell with the middle one, as it is given what the board makes of equal excitations."""
    for k, pair in enumerate(zip(before, after, strict=True)):
        yield Measured(f"tie[{k}]", "", 1.0, *map(float, pair))
