"""Claim: sensor, link, chip, read-out and robot together run at 10 times real time on one core.

A Pushbot drives from each scene's start, with all noise and mismatch on, until it touches something or the
time is over. By CPU time of the thread, the fastest of some turns; the peer is the time simulated. Making
the chip's tables, once a die, is a row of its own without a claim.

Returns 1 where a claim is missed.
"""

from __future__ import annotations

import sys
import time

from _report import Row, parser_of, report
from circuits.silicon.die import Die
from system.pushbot.run import make_brain, run_with
from system.pushbot.scenario import Scenario, scene_of

CLAIM = 10.0
LONGEST = 6.0  # s of a run
DIE, SEED = Die(number=1000), 1000
SCENES = ("single-block", "pair", "clutter", "office", "target")
RUNS = (
    *(Scenario(scene=name, duration=LONGEST, seed=SEED, die=DIE) for name in SCENES),
    Scenario(scene="clutter", modified=True, duration=LONGEST, seed=SEED, die=DIE),
)


def main() -> int:
    """Measure and print all rows."""
    parser = parser_of(__doc__, "one turn a scene")
    options = parser.parse_args()
    turns = 1 if options.quick else 3
    rows = [row for scenario in RUNS for row in of_run(scenario, turns)]
    return report(rows, options, lambda row: f"{row.ours:8.4f} s, {row.ratio:6.1f} times real time")


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
        Row(name, best, long, long / best, note, least=CLAIM),
        Row(f"{name}, chip made", made, long, long / made, "once a die and network"),
    ]


if __name__ == "__main__":
    sys.exit(main())
