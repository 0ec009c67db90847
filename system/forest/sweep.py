"""Sweeps of forest configurations over speed, and statements about where two of them differ.

Wen & Horiuchi 2022, Figure 11, has 200 samples a configuration. Here a configuration ends at 200 collisions
or `PINGS` pings, of which 2.5e8 would take minutes each; what is censored keeps an exact interval. Seeds
begin at 50,000; the bat's numbers were chosen on seeds below.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, TypeVar

from circuits.arrays import I64
from system.experiment import Experiment, Progress, Report
from system.forest.campaign import COLLISIONS, Case, Limits, Tally, differ_p, equivalent_p, fly_all
from system.openspace.law import Bat
from system.plot import COLOURS, INK, draw_estimates
from system.rule import Measured, equivalent, significant
from system.statement import Statement
from system.study.campaign import ALONE, Execution
from system.verdict.family import family
from system.verdict.null import Null, Rows, nulls_of, shuffled

if TYPE_CHECKING:
    from matplotlib.axes import Axes

PINGS = 10_000_000  # a configuration: some 20 s on one core; ours
COUNTS = {"collisions": COLLISIONS}  # of an experiment that sweeps
P = 0.05  # the paper's
# The paper says "no different" by a test of 200 collisions each, which finds this factor between means in
# four of five cases (`detectable_ratio` of equal ways, 400 events); what is smaller it cannot exclude. Ours.
MARGIN = 1.34

WORDS = {1: "better", -1: "worse"}

ALIKE, DRAWN = "every configuration is alike", "configurations drawn anew"
NULLS = (ALIKE, DRAWN)  # of what compares configurations

Label = TypeVar("Label")
Cases = Mapping[tuple[str, float], Case]  # by name of the bat and V_MAX, m/s
Sweep = Mapping[tuple[str, float], Tally]  # likewise


def at_speeds(bats: Mapping[str, Bat], speeds: Sequence[float]) -> dict[tuple[str, float], Case]:
    """Every bat at every V_MAX (m/s)."""
    return {(name, v): Case(replace(bat, max_speed=v)) for name, bat in bats.items() for v in speeds}


def fly_sweep(execution: Execution, name: str, cases: Cases, limits: Limits, progress: Progress) -> Sweep:
    """Fly all cases of a sweep, as the campaign of a name."""
    labels = {f"{bat}, {v:g} m/s": (bat, v) for bat, v in cases}
    labelled = {label: cases[key] for label, key in labels.items()}
    found = fly_all(execution, name, labelled, limits, progress)
    return {key: found[label] for label, key in labels.items()}


def differs_row(
    name: str, one: Tally, other: Tally, direction: int, against: str, *, fitted: bool = False
) -> Statement:
    """A row on whether `one` avoids significantly more (direction 1), fewer (-1) or neither (0)."""
    if not direction:
        return _alike_row(name, one, other, against, fitted=fitted)
    p = differ_p(one, other)
    better = one.mean.value > other.mean.value
    said = "not told apart" if p >= P else WORDS[1 if better else -1]
    shown = f"{said}, {_short(one)} against {_short(other)}, p {p:.2g}"
    rule = significant(direction, P, f"{WORDS[direction]} than {against}")
    return Statement(name, WORDS[direction], Measured(1.0 if better else -1.0, shown, p=p), rule, fitted)


def _alike_row(name: str, one: Tally, other: Tally, against: str, *, fitted: bool) -> Statement:
    """A row on whether two are no different, that is, their means by less than a factor."""
    p = equivalent_p(one, other, MARGIN)
    shown = f"{_short(one)} against {_short(other)}, p {p:.2g} of a factor of {MARGIN:g}"
    rule = equivalent(MARGIN, P, f"no different than {against}, within a factor of {{limit:g}} (ours)")
    return Statement(name, "no different", Measured(0.0, shown, p=p), rule, fitted)


def sweep_nulls(
    rows: Callable[[Mapping[Label, Tally]], Rows], found: Mapping[Label, Tally]
) -> tuple[Null, ...]:
    """Nulls of configurations by any label.

    In one all have the samples of that with the middle mean, in the other samples change places.
    """
    every = list(found.values())
    middle = sorted(every, key=lambda tally: tally.mean.value)[len(every) // 2]

    def told(tallies: Sequence[Tally]) -> dict[Label, Tally]:
        places = zip(found.items(), tallies, strict=True)
        return {label: replace(mine, samples=other.samples) for (label, mine), other in places}

    def drawn(order: I64) -> dict[Label, Tally]:
        return told([every[k] for k in order])

    alike = {ALIKE: told([middle] * len(every))}
    return (*nulls_of(rows, alike), shuffled(DRAWN, rows, drawn, len(every)))


def lines(found: Sweep) -> tuple[str, ...]:
    """Return a line for each configuration: mean, interval, collisions, and samples that were censored."""
    return tuple(f"{name}, {speed:g} m/s: {line(tally)}" for (name, speed), tally in found.items())


def line(tally: Tally) -> str:
    """Return a line with what a configuration gave."""
    mean, n = tally.mean, tally.collisions
    cut = f", {tally.censored} samples without one" if tally.censored else ""
    trapped = sum(s.trapped for s in tally.samples)
    return (
        f"{mean.value:.4g} avoided a collision ({mean.interval.low:.4g} to {mean.interval.high:.4g}),"
        f" {n} collisions{cut}, {tally.pings} pings, trapped {trapped} times"
    )


def sweep_experiment(
    name: str,
    summary: str,
    cases: Callable[[], Cases],
    rows: Callable[[Sweep], tuple[Statement, ...]],
    notes: Callable[[Sweep], tuple[str, ...]] = lines,
) -> Experiment:
    """An experiment that flies a sweep and draws its means over speed.

    Parameters
    ----------
    name, summary
        The experiment's.
    cases
        Makes all configurations. A run of the experiment takes others as `flown`.
    rows
        Makes the statements about what was found; their tests are one family.
    notes
        Makes the sentences for the reader.
    """

    def judged(found: Sweep) -> Rows:
        return family(rows(found))

    def reproduce(
        progress: Progress,
        execution: Execution = ALONE,
        collisions: int = COLLISIONS,
        pings: int = PINGS,
        flown: Cases | None = None,
    ) -> Report:
        limits = Limits(collisions, pings)
        found = fly_sweep(execution, name, cases() if flown is None else flown, limits, progress)
        nulls = sweep_nulls(judged, found)
        return Report(judged(found), lambda figure: draw_sweep(found, figure.subplots()), notes(found), nulls)

    return Experiment(name, summary, reproduce, COUNTS, NULLS)


def draw_sweep(found: Sweep, ax: Axes) -> None:
    """Mean avoided obstacles over V_MAX with 95 % intervals."""
    names = list(dict.fromkeys(name for name, _ in found))
    for k, name in enumerate(names):
        mine = {speed: tally for (n, speed), tally in found.items() if n == name}
        draw_means(list(mine), list(mine.values()), name, k, ax)
    ax.set_xlabel("V_MAX (m/s)")
    ax.set_ylabel("avoided obstacles a collision")
    ax.legend()


def draw_means(x: Sequence[float], tallies: Sequence[Tally], label: str, k: int, ax: Axes) -> None:
    """Means with their intervals, on a logarithmic scale; a triangle is a lower end."""
    met = {at: t.mean for at, t in zip(x, tallies, strict=True) if t.collisions}
    look = {"color": COLOURS[k], "marker": "o", "markersize": 3.5, "capsize": 2, "label": label}
    draw_estimates(list(met), list(met.values()), look, ax)
    for at, tally in zip(x, tallies, strict=True):
        if not tally.collisions:
            ax.plot(at, tally.mean.interval.low, color=COLOURS[k], marker="^", markersize=6)
    ax.set_yscale("log")
    ax.tick_params(colors=INK)


def _short(tally: Tally) -> str:
    return f"{tally.mean.value:.4g}" if tally.collisions else f"above {tally.mean.interval.low:.4g}"
