"""Section 3.6 and Figure 13 of Milde et al. 2017: driving around in an office.

The paper: four runs of 0.5 to 1.5 minutes with one crash, so about 0.25 a minute. A run ends at its first
crash or after a minute. Rule (ours): the lower end of the 95 % Poisson interval of our crashes a minute is
not above the upper end of the paper's, one crash in 4 minutes; in normal light. Other lights are told.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial

from matplotlib.figure import Figure
from scipy.stats import chi2

from system.arena import LIGHTS
from system.experiment import Experiment, Progress, Report, Row
from system.pushbot import Scenario, Trace, summarise
from system.pushbot_campaign import Summary, drive_each, trials
from system.pushbot_run_picture import draw_run
from system.study.interval import LEVEL, Interval

RUNS, DIES = 50, 10  # of each light
DURATION = 60.0  # s
PAPER_CRASHES, PAPER_MINUTES = 1, 4.0


def reproduce(
    progress: Progress, count: int = RUNS, dies: int = DIES, duration: float = DURATION,
    lights: Sequence[str] = tuple(LIGHTS),
) -> Report:  # fmt: skip
    """Drive all runs."""
    traces: list[Trace] = []

    def keep(trace: Trace) -> Summary:
        traces[:] = [*traces, trace][:1]
        return summarise(trace)

    base = Scenario(scene="office", duration=duration)
    plan = [s for light in lights for s in trials(replace(base, light=light), count, dies)]
    runs = drive_each(plan, keep, progress)
    found = {light: runs[k * count : (k + 1) * count] for k, light in enumerate(lights)}
    return Report(rows(found), partial(_draw, traces[0]), notes(found))


def poisson(count: int, minutes: float) -> Interval:
    """Exact 95 % interval of a rate, 1/min (Garwood 1936)."""
    tail = 0.5 * (1.0 - LEVEL)
    low = float(chi2.ppf(tail, 2 * count)) / 2.0 if count else 0.0
    return Interval(low / minutes, float(chi2.ppf(1.0 - tail, 2 * (count + 1))) / 2.0 / minutes)


def rows(found: Mapping[str, Sequence[Summary]]) -> tuple[Row, ...]:
    """Crashes a minute in the first light."""
    theirs = poisson(PAPER_CRASHES, PAPER_MINUTES)
    crashes, minutes = crashes_in(next(iter(found.values())))
    ours = poisson(crashes, minutes)
    shown = f"{crashes / minutes:.2f} ({ours.low:.2f} to {ours.high:.2f})"
    return (
        Row(
            "crashes_a_minute", PAPER_CRASHES / PAPER_MINUTES, shown, f"lower end at most {theirs.high:.2f}",
            theirs.high, fitted=False, agrees=ours.low <= theirs.high,
        ),
    )  # fmt: skip


def crashes_in(found: Sequence[Summary]) -> tuple[int, float]:
    """Crashes and minutes."""
    return sum(bool(s["collided"]) for s in found), sum(s["time_s"] or 0.0 for s in found) / 60.0


def notes(found: Mapping[str, Sequence[Summary]]) -> tuple[str, ...]:
    """Crashes, minutes and way by light."""
    out = []
    for light, runs in found.items():
        crashes, minutes = crashes_in(runs)
        ends = poisson(crashes, minutes)
        way = sum(s["path_m"] or 0.0 for s in runs)
        out.append(
            f"{light}: {crashes} crashes in {len(runs)} runs, {minutes:.1f} min and {way:.0f} m,"
            f" {crashes / minutes:.2f} a minute ({ends.low:.2f} to {ends.high:.2f})"
        )
    return tuple(out)


def _draw(trace: Trace, figure: Figure) -> None:
    draw_run(trace.scene, trace.drive, trace.brain, trace.record, figure)


EXPERIMENT = Experiment("milde2017-office", "crashes a minute in an office", reproduce)
