"""Claim: the sonar's approach runs at 0.5 times real time at transistor level, 1,000 times at behavioural.

There is no peer that runs this loop; the ratio is to real time. Every part is stepped at its stated tolerance
(`system.approach`); accuracy is the largest change of a call's time, of those both runs made, when all
tolerances are divided by ten. The behavioural run is compared with that same reference; its compiled loop is
timed alone, and with the set-up (records, the die's neurons), for a short and for a long flight.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import time
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from system import approach, behavioural_approach
from system.approach_trace import Scenario, Trace


def timed(scenario: Scenario, workers: int) -> tuple[float, Trace]:
    """Wall seconds and trace of a run."""
    start = time.perf_counter()
    trace = approach.run(scenario, workers=workers)
    return time.perf_counter() - start, trace


def main() -> None:
    """Time the run on one worker and on all cores."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--quick", action="store_true", help="2 s of flight instead of 4")
    options = parser.parse_args()
    scenario = Scenario(duration=2.0 if options.quick else 4.0)
    timed(Scenario(duration=0.3), 1)  # compiles the kernels
    rows: list[dict[str, str | float | int]] = []
    reference = _converged(scenario)
    for workers in sorted({1, os.cpu_count() or 1}):
        seconds, trace = timed(scenario, workers)
        n = min(len(trace.calls), len(reference.calls))
        shift = float(np.abs(trace.calls[:n, 0] - reference.calls[:n, 0]).max())
        rows.append(
            {
                "name": f"approach, {scenario.duration:g} s, {workers} workers",
                "ours": seconds,
                "peer": scenario.duration,
                "ratio": scenario.duration / seconds,
                "accuracy": f"call times within {shift * 1e3:.3g} ms of a run at a tenth of the tolerances",
                "cores": workers,
            }
        )
    rows += _behavioural(scenario, reference)
    if options.json:
        print(json.dumps(rows, indent=2))
        return
    for row in rows:
        print(f"{row['name']:46} {row['ours']:9.4f} s, {row['ratio']:.2f} times real time; {row['accuracy']}")


def _behavioural(scenario: Scenario, reference: Trace) -> Iterator[dict[str, str | float | int]]:
    """Fastest of five runs each, on one worker: the loop alone, and whole runs with their set-up."""
    scenario = replace(scenario, level="behavioural")
    _, trace = timed(scenario, 1)
    n = min(len(trace.calls), len(reference.calls))
    shift = float(np.abs(trace.calls[:n, 0] - reference.calls[:n, 0]).max())
    accuracy = f"call times within {shift * 1e3:.3g} ms of transistors at a tenth of the tolerances"
    spent: list[float] = []
    loop = behavioural_approach.fly

    def watched(*arguments: object) -> float:
        start = time.perf_counter()
        reached = loop(*arguments)
        spent[-1] += time.perf_counter() - start
        return reached

    short = scenario.duration
    for duration, name in (
        (short, "loop alone"), (short, "with set-up"), (60.0, "loop alone"), (60.0, "with set-up")
    ):  # fmt: skip
        best = math.inf
        for _ in range(5):
            spent.append(0.0)
            behavioural_approach.fly = watched
            try:
                whole, _ = timed(replace(scenario, duration=duration), 1)
            finally:
                behavioural_approach.fly = loop
            best = min(best, whole if name == "with set-up" else spent[-1])
        yield {
            "name": f"approach, {duration:g} s, behavioural, {name}",
            "ours": best,
            "peer": duration,
            "ratio": duration / best,
            "accuracy": accuracy,
            "cores": 1,
        }


def _converged(scenario: Scenario) -> Trace:
    chip, board = approach.CHIP_RTOL, approach.BOARD_RTOL
    approach.CHIP_RTOL, approach.BOARD_RTOL = 0.1 * chip, 0.1 * board
    try:
        return approach.run(scenario)
    finally:
        approach.CHIP_RTOL, approach.BOARD_RTOL = chip, board


if __name__ == "__main__":
    main()
