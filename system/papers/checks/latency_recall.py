"""Recall of the latency chip on dies: how far a remembered latency is from what was to be remembered.

No figure of a paper. Chips with several kinds of biases, areas, calibrations and temperatures remember and
recall, and the rms errors are compared. Each of the 33 memories of a die hears one to three inputs at drawn
times (seed 1000), remembers, and is asked again at the next ping, which shows nothing. The error is the
recalled latency less that of equation (9), at the design's numbers; lost is what was not recalled at all.
Taps are 3 ms apart, and of two within the window the first speaks, so that an ideal chip is early by up to 3
ms. Rules, stated before the run: the nominal die's rms error is at most the window; on dies, ideal
biases, calibration of delay line and integrators makes the rms smaller, at 27 degC.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure

from chips.latency.chip import LatencyChip
from chips.latency.law import evaluation_latency
from circuits.arrays import F64
from system.experiment import Experiment, Progress, Report, with_progress
from system.openspace.law import Bat, arcs_of
from system.plot import COLOURS, sized_axes
from system.rule import at_most, below
from system.spiking_bat.campaign import Build
from system.spiking_bat.chip_brain import design_of
from system.spiking_bat.numbers import Numbers
from system.statement import Statement

FIRST, DIES = 1006, 40  # ours
SEED = 1000
WINDOW = 3e-3  # s
SOME = ("taps", "integrators")
ALL = (*SOME, "shared")

BUILDS: Mapping[str, Build] = {
    "nominal": Build(own=False),
    "ideal": Build("ideal"),
    "ideal, area 16": Build("ideal", area=16.0),
    "ideal, taps and integrators": Build("ideal", SOME),
    "ideal, and shared": Build("ideal", ALL),
    "ideal, and shared, 10 degC": Build("ideal", ALL, temperature_c=10.0),
    "ideal, and shared, 44 degC": Build("ideal", ALL, temperature_c=44.0),
    "gate": Build("gate"),
    "gate, and shared": Build("gate", ALL),
    "gate, and shared, 10 degC": Build("gate", ALL, temperature_c=10.0),
    "gate, and shared, 44 degC": Build("gate", ALL, temperature_c=44.0),
}


@dataclass(frozen=True, slots=True)
class Recalls:
    """Errors of what was recalled, s, float64[n], and how many memories recalled nothing."""

    error: F64
    lost: int

    @property
    def rms(self) -> float:
        """Root mean square of the errors, s; nan without any."""
        return float(np.sqrt(np.mean(np.square(self.error)))) if self.error.size else float("nan")


def reproduce(progress: Progress, dies: int = DIES) -> Report:
    """Recall with all builds on all dies."""
    found = {}
    design = design_of(arcs_of(Bat(ping_rate=10.0)), Numbers())
    for name, build in with_progress(BUILDS.items(), progress):
        seeds = range(FIRST, FIRST + (dies if build.own else 1))
        each = [recalls(build.chip(design, seed), seed) for seed in seeds]
        found[name] = Recalls(np.concatenate([r.error for r in each]), sum(r.lost for r in each))
    return Report(rows(found), lambda figure: _draw(found, figure), notes(found))


def recalls(chip: LatencyChip, seed: int) -> Recalls:
    """Measure what the memories of a chip recall of drawn inputs."""
    random = np.random.default_rng((SEED, seed))
    d, onset = chip.design, chip.addresses.onset
    times, addresses, wanted = [np.zeros(1)], [np.array([onset])], []
    for p in range(d.paths):
        own = random.uniform(8e-3, 30e-3) + random.uniform(0.0, 6e-3, random.integers(1, 4))
        wanted.append(evaluation_latency(list(own), 1.0 / d.integration))
        times.append(own)
        addresses.append(np.full(own.size, p))
    memory = chip.new_memory()
    chip.ping(memory, 0.1, np.concatenate(times), np.concatenate(addresses))
    again = chip.ping(memory, 0.2, np.zeros(1), np.array([onset])).memory
    known = np.isfinite(again)
    return Recalls((again - np.array(wanted))[known], int((~known).sum()))


def rows(found: Mapping[str, Recalls]) -> tuple[Statement, ...]:
    """Make the statements about the nominal and the calibrated chip."""
    nominal = found["nominal"].rms
    usual, trimmed = found["ideal"].rms, found["ideal, taps and integrators"].rms
    return (
        Statement("nominal_recall_error_rms_s", WINDOW, nominal, at_most(WINDOW, "at most the window")),
        Statement(
            "calibrated_recall_error_rms_s", usual, trimmed, below(text="below that of dies as they are")
        ),
    )


def notes(found: Mapping[str, Recalls]) -> tuple[str, ...]:
    """Tell the errors of each build."""
    return tuple(
        f"{name}: rms {1e3 * r.rms:.2f} ms, mean {1e3 * r.error.mean():.2f} ms, lost {r.lost} of"
        f" {r.lost + r.error.size}"
        for name, r in found.items()
        if r.error.size
    )


def _draw(found: Mapping[str, Recalls], figure: Figure) -> None:
    ax = sized_axes(figure, 7.2, 4.6)
    names = list(found)
    ax.barh(np.arange(len(names)), [1e3 * r.rms for r in found.values()], color=COLOURS[0])
    ax.set_yticks(np.arange(len(names)), names, fontsize=8)
    ax.invert_yaxis()
    ax.axvline(1e3 * WINDOW, color=COLOURS[1], linestyle=":")
    ax.set_xlabel("error of the recalled latency, rms (ms)")


EXPERIMENT = Experiment("latency-recall", "recall error of latency chips on dies", reproduce)
