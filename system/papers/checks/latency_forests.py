"""Figure 13 of Wen & Horiuchi 2022 over many forests: network, nominal chip and analog model, paired.

Network, nominal latency chip and analog model fly through the same forests, of which the paper shows one. How
often they cross without a failure is compared with that flight, and between chip and network in pairs. The
forests have 1,400 obstacles and seeds from 1006 on, the bat 2 m/s and ten pings a second. A flight fails by
a collision, or by a minute in a loop (`system.spiking_bat.circling`); it is stopped at 8 crossings or 600 s,
and is censored then; each kind is counted. The paper shows one flight, of four crossings without a collision.
Rules: the interval of the network's and of the chip's product-limit estimate of crossing four times overlaps
that of the paper's flight, one of one (exact, from 2.5 %); the chip flies no differently from the network: by
two one-sided tests at 5 % neither is better in `MARGIN` of the pairs more than the other. The chip flies
without noise there, as a law of numbers, and again with white noise and with all noise of its devices, of the
forest's seed: how many of its loops its regularity makes. These rows have no rule.

The network takes a minute and more a flight: `--param network=6` has it fly fewer forests, `--output` keeps
what is flown.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import lru_cache

import numpy as np
from matplotlib.figure import Figure

from circuits.errors import ParameterError
from system.experiment import Experiment, Progress, Report
from system.options.noise import Noisy
from system.plot import COLOURS, sized_axes
from system.rule import Measured, equivalent, overlapping, unjudged
from system.spiking_bat.campaign import (
    CROSSINGS,
    Build,
    Crossed,
    Maker,
    chip_maker,
    crossed,
    crossed_by_analog,
    flights_of,
    mean_crossings,
    network_maker,
    sign_test,
    survival,
)
from system.statement import Statement
from system.study.campaign import ALONE, Execution, Numbered
from system.study.statistics.comparison import paired_equivalence
from system.study.statistics.interval import Interval
from system.study.statistics.share import Share
from system.verdict.null import nulls_of

FIRST_SEED = 1006
FORESTS, NETWORK = 100, 100  # that analog model and chip fly, and the network
PAPER = 4  # crossings
SIGNIFICANT = 0.05
# of the pairs, by which one may be better than the other and both fly alike: what a hundred flights tell of a
# share at best, half of its 95 % interval at one half; ours
MARGIN = 0.1
NULLS = ("always collides", "never moves")

CHIPS: Mapping[str, Noisy] = {"chip": "off", "chip, white noise": "white", "chip, all noise": "all"}

Flights = Mapping[str, Sequence[Crossed]]


def reproduce(
    progress: Progress, execution: Execution = ALONE, forests: int = FORESTS, network: int = NETWORK
) -> Report:
    """Fly all models; raises `ParameterError` for more forests of the network than of the others."""
    if network > forests:
        raise ParameterError(f"network: {network} forests, must be at most the {forests} of the other models")
    counts = {"analog": forests, **dict.fromkeys(CHIPS, forests), "network": network}
    keys = [Numbered(model, FIRST_SEED + k) for model, count in counts.items() for k in range(count)]
    flights = execution.by_condition(flights_of("latency-forests", fly_one), keys, progress)
    nulls = nulls_of(rows, _nulls(flights))
    return Report(rows(flights), lambda figure: draw_survival(flights, figure), notes(flights), nulls)


def _nulls(flights: Flights) -> dict[str, Flights]:
    """Bats that collide at once, and that stay where they are."""
    return {
        told: {
            name: [replace(f, laps=0, collided=hit, caught=not hit) for f in each]
            for name, each in flights.items()
        }
        for told, hit in zip(NULLS, (True, False), strict=True)
    }


def fly_one(key: Numbered) -> Crossed:
    """Fly a model through the forest of a seed."""
    model, seed = key
    return crossed_by_analog(seed) if model == "analog" else crossed(_maker(model), seed)


@lru_cache(maxsize=4)
def _maker(model: str) -> Maker:
    return network_maker() if model == "network" else chip_maker(Build(own=False, noisy=CHIPS[model]))


def rows(flights: Flights) -> tuple[Statement, ...]:
    """Make the statements about four crossings, and about chip and network."""
    made = []
    for name in ("network", "chip"):
        ours = _four_crossings(flights[name])
        rule = overlapping(
            Share(1, 1).interval, "intervals overlap: {low:.3f}-{high:g} of the paper's one flight"
        )
        made.append(Statement(f"{name}_four_crossings_share", 1.0, ours, rule))
    count = len(flights["network"])
    better, worse, p = sign_test(flights["chip"][:count], flights["network"])
    alike = paired_equivalence(better, worse, count, MARGIN)
    shown = f"{better} better, {worse} worse of {count}, p {alike:.2g}; that they differ, p {p:.2g}"
    rule = equivalent(MARGIN, SIGNIFICANT, "no different by {percent:g} % of the pairs (ours)")
    made.append(Statement("chip_against_network", None, Measured(0.0, shown, p=alike), rule))
    for name in CHIPS:
        where = name.replace(", ", "_").replace(" ", "_")
        loops = sum(f.caught for f in flights[name]) / len(flights[name])
        made.append(Statement(f"{where}_share_in_loops", None, loops, unjudged("no rule")))
        made.append(Statement(f"{where}_crossings", None, mean_crossings(flights[name]), unjudged("no rule")))
    return tuple(made)


def _four_crossings(flights: Sequence[Crossed]) -> Measured:
    """Estimated share that crosses four times, with its interval, which is the share where all failed."""
    _, share, low, high = (float(column[PAPER]) for column in survival(flights))
    ends = Interval(low, high) if np.isfinite(low) and np.isfinite(high) else Interval(share, share)
    return Measured(share, f"{share:.2f} ({ends.low:.2f} to {ends.high:.2f})", ends)


def notes(flights: Flights) -> tuple[str, ...]:
    """Tell the flights of each model, and the pairs."""
    found = [described(name, each) for name, each in flights.items()]
    pairs = [("chip", "analog"), ("network", "analog"), *((name, "chip") for name in [*CHIPS][1:])]
    for a, b in pairs:
        count = min(len(flights[a]), len(flights[b]))
        better, worse, p = sign_test(flights[a][:count], flights[b][:count])
        found.append(f"{a} against {b}: {better} pairs better, {worse} worse, p {p:.2g}")
    return tuple(found)


def described(name: str, flights: Sequence[Crossed]) -> str:
    """Describe flights in a line."""
    collided, loops = sum(f.collided for f in flights), sum(f.caught for f in flights)
    through = sum(not f.collided and f.laps >= CROSSINGS for f in flights)
    late = len(flights) - collided - through
    _, share, low, high = survival(flights)
    four = f"{share[PAPER]:.2f} ({low[PAPER]:.2f} to {high[PAPER]:.2f})"
    return (
        f"{name}: {len(flights)} flights, {collided} collided, {through} stopped at {CROSSINGS} crossings,"
        f" {late} before, {loops} of them in a loop; four crossings {four},"
        f" {sum(f.laps >= PAPER for f in flights)} were seen to; {mean_crossings(flights):.2f} crossings on"
        f" average, up to {CROSSINGS}; {sum(f.pings for f in flights)} pings"
    )


def draw_survival(flights: Flights, figure: Figure) -> None:
    """Draw the share of flights that crossed so often without a failure, with intervals."""
    ax = sized_axes(figure, 6.4, 4.4)
    for k, (name, each) in enumerate(flights.items()):
        count, share, low, high = survival(each)
        colour = COLOURS[k % len(COLOURS)]
        again = CHIPS.get(name, "off") != "off"  # a line alone: its interval would hide the others
        line = "--" if again else "-"
        ax.step(count, share, line, where="post", color=colour, label=f"{name}, {len(each)} flights")
        if not again:
            ax.fill_between(count, low, high, step="post", color=colour, alpha=0.15)
    ax.set(xlabel="crossings of the left border", ylabel="share without a failure", ylim=(0.0, 1.05))
    ax.legend(fontsize=8)


EXPERIMENT = Experiment(
    "latency-forests", "many forests: network, chip and analog model", reproduce,
    {"forests": FORESTS, "network": NETWORK}, NULLS,
)  # fmt: skip
