"""Claim: blame names no more devices than a greedy search by hand on the same failing dies of the approach.

The search by hand knows which three devices of each neuron matter (`system.papers.checks.blame.PLACES`), and
heals, one at a time, the one with which a run without noise holds its target longest, until that run holds it
for 90 % of the time. What it found is verified as what blame found is: on 40 trials and more with noise that
no search has used, success less than 10 points below that of the healed die. Dies are those of
`noctule reproduce blame`, whose kept outcomes are read.

`ours` is the share of dies that blame mends with so many devices at most, `peer` that of the search by hand,
verified. The note has the share whose run without noise holds, as a search by hand alone would have it.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from _report import Row, parser_of, report
from chips.ranging import circuit as ranging_chip
from circuits.silicon.die import Die
from system.papers.checks.blame import BY_HAND, DIE, FIRST, OPTIONS, PLACES, Outcome, mended_by
from system.registry import load_system
from system.study.blame.trial import Case, Trials
from system.study.blame.verdict import verify

KEPT = Path(__file__).parents[1] / "evidence" / "blame.jsonl"
HELD = 0.9  # of the time after the first second, at which a run is mended; of the search by hand
MOST = 12  # devices that it heals at most; ours
FRESH = 900_000  # seed from which verifications go on; ours
KNOWN = tuple(
    f"ranging_chip.neuron[{k}].{place}.v_t0" for k in range(ranging_chip.NEURONS) for place in PLACES
)


@dataclass(frozen=True, slots=True)
class ByHand:
    """What the search by hand found on a die: devices, runs, whether its run holds, and whether it mends."""

    devices: int
    runs: int
    holds: bool
    mends: bool


def main() -> int:
    """Measure and print all rows."""
    options = parser_of(__doc__, "three dies").parse_args()
    dies = blamed()
    if options.quick:
        dies = dict(list(dies.items())[:3])
    return report(list(rows(dies)), options, shown)


def shown(row: Row) -> str:
    """What a row says in the table."""
    return f"{row.ours:.3g}" if row.peer is None else f"{row.ours:.2f}, by hand {row.peer:.2f}"


def blamed() -> dict[int, Outcome]:
    """What blame found on each die that was to blame, by its number."""
    found = {}
    for line in KEPT.read_text().splitlines()[1:]:
        each = json.loads(line)
        kind, number = each["key"]
        if kind == DIE and each["found"]["guilty"]:
            found[number] = Outcome(**{**each["found"], "named": tuple(each["found"]["named"])})
    return found


def rows(dies: dict[int, Outcome]) -> Iterator[Row]:
    """Rows by number of devices, and of the runs."""
    system = load_system("approach")
    hand = {number: by_hand(system, number) for number in dies}
    for count in BY_HAND:
        ours = np.mean([mended_by(each, count) for each in dies.values()])
        peer = np.mean([each.mends and each.devices <= count for each in hand.values()])
        holds = np.mean([each.holds and each.devices <= count for each in hand.values()])
        note = f"{len(dies)} dies from {FIRST}; without noise and unverified {holds:.2f}"
        yield Row(f"mended by {count}", float(ours), float(peer), float(ours - peer), note, least=-1e-9)
    mended = {k: each.devices for k, each in hand.items() if each.mends}
    longer = sum(not mended_by(dies[k], devices) for k, devices in mended.items())
    note = f"of {len(mended)} that it mends; {sum(not dies[k].mends for k in mended)} of them blame does not"
    yield Row("dies that blame does not mend with as few as by hand", float(longer), None, None, note)
    runs = [each.runs for each in hand.values()]
    note = f"blame takes {np.mean([each.trials for each in dies.values()]):.0f}, verification included"
    yield Row("runs of a search by hand", float(np.mean(runs)), None, None, note)


def by_hand(system: Any, number: int) -> ByHand:
    """Search on a die by hand, and verify what was found."""
    die = Die(number=number, process=False)
    case = Case(system, system.on_silicon(**OPTIONS, die=die, seed=number))
    quiet = replace(case.scenario, silicon_noise="off")
    healed: list[str] = []
    runs = 0

    def held(paths: list[str]) -> float:
        nonlocal runs
        runs += 1
        given = system.summarise(system.run(replace(quiet, die=case.healed(paths))))
        return float(given["held_fraction"] or 0.0)

    best = held(healed)
    while best < HELD and len(healed) < MOST:
        left = [path for path in KNOWN if path not in healed]
        reached = [held([*healed, path]) for path in left]
        best = max(reached)
        healed.append(left[reached.index(best)])
    mends = verify(Trials(case), case.healed(healed), FRESH).mends
    return ByHand(len(healed), runs, best >= HELD, mends)


if __name__ == "__main__":
    sys.exit(main())
