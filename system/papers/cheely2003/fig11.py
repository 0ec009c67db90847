"""Figure 11 of Cheely & Horiuchi 2003: call amplitude and repetition rate while a target approaches.

The system `approach` is run at transistor level, once with first-target isolation and once without, with
clutter 1 m behind the target in both. The paper prints traces without numbers, so that its statements about
directions are compared: the rate rises, the amplitude falls, and the isolation keeps the chip at the target.
"""

from __future__ import annotations

from system.approach.run import run
from system.approach.scenario import Scenario
from system.approach.trace import draw, summarise
from system.experiment import Experiment, Progress, Report, part
from system.papers.conditions import FIXED_GATES
from system.rule import Measured, Rule, above, at_least, below
from system.statement import Statement
from system.verdict.null import nulls_of

DURATION = 4.0  # s
HELD = 0.9  # share of the time nearer to the target than to the clutter; ours
LOST = 0.5
NULLS = ("never changes, always at the target", "never changes, always at the clutter")

Summary = dict[str, float | None]


def rows(with_isolation: Summary, without: Summary) -> tuple[Statement, ...]:
    """Make the statements about a run with first-target isolation and one without."""
    interval, longest = with_isolation["shortest_interval_s"], with_isolation["longest_best_delay_s"]
    return (
        _change("call_rate_Hz", "rises", with_isolation, above(0.0, "last rises from first")),
        _change("call_amplitude_V", "falls", with_isolation, below(0.0, "last falls from first")),
        Statement("shortest_interval_s", longest, interval, above(text="longer than the longest best delay")),
        Statement(
            "held_fraction_with_isolation",
            "first target only",
            with_isolation["held_fraction"],
            at_least(HELD),
        ),
        Statement(
            "held_fraction_without_isolation", "all targets mixed", without["held_fraction"], below(LOST)
        ),
    )


def _change(name: str, way: str, summary: Summary, rule: Rule) -> Statement:
    """A statement about the last of a quantity less its first."""
    stem, unit = name.rsplit("_", maxsplit=1)
    first, last = summary[f"{stem}_first_{unit}"], summary[f"{stem}_last_{unit}"]
    ours = None
    if first is not None and last is not None:
        ours = Measured(last - first, f"{first:.3g} to {last:.3g}")
    return Statement(name, f"{way} during the approach", ours, rule)


def reproduce(progress: Progress, duration: float = DURATION) -> Report:
    """Run the approach with and without isolation, for `duration` s each."""
    isolated = run(Scenario(duration=duration, **FIXED_GATES), part(progress, 0.0, 0.5))
    mixed = run(Scenario(duration=duration, isolation=False, **FIXED_GATES), part(progress, 0.5, 1.0))
    notes = (
        f"{isolated.counts['clipped_samples']} microphone samples were clipped at the rails",
        f"{isolated.counts['merged_events']} events fell into the pulse of the one before",
        "in a gap between two neurons' best delays the clutter's echo can set off the chip",
    )
    found = summarise(isolated), summarise(mixed)
    constant = {
        name: [_constant(each, held) for each in found] for name, held in zip(NULLS, (1.0, 0.0), strict=True)
    }
    nulls = nulls_of(lambda pair: rows(*pair), constant)
    return Report(rows(*found), lambda figure: draw(isolated, figure), notes, nulls)


def _constant(summary: Summary, held: float) -> Summary:
    """A bat that calls as at the beginning all the time, wherever the chip is."""
    rate, amplitude = summary["call_rate_first_Hz"], summary["call_amplitude_first_V"]
    return summary | {
        "call_rate_last_Hz": rate, "call_amplitude_last_V": amplitude, "held_fraction": held,
        "shortest_interval_s": 1.0 / rate if rate else None,
    }  # fmt: skip


EXPERIMENT = Experiment(
    "cheely2003-fig11",
    "call amplitude and rate while a target approaches, all at transistor level",
    reproduce,
    nulls=NULLS,
)
