"""Blame on the approach: how many devices mend a failing die, and whether a planted fault is named.

No figure of a paper. The sonar's dies have mismatch alone, and its chip the design's biases at fixed gates.
Beside it stands a greedy search by hand on other dies of the same kind, which knew three kinds of devices: it
mended 28, 49, 64, 82 and 95 % of failing dies with 1, 3, 4, 7 and 10 devices, in about 140 runs without noise
each. A fault is planted on such a die whose devices at `PLACES`, without which all dies succeed, are healed:
the V_T0 of one of these is off by `FAULT` either way, all other devices deviate as they do. A fault that
makes no trial fail is passed over.

The rules were written before the dies from `FIRST` on were run.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from importlib.metadata import version
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from chips.ranging import circuit as ranging_chip
from circuits.silicon.die import Die
from system.codes.find import quietly
from system.experiment import Experiment, Progress, Report
from system.registry import load_system
from system.rule import at_least, at_most, unjudged
from system.statement import Statement
from system.study.blame.blame import BUDGET, blame
from system.study.blame.trial import Case
from system.study.blame.verdict import NothingFailsError
from system.study.campaign import ALONE, Campaign, Execution, Numbered, Runs
from system.study.statistics.share import Share, share_where
from system.verdict.null import nulls_of

RANDOM = "devices at random"  # null
FIRST, DIES, FAULTS = 1000, 50, 100
BY_HAND: Mapping[int, float] = {1: 0.28, 3: 0.49, 4: 0.64, 7: 0.82, 10: 0.95}
FAULT = 0.06  # V, either way; ours
NAMED = 0.95  # of the faults
MOST_RANDOM = 0.1  # of sets of devices at random that mend
OPTIONS: dict[str, Any] = {"level": "behavioural", "bias_kind": "gate"}
PLACES = ("membrane.mr1", "membrane.mr2", "inhibition.mi5")  # of faults: their gates are fixed, below 1 nA
DIE, PLANTED = "die", "planted"


@dataclass(frozen=True, slots=True)
class Outcome:
    """What blame found on a die.

    failing : whether a trial fails on it.
    guilty : whether the die is to blame.
    named : paths of the fewest that mend.
    mends : whether they do, on trials of their own.
    trials : runs that were made.
    random, sets : sets of as many at random that mend, of how many.
    planted : path of the device with the fault; empty for none.
    devices : devices of what was named; 0 where that was not counted.
    """

    failing: bool
    guilty: bool = False
    named: tuple[str, ...] = ()
    mends: bool = False
    trials: int = 0
    random: int = 0
    sets: int = 0
    planted: str = ""
    devices: int = 0

    @property
    def named_first(self) -> bool:
        """Whether the first that is named is the device with the fault."""
        return bool(self.named) and self.named[0].startswith(f"{self.planted}.")


Found = Mapping[str, Sequence[Outcome]]  # of dies and faults to blame


def reproduce(
    progress: Progress, execution: Execution = ALONE, dies: int = DIES, faults: int = FAULTS
) -> Report:
    """Blame as many failing dies and planted faults."""
    campaign = Campaign(
        "blame", run_one, Numbered, Outcome, (version("noctule"), OPTIONS, FAULT, PLACES, BUDGET)
    )
    wanted, found = {DIE: dies, PLANTED: faults}, {}
    with execution.open(campaign) as runs:
        for name, count in wanted.items():
            found[name] = guilty(runs, name, count)
            progress(sum(map(len, found.values())) / max(dies + faults, 1))
    return Report(
        statements(found), lambda figure: _draw(found, figure), notes(found),
        nulls_of(statements, {RANDOM: at_random(found)}),
    )  # fmt: skip


def guilty(runs: Runs[Numbered, Outcome], name: str, count: int) -> list[Outcome]:
    """The first so many outcomes with somebody to blame; a die may fail by its noise alone."""
    kept: list[Outcome] = []
    if count > 0:
        with closing(runs.of(_keys(name))) as results:
            for each in results:
                kept += [each] if each.guilty else []
                if len(kept) == count:
                    break
    return kept


def _keys(name: str) -> Iterator[Numbered]:
    number = FIRST
    while True:
        yield Numbered(name, number)
        number += 1


def run_one(key: Numbered) -> Outcome:
    """Blame a die of the number, or a fault planted on it."""
    device = _device(key.number) if key.condition == PLANTED else ""
    die = _with_fault(device, key.number) if device else Die(number=key.number, process=False)
    system = load_system("approach")
    case = Case(system, system.on_silicon(**OPTIONS, die=die, seed=key.number))
    return replace(blamed(case), planted=device)


def blamed(case: Case) -> Outcome:
    """Blame a robot on a die."""
    try:
        with quietly():
            found = blame(case)
    except NothingFailsError:
        return Outcome(failing=False)
    if not found.accused.guilty:
        return Outcome(failing=True, trials=found.trials)
    random = found.random or Share(0, 0)
    return Outcome(
        failing=True, guilty=True, named=tuple(each.path for each in found.culprits),
        mends=found.verified is not None and found.verified.mends, trials=found.trials,
        random=random.passed, sets=random.of,
        devices=sum({_owner(path): count for path, count in found.counts.items()}.values()),
    )  # fmt: skip


def _device(number: int) -> str:
    """Path of a device at random, of a neuron and one of `PLACES`."""
    rng = np.random.default_rng((number, 1))
    neuron, place = int(rng.integers(ranging_chip.NEURONS)), PLACES[int(rng.integers(len(PLACES)))]
    return f"ranging_chip.neuron[{neuron}].{place}"


def _with_fault(device: str, number: int) -> Die:
    """The die of a number, without the deviations at `PLACES`, with the fault on a device."""
    own = Die(number=number, process=False).healed(*(f"ranging_chip.neuron[*].{place}" for place in PLACES))
    return own.with_(device, "v_t0", FAULT if number % 2 else -FAULT)


def statements(found: Found) -> tuple[Statement, ...]:
    """Make the rows: dies mended by number of devices, faults named, devices at random, trials."""
    rows = []
    for count, by_hand in BY_HAND.items():
        share = share_where(mended_by(run, count) for run in found[DIE])
        rows.append(Statement(f"mended_by_{count}", by_hand, share.measured(), at_least(by_hand)))
    named = share_where(run.named_first for run in found[PLANTED])
    rows.append(Statement("planted_named_first", None, named.measured(), at_least(NAMED)))
    sets = Share(sum(run.random for run in found[DIE]), sum(run.sets for run in found[DIE]))
    rows.append(Statement("random_sets_mend", None, sets.measured(), at_most(MOST_RANDOM)))
    trials = [run.trials for runs in found.values() for run in runs]
    rows.append(Statement("most_trials", None, float(max(trials, default=0)), at_most(float(BUDGET))))
    median = float(np.median([len(run.named) for run in found[DIE]])) if found[DIE] else float("nan")
    rows.append(Statement("median_devices", None, median, unjudged("told")))
    return tuple(rows)


def mended_by(run: Outcome, count: float) -> bool:
    """Whether healing so many devices at most mends."""
    return run.mends and devices_of(run) <= count


def devices_of(run: Outcome) -> int:
    """How many devices were named; a part that was not taken apart has many."""
    return run.devices or len({*map(_owner, run.named)})


def _owner(path: str) -> str:
    """Path of a device without its parameter."""
    head, _, last = path.rpartition(".")
    return head if last in {"v_t0", "beta"} else path


def at_random(found: Found) -> Found:
    """As many devices at random in place of those that were named."""
    return {
        name: [
            replace(run, mends=bool(run.sets) and run.random == run.sets, named=("at random.v_t0",))
            for run in runs
        ]
        for name, runs in found.items()
    }


def notes(found: Found) -> tuple[str, ...]:
    """What was named on each die, and faults that were not named."""
    lines = [
        f"die: {', '.join(run.named[:10])}{' and more' if len(run.named) > 10 else ''};"
        f" {'mends' if run.mends else 'not shown to mend'}, {run.trials} trials."
        for run in found[DIE]
    ]
    missed = [run for run in found[PLANTED] if not run.named_first]
    return (*lines, *(f"not named: {run.planted}, but {', '.join(run.named[:3])}." for run in missed))


def _draw(found: Found, figure: Figure) -> None:
    """Share of failing dies that are mended against the number of devices, beside the search by hand."""
    ax = figure.subplots()
    counts = np.arange(1, 13)
    shares = [share_where(mended_by(run, float(n)) for run in found[DIE]).value for n in counts]
    ax.step(counts, shares, where="post", label="blame")
    ax.plot(list(BY_HAND), list(BY_HAND.values()), "o", label="greedy by hand, other dies")
    ax.axhline(0.8, lw=0.6)
    ax.set_xlabel("devices healed")
    ax.set_ylabel("failing dies mended, share")
    ax.set_ylim(0.0, 1.05)
    ax.legend()


EXPERIMENT = Experiment(
    "blame", "devices that mend failing dies of the approach, and planted faults", reproduce,
    {"dies": DIES, "faults": FAULTS}, (RANDOM,),
)  # fmt: skip
