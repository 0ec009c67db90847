"""What the fit of a chip's measurements is worth: measurements of known dies, each fitted alone.

Numbers of process, devices and bench are drawn from what is thought of them before, and what the bench of the
teaching chip would read of them is fitted: transistors' sweeps and a pair, as `noctule extract` does, and the
pair with the winner-take-all's inputs in the measured process, as `noctule identify` does. In these rows
`paper` is what a fit that is right about itself has: a number lies in its interval of 95 % on 95 of 100 dies.
Numbers that the fit leaves free are not judged.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from matplotlib.figure import Figure
from scipy.stats import binomtest

from circuits.arrays import F64, Bools
from circuits.errors import DataError
from circuits.extraction.coach.bench import bounded
from circuits.extraction.coach.conditions import read_conditions
from circuits.extraction.coach.left_out import SIGMAS
from circuits.extraction.coach.models import unknowns_of
from circuits.extraction.coach.readings import ring
from circuits.extraction.coach.synthetic import known_fit
from circuits.extraction.coach.table import read_folder
from circuits.extraction.coach.unknown import FREE, Unknown
from circuits.silicon.process import ROLLS_180, Process
from circuits.silicon.process_file import process_of
from system.experiment import Experiment, Progress, Report
from system.plot import COLOURS, INK, PALE, entitle
from system.rule import at_least, at_most, unjudged
from system.statement import Statement
from system.study.campaign import ALONE, Campaign, Execution, Numbered
from system.study.statistics.share import Share

DIES, IDENTIFIED, FIRST = 200, 50, 1000
EXTRACT, IDENTIFY = "extract", "identify"
MEASUREMENTS = (
    "fet_n_output_family", "fet_n_ohmic_vg", "fet_n_sub_vg", "fet_n_backgate", "fet_p_sat_vg", "fet_p_sub_vg",
    "fet_p_backgate", "ndp_run1", "c2f_cal_ndp_i1_runA", "c2f_cal_ndp_i2_runA",
)  # fmt: skip
RING = ("ndp_run1", "c2f_cal_ndp_i1_runA", "c2f_cal_ndp_i2_runA", "wta_cal_iout", "wta_iin_16cells")
KINDS = {EXTRACT: "process", IDENTIFY: "device"}
_PAIR = ("differential_pair.m1.v_t0", "differential_pair.m2.v_t0")
_LEVEL = 0.01  # of the test over all numbers
_MEASURED = "coach-180"


@dataclass(frozen=True, slots=True)
class Found:
    """What the fit of a known die says of numbers of process and devices.

    truth, mean, sd: the numbers, and what the fit says of each, float64[n], as `unknowns` has them. failed:
    why there is no fit; empty where there is one.
    """

    truth: F64
    mean: F64
    sd: F64
    failed: str = ""


@dataclass(frozen=True, slots=True)
class Fits:
    """Fits known dies by their keys; names: measurements that are made, by what they are for."""

    extracted: tuple[str, ...] = MEASUREMENTS
    identified: tuple[str, ...] = RING

    def __call__(self, key: Numbered) -> Found:
        """Draw the die of a number, make its measurements and fit them alone."""
        names = self.extracted if key.condition == EXTRACT else self.identified
        known = read_conditions()
        data = {n: d for n, d in read_folder(None, "fit", known).items() if n in names}
        try:
            found = known_fit(data, known, base_of(key.condition), key.number)
        except DataError as error:
            return Found(np.empty(0), np.empty(0), np.empty(0), str(error))
        kept = np.array([u.kind != "nuisance" for u in found.posterior.unknowns])
        return Found(found.truth[kept], found.posterior.mean[kept], found.posterior.sd[kept])


def base_of(condition: str) -> Process:
    """The process about which the numbers of a condition's dies are drawn."""
    return ROLLS_180 if condition == EXTRACT else process_of(_MEASURED)


@lru_cache(maxsize=2)
def unknowns(condition: str) -> tuple[Unknown, ...]:
    """Numbers of process and devices that a condition's fits have, in their order."""
    every = unknowns_of(read_conditions(), base_of(condition))
    return tuple(u for u in every if u.kind != "nuisance")


def reproduce(
    progress: Progress, execution: Execution = ALONE, dies: int = DIES, identified: int = IDENTIFIED,
    fits: Fits = Fits(),
) -> Report:  # fmt: skip
    """Fit measurements of known dies, count how often each number is where the fit says.

    Parameters
    ----------
    progress
        Is told the share that is done.
    execution
        Who fits, and where the fits are kept.
    dies, identified
        How many are extracted, and how many identified.
    fits
        What fits them.
    """
    keys = [Numbered(EXTRACT, FIRST + k) for k in range(dies)]
    keys += [Numbered(IDENTIFY, FIRST + k) for k in range(identified)]
    numbers = (fits, ROLLS_180, process_of(_MEASURED), read_conditions())
    every = execution.by_condition(Campaign(EXPERIMENT.name, fits, Numbered, Found, numbers), keys, progress)
    rows: list[Statement] = []
    for condition, runs in every.items():
        found = [each for each in runs if not each.failed]
        rows += [*_coverage(condition, found), *_offsets(condition, found)]
        failed = len(runs) - len(found)
        rows.append(Statement(f"{condition}_fits_that_fail", 0, failed, at_most(0.05 * len(runs))))
    return Report(tuple(rows), lambda figure: draw(every, figure))


