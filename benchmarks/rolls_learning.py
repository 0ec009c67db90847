"""Claim: a ROLLS chip that learns on all its 65,536 plastic synapses at about 70 Hz runs 30 times real time.

The chip of `rolls_chip.py`, its 65,536 non-plastic synapses and a direct current that makes the neurons fire,
with a plastic synapse between all neurons too: every spike is an event of 256 plastic synapses, whose weights
drift, are read and move. One core, CPU time of the thread, best of some turns of 1 s. Beside it: the same
chip without the array, the time a plastic event takes, a lesson of `noctule reproduce rolls-learning` (two
populations, 64 plastic columns by events from outside), and the memory of the array's tables.

Returns 1 where the claim is missed.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from _report import Row, parser_of, report
from chips.rolls.calibration import code_for
from chips.rolls.chip import RollsChip
from chips.rolls.plastic.program import PlasticArray
from chips.rolls.program.address import NEURONS
from chips.rolls.program.program import Program
from chips.rolls.setups.learning import Task, chips_of, learning_biases, teach
from chips.rolls.setups.populations import table
from circuits.silicon.die import Die
from circuits.silicon.process import ROLLS_180_IDEAL
from circuits.silicon.silicon import Silicon

CLAIM = 30.0
DIE = 1000
DRIVE = 0.31e-9  # A, direct current, as in rolls_chip.py
WEAK = 0.03e-9  # A: of a high plastic weight, so that the rate stays about the same with the array
TURNS, QUICK = 15, 5


def program() -> Program:
    """Full matrices of both kinds, half of the plastic weights high."""
    draw = np.random.default_rng(1)
    levels = draw.choice(np.array([1, -1], np.int8), (NEURONS, NEURONS), p=[0.8, 0.2])
    codes = {"IF_DC_P": code_for(DRIVE), "NPDPII_TAU_P": (7, 150), "NPDPII_THR_P": (7, 150)}
    weights = table(codes, {"NPA_WEIGHT_EXC_P": 0.6e-9, "NPA_WEIGHT_INH_N": 0.6e-9})
    biases = learning_biases()
    for name in (*codes, "NPA_WEIGHT_EXC_P", "NPA_WEIGHT_INH_N", "NPDPIE_TAU_P", "NPDPIE_THR_P"):
        code = (7, 150) if name.startswith("NPDPIE") else weights.code(name)
        biases = biases.with_code(name, *code)
    biases = biases.with_code("PA_WHIDN_N", *code_for(WEAK))
    every = np.ones((NEURONS, NEURONS), np.bool_)
    return Program(levels, biases, plastic=PlasticArray(every, draw.random(every.shape) < 0.5))


def measure(*, quick: bool) -> Iterator[Row]:
    """All rows."""
    turns = QUICK if quick else TURNS
    whole, silicon = program(), Silicon(ROLLS_180_IDEAL, 27.0, Die(number=DIE))
    chip, plain = (RollsChip(p, silicon, "ideal") for p in (whole, replace(whole, plastic=None)))
    taken, rate = _best(chip, turns)
    without, plain_rate = _best(plain, turns)
    events = rate * NEURONS * NEURONS
    _, state = chip.run(chip.at_rest(), 0.2)
    _, after = chip.run(state, 1.0)
    moved = int((chip.weights(after) != chip.weights(state)).sum())
    note = f"{rate:.1f} Hz mean, {events / 1e6:.1f} million plastic events in 1 s; {moved} weights flip in it"
    yield _row("learning on, times real time", 1.0 / taken, note, CLAIM)
    yield _row("without the array, times real time", 1.0 / without, f"{plain_rate:.1f} Hz mean")
    more = (taken - without * rate / plain_rate) / events
    yield _row("time of a plastic event, ns", 1e9 * more, "what the array adds, at the same rate")
    yield _lesson()
    size = sum(a.nbytes for a in chip.built().plastic.tables if isinstance(a, np.ndarray))  # type: ignore[union-attr]
    yield _row(
        "memory of the array's tables, MiB", size / 2**20, "arrays of the tables, filters' banks apart"
    )


def _row(name: str, value: float, note: str, least: float = 0.0) -> Row:
    """A figure without a peer."""
    return Row(name, value, None, value, note, least=least)


def _best(chip: RollsChip, turns: int) -> tuple[float, float]:
    """CPU time of 1 s, and the mean rate, Hz."""
    _, state = chip.run(chip.at_rest(), 0.2)
    best, rate = float("inf"), 0.0
    for _ in range(turns):
        start = time.thread_time()
        spikes, _ = chip.run(state, 1.0)
        best, rate = min(best, time.thread_time() - start), spikes.times.size / NEURONS
    return best, rate


def _lesson() -> Row:
    task = Task(training=20)
    chip, _ = chips_of(task, Silicon(ROLLS_180_IDEAL, 27.0, Die(number=DIE)), "ideal", DIE)
    state = chip.at_rest()
    start = time.thread_time()
    teach(chip, task, state, DIE, task.training)
    spent = time.thread_time() - start
    length = task.training * (task.presentation + task.pause)
    return _row("a lesson, times real time", length / spent, "20 presentations, their events drawn too")


def main() -> int:
    """Measure and print all rows."""
    options = parser_of(__doc__, "fewer turns").parse_args()
    return report(measure(quick=options.quick), options)


if __name__ == "__main__":
    sys.exit(main())
