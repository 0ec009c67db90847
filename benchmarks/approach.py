"""Claim: the sonar's approach runs at least 0.3 times real time at transistor level, 10 times at behavioural.

There is no peer that runs this loop; the ratio is to real time. Every part is stepped at its stated tolerance
(`system.approach`); accuracy is the largest change of a call's time, of those both runs made, when all
tolerances are divided by ten. The behavioural run is compared with that same reference; its set-up (records,
the die's neurons) is counted.
"""

from __future__ import annotations

import argparse
import json
import os
import time
from dataclasses import replace

import numpy as np

from system import approach


def timed(scenario: approach.Scenario, workers: int) -> tuple[float, approach.Trace]:
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
    scenario = approach.Scenario(duration=2.0 if options.quick else 4.0)
    timed(approach.Scenario(duration=0.3), 1)  # compiles the kernels
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
    rows.append(_behavioural(scenario, reference))
    if options.json:
        print(json.dumps(rows, indent=2))
        return
    for row in rows:
        print(f"{row['name']:34} {row['ours']:8.2f} s, {row['ratio']:.2f} times real time; {row['accuracy']}")


def _behavioural(scenario: approach.Scenario, reference: approach.Trace) -> dict[str, str | float | int]:
    """Fastest of three runs, on one worker."""
    scenario = replace(scenario, level="behavioural")
    timed(scenario, 1)
    seconds, trace = min((timed(scenario, 1) for _ in range(3)), key=lambda run: run[0])
    n = min(len(trace.calls), len(reference.calls))
    shift = float(np.abs(trace.calls[:n, 0] - reference.calls[:n, 0]).max())
    return {
        "name": f"approach, {scenario.duration:g} s, behavioural",
        "ours": seconds,
        "peer": scenario.duration,
        "ratio": scenario.duration / seconds,
        "accuracy": f"call times within {shift * 1e3:.3g} ms of transistors at a tenth of the tolerances",
        "cores": 1,
    }


def _converged(scenario: approach.Scenario) -> approach.Trace:
    chip, board = approach.CHIP_RTOL, approach.BOARD_RTOL
    approach.CHIP_RTOL, approach.BOARD_RTOL = 0.1 * chip, 0.1 * board
    try:
        return approach.run(scenario)
    finally:
        approach.CHIP_RTOL, approach.BOARD_RTOL = chip, board


if __name__ == "__main__":
    main()
