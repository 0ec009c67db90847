"""Claim: the sonar's approach runs at 0.5 times real time at transistor level, 1,000 times at behavioural.

There is no peer that runs this loop; the ratio is to real time. Every part is stepped at its stated tolerance
(`system.approach.run`); accuracy is the largest change of a call's time, of those both runs made, when all
tolerances are divided by ten. The behavioural run is compared with that same reference, in CPU time, for a
short and for a long flight, on the nominal die and on one with mismatch:

loop alone: the compiled loop, which has the claim. With set-up: a whole run in a process that has made one
before, so that records are read and the nominal circuit is prepared; from the scenario to the trace, it makes
the die's boards, hearing and neurons, works the plan of the sleeping neurons out, flies, and reads the log.
Nothing of another run is taken over.
"""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from _report import Row, parser_of, report
from circuits.silicon.die import NOMINAL, Die
from system.approach import behavioural as behavioural_approach
from system.approach import loop
from system.approach import run as approach
from system.approach.scenario import Scenario
from system.approach.trace import Trace

CLAIM, CLAIM_LOOP = 0.5, 1000.0  # times real time
REPEATS = 15  # of a behavioural run
LONG = 60.0  # s of flight
DIE = Die(number=1003)


def timed(scenario: Scenario, workers: int) -> tuple[float, Trace]:
    """Wall seconds and trace of a run."""
    start = time.perf_counter()
    trace = approach.run(scenario, workers=workers)
    return time.perf_counter() - start, trace


def main() -> int:
    """Time the run on one worker and on all cores."""
    options = parser_of(__doc__, "2 s of flight instead of 4").parse_args()
    scenario = Scenario(duration=2.0 if options.quick else 4.0)
    timed(Scenario(duration=0.3), 1)  # compiles the kernels
    rows = []
    reference = _converged(scenario)
    for workers in sorted({1, os.cpu_count() or 1}):
        seconds, trace = timed(scenario, workers)
        n = min(len(trace.calls), len(reference.calls))
        shift = float(np.abs(trace.calls[:n, 0] - reference.calls[:n, 0]).max())
        name = f"approach, {scenario.duration:g} s, {workers} workers"
        note = f"call times within {shift * 1e3:.3g} ms of a run at a tenth of the tolerances"
        ratio = scenario.duration / seconds
        rows.append(Row(name, seconds, scenario.duration, ratio, note, workers, CLAIM))
    rows += _behavioural(scenario, reference)
    return report(rows, options, lambda row: f"{row.ours:9.4f} s, {row.ratio:.2f} times real time")


def _behavioural(scenario: Scenario, reference: Trace) -> Iterator[Row]:
    """Fastest and median CPU time on one worker: the loop alone, and whole runs with their set-up."""
    scenario = replace(scenario, level="behavioural")
    _, trace = timed(scenario, 1)
    n = min(len(trace.calls), len(reference.calls))
    shift = float(np.abs(trace.calls[:n, 0] - reference.calls[:n, 0]).max())
    accuracy = f"call times within {shift * 1e3:.3g} ms of transistors at a tenth of the tolerances"
    for die, duration in ((NOMINAL, scenario.duration), (NOMINAL, LONG), (DIE, LONG)):
        wanted = replace(scenario, duration=duration, die=die)
        for name, spent in zip(("loop alone", "with set-up"), _cpu(wanted), strict=True):
            best, middle = min(spent), float(np.median(spent))
            row = f"approach, {duration:g} s, behavioural, {die}, {name}"
            note = f"median {duration / middle:.0f} times; "
            note += accuracy if die == NOMINAL else "not compared with transistors"
            claim = CLAIM_LOOP if name == "loop alone" else 0.0
            yield Row(row, best, duration, duration / best, note, least=claim)


def _cpu(scenario: Scenario) -> tuple[list[float], list[float]]:
    """CPU seconds of the compiled loop, and of the whole run, a number a repeat."""
    loops, wholes = [], []
    fly = behavioural_approach.fly

    def watched(*arguments: object) -> float:
        start = time.process_time()
        reached = fly(*arguments)
        loops[-1] += time.process_time() - start
        return reached

    behavioural_approach.fly = watched
    try:
        for _ in range(REPEATS):
            loops.append(0.0)
            start = time.process_time()
            approach.run(scenario, workers=1)
            wholes.append(time.process_time() - start)
    finally:
        behavioural_approach.fly = fly
    return loops, wholes


def _converged(scenario: Scenario) -> Trace:
    chip, board = loop.CHIP_RTOL, loop.BOARD_RTOL
    loop.CHIP_RTOL, loop.BOARD_RTOL = 0.1 * chip, 0.1 * board
    try:
        return approach.run(scenario)
    finally:
        loop.CHIP_RTOL, loop.BOARD_RTOL = chip, board


if __name__ == "__main__":
    sys.exit(main())
