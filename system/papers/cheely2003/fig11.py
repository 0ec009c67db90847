"""Figure 11 of Cheely & Horiuchi (2003): call amplitude and repetition rate while a target approaches.

One run of `approach` with first-target isolation and one without, clutter 1 m behind the target in both.
The paper prints traces without numbers; its statements are about direction and order.
"""

from __future__ import annotations

from matplotlib.figure import Figure

from system.approach.run import run
from system.approach.trace import Scenario, Trace, draw, summarise
from system.experiment import Experiment, Progress, Report, Row

DURATION = 4.0  # s
HELD = 0.9  # share of the time nearer to the target than to the clutter; ours
LOST = 0.5


def rows(isolated: Trace, mixed: Trace) -> tuple[Row, ...]:
    """Statements about a run with isolation and one without."""
    with_isolation, without = summarise(isolated), summarise(mixed)
    interval, longest = with_isolation["shortest_interval_s"], with_isolation["longest_best_delay_s"]
    return (
        _compare("call_rate_Hz", "rises", with_isolation, "call_rate"),
        _compare("call_amplitude_V", "falls", with_isolation, "call_amplitude"),
        Row(
            name="shortest_interval_s",
            paper=longest,
            ours=interval,
            rule="longer than the longest best delay",
            tolerance=None,
            fitted=False,
            agrees=interval is not None and longest is not None and interval > longest,
        ),
        _share("held_fraction_with_isolation", with_isolation, HELD, above=True),
        _share("held_fraction_without_isolation", without, LOST, above=False),
    )


def _compare(name: str, way: str, summary: dict[str, float | None], stem: str) -> Row:
    unit = name.rsplit("_", maxsplit=1)[1]
    first, last = summary[f"{stem}_first_{unit}"], summary[f"{stem}_last_{unit}"]
    known = first is not None and last is not None
    change = last - first if first is not None and last is not None else None
    agrees = change is not None and (change > 0.0 if way == "rises" else change < 0.0)
    ours = f"{first:.3g} to {last:.3g}" if known else None
    paper, rule = f"{way} during the approach", f"last {way} from first"
    return Row(name, paper, ours, rule, None, fitted=False, agrees=agrees)


def _share(name: str, summary: dict[str, float | None], bound: float, *, above: bool) -> Row:
    value = summary["held_fraction"]
    agrees = value is not None and (value >= bound if above else value < bound)
    rule = f"{'at least' if above else 'below'} {bound:g}"
    paper = "first target only" if above else "all targets mixed"
    return Row(name, paper, value, rule, bound, fitted=False, agrees=agrees)


def reproduce(progress: Progress, duration: float = DURATION) -> Report:
    """Run the approach twice, `duration` s each."""
    isolated = run(Scenario(duration=duration), lambda f: progress(0.5 * f))
    mixed = run(Scenario(duration=duration, isolation=False), lambda f: progress(0.5 + 0.5 * f))

    def picture(figure: Figure) -> None:
        draw(isolated, figure)

    notes = (
        f"{isolated.counts['clipped_samples']} microphone samples were clipped at the rails",
        f"{isolated.counts['merged_events']} events fell into the pulse of the one before",
        "in a gap between two neurons' best delays the clutter's echo can set off the chip",
    )
    return Report(rows(isolated, mixed), picture, notes)


EXPERIMENT = Experiment(
    "cheely2003-fig11",
    "call amplitude and rate while a target approaches, all at transistor level",
    reproduce,
)
