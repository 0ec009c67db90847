"""Blame on robots: how many devices mend a failing die of a Pushbot, a forest's bat and a spiking bat.

No figure of a paper. Dies have all their deviations. The spiking bat's biases come from the bias generator at
codes of a calibration. The Pushbot has fixed gates, and the forest's bat the design's codes: few calibrated
dies of a Pushbot fail, and a calibrated bat of the forest collides about as often on the healed die. Each die
from 1000 on is asked until as many were to blame as are wanted; its number is the seed of its first trial.
What the sonar's dies have to blame is `system.papers.checks.blame`.

The rules were written before the dies from 1000 on were run.
"""

from __future__ import annotations

from collections.abc import Mapping
from importlib.metadata import version
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from circuits.silicon.die import Die
from system.experiment import Experiment, Progress, Report
from system.papers.checks.blame import (
    MOST_RANDOM,
    RANDOM,
    Found,
    Outcome,
    at_random,
    blamed,
    devices_of,
    guilty,
    mended_by,
)
from system.registry import load_system
from system.rule import at_least, at_most, unjudged
from system.statement import Statement
from system.study.blame.blame import BUDGET
from system.study.blame.trial import Case
from system.study.campaign import ALONE, Campaign, Execution, Numbered
from system.study.statistics.share import Share, share_where
from system.verdict.null import nulls_of

ROBOTS: Mapping[str, Mapping[str, Any]] = {
    "pushbot": {"scene": "single-block", "bias_kind": "gate"},
    "forest": {"pings": 200, "codes": "default"},
    "spiking-bat": {},
}
"""Options of each, by its name."""
DIES = 5  # of each; ours
MENDED = 0.8  # of failing dies, whatever healing it takes; ours


def reproduce(
    progress: Progress, execution: Execution = ALONE, pushbot: int = DIES, forest: int = DIES, bat: int = DIES
) -> Report:
    """Blame as many failing dies of each robot."""
    campaign = Campaign("blame-robots", run_one, Numbered, Outcome, (version("noctule"), ROBOTS, BUDGET))
    wanted, found = dict(zip(ROBOTS, (pushbot, forest, bat), strict=True)), {}
    with execution.open(campaign) as runs:
        for name, count in wanted.items():
            found[name] = guilty(runs, name, count)
            progress(sum(map(len, found.values())) / max(sum(wanted.values()), 1))
    return Report(
        statements(found), lambda figure: _draw(found, figure), notes(found),
        nulls_of(statements, {RANDOM: at_random(found)}),
    )  # fmt: skip


def run_one(key: Numbered) -> Outcome:
    """Blame a robot on the die of a number."""
    system = load_system(key.condition)
    scenario = system.on_silicon(**ROBOTS[key.condition], die=Die(number=key.number), seed=key.number)
    return blamed(Case(system, scenario))


def statements(found: Found) -> tuple[Statement, ...]:
    """Make the rows of each robot that was blamed: dies mended, with how many, sets at random, trials."""
    rows = []
    for name, runs in found.items():
        if not runs:
            continue
        own = name.replace("-", "_")
        mended = share_where(mended_by(run, np.inf) for run in runs)
        rows.append(Statement(f"{own}_mended", None, mended.measured(), at_least(MENDED)))
        rows.append(Statement(f"{own}_devices_for_80", None, _devices(found, name), unjudged("told")))
        sets = Share(sum(run.random for run in runs), sum(run.sets for run in runs))
        if sets.of:  # parts that hold many devices are not drawn at random
            rows.append(Statement(f"{own}_random_sets_mend", None, sets.measured(), at_most(MOST_RANDOM)))
        most = float(max(run.trials for run in runs))
        rows.append(Statement(f"{own}_most_trials", None, most, at_most(float(BUDGET))))
    return tuple(rows)


def _devices(found: Found, name: str) -> float:
    """Devices, or parts that hold many, with which 80 % of the dies are mended; NaN where fewer are."""
    sizes = sorted(devices_of(run) for run in found[name] if run.mends)
    needed = int(np.ceil(MENDED * len(found[name])))
    return float(sizes[needed - 1]) if len(sizes) >= needed else float("nan")


def notes(found: Found) -> tuple[str, ...]:
    """What was named on each die."""
    return tuple(
        f"{name}: {', '.join(run.named[:10])}{' and more' if len(run.named) > 10 else ''};"
        f" {'mends' if run.mends else 'not shown to mend'}, {run.trials} trials."
        for name, runs in found.items()
        for run in runs
    )


def _draw(found: Found, figure: Figure) -> None:
    """Share of failing dies that are mended against the number of devices, a line each robot."""
    ax = figure.subplots()
    counts = np.arange(1, 21)
    for name, runs in found.items():
        shares = [share_where(mended_by(run, float(n)) for run in runs).value for n in counts]
        ax.step(counts, shares, where="post", label=f"{name}, {len(runs)} dies")
    ax.axhline(MENDED, lw=0.6)
    ax.set_xlabel("devices healed, or parts that hold many")
    ax.set_ylabel("failing dies mended, share")
    ax.set_ylim(0.0, 1.05)
    ax.legend()


EXPERIMENT = Experiment(
    "blame-robots", "devices that mend failing dies of a Pushbot, a forest's bat and a spiking bat",
    reproduce,
    {"pushbot": DIES, "forest": DIES, "bat": DIES}, (RANDOM,),
)  # fmt: skip
