"""What the fit of a chip's measurements is worth: measurements of known dies, each fitted alone.

Transistors' sweeps and a pair on the bench of the teaching chip, with numbers of process, devices and bench
drawn from what is thought of them before. In these rows `paper` is what a fit that is right about itself has:
a number lies in its interval of 95 % on 95 of 100 dies.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from matplotlib.figure import Figure
from scipy.stats import binomtest

from circuits.arrays import Bools
from circuits.errors import DataError
from circuits.extraction.coach.conditions import read_conditions
from circuits.extraction.coach.left_out import SIGMAS
from circuits.extraction.coach.synthetic import Known, known_fit
from circuits.extraction.coach.table import read_folder
from circuits.silicon.process import ROLLS_180
from system.experiment import Experiment, Progress, Report, with_progress
from system.plot import COLOURS, INK, PALE, entitle
from system.rule import at_least, at_most, unjudged
from system.statement import Statement

DIES, FIRST = 200, 1000
MEASUREMENTS = (
    "fet_n_output_family", "fet_n_ohmic_vg", "fet_n_sub_vg", "fet_n_backgate", "fet_p_sat_vg", "fet_p_sub_vg",
    "fet_p_backgate", "ndp_run1", "c2f_cal_ndp_i1_runA", "c2f_cal_ndp_i2_runA",
)  # fmt: skip
_PAIR = ("differential_pair.m1.v_t0", "differential_pair.m2.v_t0")
_LEVEL = 0.01  # of the test over all numbers


def reproduce(progress: Progress, dies: int = DIES, names: Sequence[str] = MEASUREMENTS) -> Report:
    """Fit measurements of known dies, count how often each number is where the fit says.

    Parameters
    ----------
    progress
        Is told the share that is done.
    dies
        How many.
    names
        Which of the chip's measurements are made.
    """
    known = read_conditions()
    data = {n: d for n, d in read_folder(None, "fit", known).items() if n in names}
    found, failed = [], 0
    for die in with_progress(range(FIRST, FIRST + dies), progress):
        try:
            found.append(known_fit(data, known, ROLLS_180, die))
        except DataError:
            failed += 1
    rows = (*_coverage(found), *_pair(found), Statement("fits_that_fail", 0, failed, at_most(0.05 * dies)))
    return Report(rows, lambda figure: draw(found, figure))


def _fixed(found: Sequence[Known]) -> Iterator[tuple[str, Bools]]:
    """Numbers of the process that the fits fix, and which dies have them in their interval."""
    first = found[0].posterior
    free = set(first.free())
    scores = np.array([each.score() for each in found])
    for k, unknown in enumerate(first.unknowns):
        if unknown.kind == "process" and unknown.name not in free:
            yield unknown.name, np.asarray(np.abs(scores[:, k]) <= SIGMAS)


def _coverage(found: Sequence[Known]) -> Iterator[Statement]:
    chances = {}
    for name, inside in _fixed(found):
        chances[name] = float(binomtest(int(inside.sum()), inside.size, 0.95).pvalue)
        text = f"{int(inside.sum())} of {inside.size} dies"
        yield Statement(f"{name.replace(' ', '_')}_covered_share", 0.95, float(inside.mean()), unjudged(text))
    # Holm: the least of the p-values, each times how many are not less
    ordered = sorted(chances.values())
    least = min((p * (len(ordered) - k) for k, p in enumerate(ordered)), default=1.0)
    yield Statement("least_chance_of_coverage_by_holm", None, min(least, 1.0), at_least(_LEVEL))


def _pair(found: Sequence[Known]) -> Iterator[Statement]:
    """How far the pair's offset is off on the identified die, over how far it is on the nominal one."""
    names = found[0].posterior.names
    one, other = (names.index(name) for name in _PAIR)
    truth = np.array([each.truth[one] - each.truth[other] for each in found])
    mean = np.array([each.posterior.mean[one] - each.posterior.mean[other] for each in found])
    share = float(np.sqrt(((mean - truth) ** 2).mean() / (truth**2).mean()))
    yield Statement("pair_offset_error_over_nominal", None, share, at_most(1.0 / 3.0))


def draw(found: Sequence[Known], figure: Figure) -> None:
    """Fill a figure with how far each fixed number is off, in standard errors, of each die.

    Parameters
    ----------
    found
        What the fit of each die says, beside the numbers that it was to find.
    figure
        The figure, empty.
    """
    axes = figure.subplots()
    names = [name for name, _ in _fixed(found)]
    first = found[0].posterior
    for k, name in enumerate(names):
        scores = [each.score()[first.names.index(name)] for each in found]
        axes.plot(np.full(len(scores), k), scores, ".", color=COLOURS[0], markersize=3)
    axes.axhspan(-SIGMAS, SIGMAS, color=PALE, alpha=0.4, linewidth=0)
    axes.axhline(0.0, color=INK, linewidth=0.5)
    axes.set_xticks(range(len(names)), names, rotation=60, ha="right", fontsize=7)
    axes.set_ylabel("found less true, in standard errors")
    entitle(f"{len(found)} known dies, each fitted alone", axes)


EXPERIMENT = Experiment(
    "coach-synthetic", "measurements of known dies of the teaching chip, each fitted alone", reproduce
)
