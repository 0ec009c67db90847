"""Claim: a ROLLS chip whose 52,388 excitatory synapses are all depressed runs 25 times real time at 60 Hz.

The chip of `rolls_chip.py`, 256 neurons and 65,536 synapses of which four of five excite, with short-term
depression and without, one core, CPU time of the thread, best of some turns of 1 s. Every spike is an event
of 205 depressed synapses, of one weight device each; a sparse chip of 20 excitatory synapses a neuron of
level 4, three devices each, stands beside. The peer column has the same chip without depression.

Returns 1 where the claim is missed.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from _report import Row, parser_of, report
from chips.rolls.chip import RollsChip
from chips.rolls.depression.program import STEP_BIAS, ShortTermDepression
from chips.rolls.program.address import NEURONS
from chips.rolls.program.program import Program
from chips.validity import outside_boxes
from circuits.blocks.rolls.depressing_synapse import STEP
from circuits.silicon.die import Die
from circuits.silicon.process import ROLLS_180_IDEAL
from circuits.silicon.silicon import Silicon
from rolls_chip import program

CLAIM = 25.0  # times real time, all synapses depressed
DIE = 1000
FAN_IN = 20
TURNS, QUICK = 15, 5


def sparse() -> Program:
    """FAN_IN synapses of level 4 a neuron, as strong together as the full matrix, and its direct current."""
    draw = np.random.default_rng(1)
    levels = np.zeros((NEURONS, NEURONS), np.int8)
    for row in levels:
        row[draw.choice(NEURONS, FAN_IN, replace=False)] = 4
    weak = program().biases
    for name in ("NPA_WEIGHT_EXC_P", "NPA_WEIGHT_EXC0_P", "NPA_WEIGHT_EXC1_P"):
        weak = weak.with_code(name, 5, 255)
    return Program(levels, weak)


def measure(turns: int) -> Iterator[Row]:
    """All rows."""
    for name, plain, least in (("all synapses", program(), CLAIM), ("20 a neuron, level 4", sparse(), 0.0)):
        biases = plain.biases.with_code(STEP_BIAS, *STEP)
        depressed = replace(plain, biases=biases, depression=ShortTermDepression())
        without, _, _ = _best(plain, turns)
        with outside_boxes("warn"):  # speed alone is measured: weights of a full matrix are below the box
            taken, rate, events = _best(depressed, turns)
        note = f"{rate:.1f} Hz mean, {events / 1e6:.2f} million depressed events in 1 s"
        yield Row(f"{name}, times real time", taken, without, 1.0 / taken, note, least=least)
        each = (taken - without) / events
        yield Row(f"{name}, ns an event more", each * 1e9, None, each * 1e9, "other rates aside")


def _best(chosen: Program, turns: int) -> tuple[float, float, float]:
    """Seconds of 1 s, mean rate (Hz), and events of excitatory synapses."""
    chip = RollsChip(chosen, Silicon(ROLLS_180_IDEAL, 27.0, Die(number=DIE)), "ideal")
    _, state = chip.run(chip.at_rest(), 0.2)
    best, events, spikes = float("inf"), 0.0, 0
    for _ in range(turns):
        start = time.thread_time()
        found, _ = chip.run(state, 1.0)
        best = min(best, time.thread_time() - start)
        spikes = found.times.size
        events = float((chosen.levels > 0).sum(axis=0)[found.neurons].sum())
    return best, spikes / NEURONS, events


def main() -> int:
    """Measure and print all rows."""
    options = parser_of(__doc__, "fewer turns").parse_args()
    return report(measure(QUICK if options.quick else TURNS), options)


if __name__ == "__main__":
    sys.exit(main())
