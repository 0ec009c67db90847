"""Forest with chips: avoided obstacles against area and temperature; what ranging costs, what selection.

No figure of a paper. In each condition four bats fly: an exact one, one with the ranging chip, one with the
selection chip, and one with both. How many obstacles they avoid a collision is compared between bats, and
between conditions:

- Area of the drawn devices of both chips, over the circuits'. Each sample is on a die of its own, with local
  mismatch and without process variation (as if biases were trimmed), read with look-up values calibrated on
  that die at 27 degC. Intervals by bootstrap over samples, so over dies too.
- Temperature of the nominal die with nominal look-up values, fixed gate voltages (`gate`) or the bias
  ideal currents (`ideal`) at the ranging chip; the selection has its gate voltage. Intervals by
  Poisson.

The share of ranging in the loss ln(exact / both) is the mean of what it costs first and what it costs last,

    s = [ln(exact / ranging) + ln(selection / both)] / (2 ln(exact / both)),

that of the selection is 1 - s; a share below 0 or above 1 means that one of them does not cost.

That ranging costs most is likely because its 13 windows are coarse: with earlier numbers of the bat an ideal
quantiser of 2.17 ms had 178 avoided obstacles a collision against 390 with exact ranges, and the chip 135.

Avoided obstacles a collision are not all: a bat whose chip reads all echoes near turns round again and again,
and neither collides nor gets anywhere. So the notes have what it avoids in a thousand pings too.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from matplotlib.figure import Figure

from circuits.arrays import F64
from circuits.circuit import BiasKind
from system.experiment import Experiment, Progress, Report
from system.forest.campaign import COLLISIONS, Case, Limits, Tally, differ_p, fly_all, own_mismatch
from system.forest.sweep import COUNTS, NULLS, P, sweep_nulls
from system.openspace.senses import Sensing, with_area
from system.plot import COLOURS
from system.rule import Measured, at_least, significant
from system.statement import Statement
from system.study.campaign import ALONE, Execution
from system.study.statistics.interval import LEVEL, Interval
from system.verdict.family import family

AREAS = (1.0, 4.0, 16.0, 64.0)
TEMPERATURES = (10.0, 20.0, 27.0, 34.0, 44.0)  # degC
PINGS = 1_000_000  # a configuration; ours
NEAR = 0.5  # of the exact bat's mean, for "near" on the nominal die at 27 degC; ours
BOOTSTRAPS = 2000
BATS = ("exact", "ranging", "selection", "both")
KINDS: tuple[BiasKind, ...] = ("gate", "ideal")

Four = Mapping[str, Tally]


@dataclass(frozen=True, slots=True)
class Study:
    """Counts of four bats, by area, and by kind of bias and temperature (degC)."""

    area: Mapping[float, Four]
    temperature: Mapping[tuple[BiasKind, float], Four]


def reproduce(
    progress: Progress,
    execution: Execution = ALONE,
    collisions: int = COLLISIONS,
    pings: int = PINGS,
    areas: Sequence[float] = AREAS,
    temperatures: Sequence[float] = TEMPERATURES,
) -> Report:
    """Fly four bats at all areas, and at all temperatures with both kinds of bias."""
    by_area = {f"area {a:g}": a for a in areas}
    by_temperature = {f"{kind}, {t:g} degC": (kind, t) for kind in KINDS for t in temperatures}
    cases = {"exact": Case()}
    for label, area in by_area.items():
        sensing = with_area(Sensing("chip", "chip", reader="calibrated"), area)
        cases |= _three(label, Case(sensing=sensing, die=own_mismatch))
    for label, (kind, celsius) in by_temperature.items():
        cases |= _three(label, Case(sensing=Sensing("chip", "chip"), temperature_c=celsius, bias_kind=kind))
    found = fly_all(execution, EXPERIMENT.name, cases, Limits(collisions, pings), progress)

    def studied(found: Mapping[str, Tally]) -> Study:
        return Study(
            {area: _four(label, found) for label, area in by_area.items()},
            {condition: _four(label, found) for label, condition in by_temperature.items()},
        )

    study = studied(found)
    nulls = sweep_nulls(lambda other: rows(studied(other)), found)
    return Report(rows(study), lambda figure: _draw(study, figure), notes(study), nulls)


def _three(label: str, case: Case) -> dict[str, Case]:
    """All bats of a condition with a chip; `case` has both chips."""
    both = case.sensing
    made = {
        "ranging": replace(both, selection="ideal"),
        "selection": replace(both, ranges="exact", reader="nominal"),
        "both": both,
    }
    return {f"{label}, {name}": replace(case, sensing=sensing) for name, sensing in made.items()}


def _four(label: str, found: Mapping[str, Tally]) -> Four:
    """All bats of a condition, the exact one first."""
    return {name: found["exact" if name == "exact" else f"{label}, {name}"] for name in BATS}


def rows(study: Study) -> tuple[Statement, ...]:
    """Make the statements about what silicon ought to do; no paper makes them."""
    areas = sorted(study.area)
    celsius = sorted({t for _, t in study.temperature})
    nominal = study.temperature["gate", 27.0]
    ratio = {n: nominal[n].mean.value / nominal["exact"].mean.value for n in ("ranging", "selection", "both")}
    near = tuple(
        Statement(f"nominal_die_{name}_over_exact", None, value, at_least(NEAR))
        for name, value in ratio.items()
    )
    ends = (
        _worse(
            "least_area", study.area[areas[0]]["both"], study.area[areas[-1]]["both"], "the greatest area"
        ),
        *(
            _worse(f"gate_at_{t:g}_degC", study.temperature["gate", t]["both"], nominal["both"], "27 degC")
            for t in sorted({celsius[0], celsius[-1]} - {27.0})
        ),
    )
    return family((*near, *ends))


def _worse(name: str, one: Tally, other: Tally, against: str) -> Statement:
    """A row on whether `one` avoids significantly fewer."""
    p = differ_p(one, other)
    shown = f"{one.mean.value:.4g} against {other.mean.value:.4g}, p {p:.2g}"
    ours = Measured(one.mean.value - other.mean.value, shown, p=p)
    return Statement(f"{name}_avoids_fewer", None, ours, significant(-1, P, f"worse than {against}"))


def notes(study: Study) -> tuple[str, ...]:
    """Tell every mean with its interval, and the shares."""
    found = []
    for label, four in _labelled(study):
        means = ", ".join(
            f"{name} {four[name].mean.value:.4g} ({_interval(four[name]).low:.3g} to"
            f" {_interval(four[name]).high:.3g})"
            for name in BATS
        )
        share, interval = ranging_share(four)
        spread = f"{interval.low:.2f} to {interval.high:.2f}"
        found.append(f"{label}: {means}; of the loss ranging {share:.2f} ({spread}); {_counted(four)}")
    return tuple(found)


def _labelled(study: Study) -> list[tuple[str, Four]]:
    by_area = [(f"area {a:g}", four) for a, four in study.area.items()]
    return by_area + [(f"{kind}, {t:g} degC", four) for (kind, t), four in study.temperature.items()]


def _counted(four: Four) -> str:
    """What went wrong, of both chips together."""
    samples = four["both"].samples
    echoes = sum(s.heard + s.missed for s in samples)
    pings = sum(s.pings for s in samples)
    missed = sum(s.missed for s in samples) / max(echoes, 1)
    late, ties = (sum(getattr(s, name) for s in samples) / pings for name in ("late", "ties"))
    other = sum(s.other_choices for s in samples) / pings
    flown = (
        f"{1e3 * four['both'].avoided / pings:.0f} avoided in a thousand pings (exact"
        f" {1e3 * four['exact'].avoided / four['exact'].pings:.0f}), trapped"
        f" {sum(s.trapped for s in samples)} times, emergencies at"
        f" {sum(s.emergencies for s in samples) / pings:.0%} of pings"
    )
    return (
        f"{flown}, echoes missed {missed:.1%}, choices late {late:.2%}, tied {ties:.2%}, other than ideal"
        f" {other:.1%}"
    )


def ranging_share(four: Four) -> tuple[float, Interval]:
    """Give the share of ranging in the loss, and its interval by bootstrap over samples."""
    logs = {name: _resampled(four[name]) for name in BATS}
    loss = logs["exact"] - logs["both"]
    cost = 0.5 * (logs["exact"] - logs["ranging"] + logs["selection"] - logs["both"])
    share = cost / np.where(loss == 0.0, np.nan, loss)
    tail = 50.0 * (1.0 - LEVEL)
    low, high = np.nanpercentile(share[1:], (tail, 100.0 - tail))
    return float(share[0]), Interval(float(low), float(high))


def _resampled(tally: Tally) -> F64:
    """Logarithm of avoided obstacles a collision: of the samples, then of samples drawn from them anew."""
    avoided = np.array([s.avoided for s in tally.samples], dtype=np.float64)
    met = np.array([s.collided for s in tally.samples], dtype=np.float64)
    drawn = np.random.default_rng(avoided.size).integers(0, avoided.size, (BOOTSTRAPS, avoided.size))
    chosen = np.concatenate([np.arange(avoided.size)[None], drawn])
    # half a collision where none was met, which keeps the logarithm finite
    return np.asarray(
        np.log(np.maximum(avoided[chosen].sum(axis=1), 0.5) / np.maximum(met[chosen].sum(axis=1), 0.5))
    )


def _interval(tally: Tally) -> Interval:
    """Of the mean, by bootstrap over samples, which dies of their own make more unlike than Poisson does."""
    tail = 50.0 * (1.0 - LEVEL)
    low, high = np.percentile(_resampled(tally)[1:], (tail, 100.0 - tail))
    return Interval(math.exp(low), math.exp(high))


def _draw(study: Study, figure: Figure) -> None:
    figure.set_size_inches(9.6, 4.0)
    one, *others = figure.subplots(1, 3, sharey=True)
    panels = [(one, study.area, "area of devices / drawn", "mismatch, calibrated, 27 degC")]
    for ax, kind in zip(others, KINDS, strict=True):
        mine = {t: four for (k, t), four in study.temperature.items() if k == kind}
        panels.append((ax, mine, "temperature (degC)", f"nominal die, ranging bias: {kind}"))
    for ax, found, label, title in panels:
        for k, name in enumerate(BATS):
            met = {at: four[name] for at, four in found.items() if four[name].collisions}
            y = np.array([tally.mean.value for tally in met.values()])
            ends = np.array([(i.low, i.high) for i in map(_interval, met.values())]).reshape(-1, 2)
            ax.errorbar(
                list(met), y, np.abs(ends.T - y), color=COLOURS[k], marker="o", markersize=3.5, capsize=2,
                label=name,
            )  # fmt: skip
        ax.set(yscale="log", xlabel=label)
        ax.set_title(title, fontsize=9)
    one.set(xscale="log", ylabel="avoided obstacles a collision")
    figure.legend(*one.get_legend_handles_labels(), loc="outside lower center", ncols=4)


EXPERIMENT = Experiment(
    "forest-silicon", "avoided obstacles with chips against area and temperature", reproduce, COUNTS, NULLS
)