def _fixed(condition: str, found: Sequence[Found]) -> Iterator[tuple[str, F64]]:
    """Numbers that the fits fix, and how far each die's is off, in its standard errors.

    A number that was drawn below zero where no process can be was zero on the die, and so it is compared.
    """
    mean, sd, truth = (np.array([getattr(f, name) for f in found]) for name in ("mean", "sd", "truth"))
    for k, unknown in enumerate(unknowns(condition)):
        if unknown.kind == KINDS[condition] and np.median(sd[:, k]) <= FREE * unknown.sd:
            found_there, there = (bounded(unknown.name, each[:, k]) for each in (mean, truth))
            yield unknown.name, (found_there - there) / sd[:, k]


def _coverage(condition: str, found: Sequence[Found]) -> Iterator[Statement]:
    chances, every = [], []
    for name, off in _fixed(condition, found):
        inside: Bools = np.abs(off) <= SIGMAS
        share = Share(int(inside.sum()), inside.size)
        chances.append(float(binomtest(share.passed, share.of, 0.95).pvalue))
        every.append(inside)
        between = f"{share.interval.low:.3f} to {share.interval.high:.3f}"
        text = unjudged(f"{share.passed} of {share.of} dies, 95 % interval {between}")
        yield Statement(f"{condition}_{name.replace(' ', '_')}_covered_share", 0.95, share.value, text)
    if every:
        text = unjudged("of all dies and numbers")
        yield Statement(f"{condition}_covered_share", 0.95, float(np.mean(every)), text)
    # Holm: the least of the p-values, each times how many are not less
    least = min((p * (len(chances) - k) for k, p in enumerate(sorted(chances))), default=1.0)
    yield Statement(f"{condition}_least_chance_by_holm", None, min(least, 1.0), at_least(_LEVEL))


def _offsets(condition: str, found: Sequence[Found]) -> Iterator[Statement]:
    """How far offsets are off on the identified dies, over how far they are on the nominal one."""
    names = [u.name for u in unknowns(condition)]
    one, other = (names.index(name) for name in _PAIR)
    truth, mean = (
        [f.truth[one] - f.truth[other] for f in found],
        [f.mean[one] - f.mean[other] for f in found],
    )
    yield Statement(f"{condition}_pair_offset_error", None, _left(truth, mean), at_most(1.0 / 3.0))
    if condition == IDENTIFY:
        sides = (np.array([_inputs(names, getattr(f, side)) for f in found]) for side in ("truth", "mean"))
        yield Statement("identify_ring_inputs_error", None, _left(*sides), at_most(1.0))


def _inputs(names: Sequence[str], values: F64) -> F64:
    """What the ring's inputs with their mirrors deviate by from their own mean, as logarithms."""
    total, _ = ring.matching(dict(zip(names, values.tolist(), strict=True)))
    return np.asarray(total - total.mean())


def _left(truth: Sequence[float] | F64, mean: Sequence[float] | F64) -> float:
    """Error of what was found over what the nominal die leaves, rms."""
    off = np.asarray(mean) - np.asarray(truth)
    return float(np.sqrt((off**2).mean() / (np.asarray(truth) ** 2).mean()))


def draw(every: dict[str, list[Found]], figure: Figure) -> None:
    """Fill a figure with how far each fixed number is off, in standard errors, of each die.

    Parameters
    ----------
    every
        What the fit of each die says, beside the numbers that it was to find, by condition.
    figure
        The figure, empty.
    """
    figure.set_size_inches(7.0, 4.5 * len(every))
    grid = figure.subplots(len(every), 1, squeeze=False)[:, 0]
    for axes, (condition, runs) in zip(grid, every.items(), strict=True):
        found = [each for each in runs if not each.failed]
        fixed = dict(_fixed(condition, found))
        for k, off in enumerate(fixed.values()):
            axes.plot(np.full(off.size, k), off, ".", color=COLOURS[0], markersize=3)
        axes.axhspan(-SIGMAS, SIGMAS, color=PALE, alpha=0.4, linewidth=0)
        axes.axhline(0.0, color=INK, linewidth=0.5)
        axes.set_xticks(range(len(fixed)), fixed, rotation=60, ha="right", fontsize=5)
        axes.set_ylabel("found less true, in standard errors")
        entitle(f"{condition}: {len(found)} known dies, each fitted alone", axes)


EXPERIMENT = Experiment(
    "coach-synthetic", "measurements of known dies of the teaching chip, each fitted alone", reproduce,
    {"dies": DIES, "identified": IDENTIFIED},
)  # fmt: skip
