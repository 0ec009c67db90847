"""Claim: sensor, link, chip, read-out and robot together run at 10 times real time on one core.

A Pushbot drives from each scene's start, with all noise and mismatch on, until it touches something or the
time is over. By CPU time of the thread, the fastest of some turns; the peer is the time simulated. Making
the chip's tables, once a die, is a row of its own without a claim.

Returns 1 where a claim is missed.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from dataclasses import asdict, dataclass

from circuits.die import Die
from system.pushbot import Scenario, make_brain, run_with, scene_of

CLAIM = 10.0
LONGEST = 6.0  # s of a run
DIE, SEED = Die(number=1000), 1000
SCENES = ("single-block", "pair", "clutter", "office", "target")
RUNS = (
    *(Scenario(scene=name, duration=LONGEST, seed=SEED, die=DIE) for name in SCENES),
    Scenario(scene="clutter", modified=True, duration=LONGEST, seed=SEED, die=DIE),
)


@dataclass(frozen=True, slots=True)
class Row:
    """A measured figure: CPU seconds of ours, seconds of the peer, their ratio."""

    name: str
    ours: float
    peer: float
    ratio: float
    accuracy: str
    cores: int = 1
    claim: float = 0.0


def main() -> int:
    """Measure and print all rows."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--quick", action="store_true", help="one turn a scene")
    options = parser.parse_args()
    turns = 1 if options.quick else 3
    rows = [row for scenario in RUNS for row in of_run(scenario, turns)]
    if options.json:
        print(json.dumps([asdict(row) for row in rows], indent=2))
    else:
        for row in rows:
            claim = f" (claim {row.claim:g})" if row.claim else ""
            print(f"{row.name:36} {row.ours:8.4f} s, {row.ratio:6.1f} times real time{claim}; {row.accuracy}")
    return int(any(row.ratio < row.claim for row in rows))


def of_run(scenario: Scenario, turns: int) -> list[Row]:
    """The loop in a scene, and making its chip."""
    name = f"{scenario.scene}{', modified' if scenario.modified else ''}"
    begin = time.thread_time()
    brain = make_brain(scenario)
    brain.chip.at_rest()
    made = time.thread_time() - begin
    scene, readout = scene_of(scenario), scenario.read()
    trace, best = run_with(brain, scenario, scene, readout), float("inf")  # compiles
    for _ in range(turns):
        begin = time.thread_time()
        trace = run_with(brain, scenario, scene, readout)
        best = min(best, time.thread_time() - begin)
    long = trace.drive.time
    note = f"{trace.record.inputs / long:.3g} inputs of the chip a second"
    return [
        Row(name, best, long, long / best, note, claim=CLAIM),
        Row(f"{name}, chip made", made, long, long / made, "once a die and network"),
    ]


if __name__ == "__main__":
    sys.exit(main())
