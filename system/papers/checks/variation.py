"""What all components of variation make of a block and of a robot, beside plain dies.

No figure of a paper. A plain die has local mismatch and a process of its own; a full one has gradients across
it, capacitors and resistors that deviate, nFETs that vary with pFETs, and what its wafer and its lot share.
Dies are of one lot, and then each of a lot of its own. On each, with fixed gates and with the bias generator:

* the ranging chip's neurons at both ends of its column, by their model: the time of inhibition of one, and
  its ratio to the other's, which process variation hardly moves and a gradient does;
* the approach with its chips in the loop, whose number is the die's and whose codes are of its calibration
  where its biases have codes.

In these rows `paper` is the number on plain dies and ours that on full ones; none passes or fails.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from importlib.metadata import version
from itertools import product
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from chips.ranging.model import ReboundModel, model_of, neurons_on
from circuits.arrays import F64
from circuits.bias import rebias
from circuits.blocks.sonar import rebound_neuron
from circuits.circuit import BiasKind
from circuits.errors import CircuitError
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500
from circuits.silicon.silicon import Silicon
from system.experiment import Experiment, Progress, Report
from system.papers.checks.beside import KINDS
from system.plot import COLOURS
from system.registry import load_system
from system.rule import unjudged
from system.statement import Statement
from system.study.blame.trial import outcome_of
from system.study.campaign import ALONE, Campaign, Execution, Numbered
from system.study.statistics.share import Share, share_where

FIRST, DIES = 1000, 40  # of the dies, whose numbers are the seeds too
ENDS = (0, 12)  # of the ranging chip's column of neurons
EXTENTS = ("plain", "full", "full, lots")


@dataclass(frozen=True, slots=True)
class Outcome:
    """What a die came to.

    inhibition : of the neurons at both ends, s.
    succeeded : whether the approach did, which a chip that cannot be calibrated does not.
    error : mean error of range, m; None where it was not run.
    failed : why it was not run; empty where it was.
    """

    inhibition: tuple[float, float]
    succeeded: bool
    error: float | None = None
    failed: str = ""


Found = Mapping[str, Sequence[Outcome]]  # by kind and extent


def reproduce(progress: Progress, execution: Execution = ALONE, dies: int = DIES) -> Report:
    """Measure neurons and run the approach on every die."""
    keys = [Numbered(_named(*way), FIRST + k) for way in product(KINDS, EXTENTS) for k in range(dies)]
    campaign = Campaign("variation", run_one, Numbered, Outcome, (version("noctule"), ENDS))
    found = execution.by_condition(campaign, keys, progress)
    return Report(rows(found), lambda figure: _draw(found, figure), tuple(_notes(found)))


def run_one(key: Numbered) -> Outcome:
    """Measure both neurons, and run the approach, on a die whose number is the seed too."""
    kind, _, extent = key.condition.partition(" biases, ")
    die = die_of(extent, key.number)
    return flown("gate" if kind == "gate" else "generator", die, key.number)


def die_of(extent: str, number: int) -> Die:
    """Return the die of a number in lot A, or where `extent` says so in a lot of its own."""
    lot = f"A{number}" if extent.endswith("lots") else "A"
    return Die(lot, number, variation="plain" if extent == "plain" else "full")


def flown(kind: BiasKind, die: Die, seed: int) -> Outcome:
    """Return what a die came to with biases of a kind."""
    first, last = (
        float(neurons_on(_model(kind), Silicon(AMI_1500, die=die, place=_place(k))).t_inh[0]) for k in ENDS
    )
    system = load_system("approach")
    asked: dict[str, Any] = {"level": "behavioural", "die": die, "seed": seed, "bias_kind": kind}
    told = outcome_of(lambda: system.summarise(system.run(system.on_silicon(**asked))))
    if isinstance(told, CircuitError):
        return Outcome((first, last), succeeded=False, failed=str(told))
    return Outcome((first, last), bool(told["succeeded"]), float(told["range_error_mean_m"]))


@lru_cache(maxsize=2)
def _model(kind: BiasKind) -> ReboundModel:
    return model_of(rebias(rebound_neuron.build(), kind=kind), AMI_1500)


def _place(number: int) -> tuple[tuple[str, tuple[int, ...]], ...]:
    return ("ranging_chip", ()), ("neuron", (number,))


def _named(kind: str, extent: str) -> str:
    return f"{kind} biases, {extent}"


def spread(found: Sequence[Outcome]) -> tuple[float, float]:
    """Return the spread (sigma) over dies of ln of a neuron's inhibition, and of both ends' ratio."""
    logs: F64 = np.log([each.inhibition for each in found])
    return float(logs[:, 0].std(ddof=1)), float((logs[:, 0] - logs[:, 1]).std(ddof=1))


def rows(found: Found) -> tuple[Statement, ...]:
    """Make the statements."""
    return tuple(row for kind, extent in product(KINDS, EXTENTS[1:]) for row in _moved(kind, extent, found))


def _moved(kind: str, extent: str, found: Found) -> tuple[Statement, ...]:
    """What moves from plain dies to those of an extent."""
    plain, other = (_numbers(found[_named(kind, each)]) for each in ("plain", extent))
    name = f"{kind}_{extent.replace(', ', '_')}"
    return tuple(
        Statement(f"{name}_{which}", plain[which], value, unjudged("told, beside plain dies"))
        for which, value in other.items()
    )


def _numbers(found: Sequence[Outcome]) -> dict[str, float | None]:
    """Numbers of a way's dies, by the names of rows."""
    one, ratio = spread(found)
    return {
        "inhibition_spread": one,
        "ends_spread": ratio,
        "approach_succeed": _share(found).value,
        "approach_median_error_m": _median(found),
    }


def _share(found: Sequence[Outcome]) -> Share:
    return share_where(each.succeeded for each in found)


def _median(found: Sequence[Outcome]) -> float | None:
    """Median error of range of the dies that were run, m; None for none."""
    errors = [each.error for each in found if each.error is not None]
    return float(np.median(errors)) if errors else None


def _notes(found: Found) -> list[str]:
    """List how many dies succeed in each way, and how many could not be calibrated."""
    return [
        f"{name}: succeed {_share(each)}, not run {sum(bool(one.failed) for one in each)}."
        for name, each in found.items()
    ]


def _draw(found: Found, figure: Figure) -> None:
    left, right = figure.subplots(1, 2)
    for (name, each), colour in zip(found.items(), COLOURS, strict=False):
        times = np.array([one.inhibition for one in each])
        left.loglog(1e3 * times[:, 0], times[:, 0] / times[:, 1], "o", ms=3, color=colour, label=name)
        errors = np.sort([one.error for one in each if one.error is not None])
        right.semilogx(errors, np.linspace(0.0, 1.0, errors.size), color=colour)
    left.set(xlabel="inhibition of the first neuron (ms)", ylabel="over that of the last")
    left.legend(fontsize=7)
    right.set(xlabel="mean error of range (m)", ylabel="share of dies")


EXPERIMENT = Experiment(
    "variation", "what gradients, wafers and lots make of a neuron and of the approach",
    reproduce, {"dies": DIES},
)  # fmt: skip
