"""What experiments share that hold a chip's model under the full law against its transistors on unseen dies.

Each is on dies with mismatch and process variation of which no model was made, at three temperatures, with
fixed gates and with the bias generator: `DIES` of them make `ENOUGH` cases, which take minutes and are kept.
The margins are those that every model of a chip is held to; they are ours.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from typing import NamedTuple, TypeVar

import numpy as np
from matplotlib.figure import Figure

from chips.record import current_record, record_digest
from circuits.arrays import F64
from circuits.circuit import BiasKind
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500
from circuits.silicon.silicon import Silicon
from circuits.solver.version import VERSION
from system.experiment import Experiment, Progress, Report, with_progress
from system.plot import COLOURS
from system.rule import Rule, at_least, at_most
from system.statement import Statement
from system.study.campaign import ALONE, Campaign, Execution, thread_count

TEMPERATURES = (-10.0, 27.0, 60.0)  # degC
KINDS: tuple[BiasKind, ...] = ("gate", "generator")
ENOUGH = 500  # cases that a model is held to, at least
FIRST, DIES = 1000, 84  # of the dies, each of which makes a case at every temperature with every kind of bias
TIME_SHARE = 0.03  # by which a time may be off; ours
NEAR = at_most(TIME_SHARE)
ALIKE, TIED = at_least(0.99), at_most(0.02)  # share of answers that are alike, and that are undecided; ours

Times = Mapping[str, tuple[F64, F64]]  # of the circuit and of the model, s, by what a legend calls them
T = TypeVar("T")


class Condition(NamedTuple):
    """What a case is of: the kind of bias, the temperature, degC, and the number of the die."""

    kind: BiasKind
    temperature_c: float
    die: int

    @property
    def silicon(self) -> Silicon:
        """The die at the temperature."""
        return Silicon(AMI_1500, self.temperature_c, Die(number=self.die))


def conditions(dies: Iterable[int]) -> list[Condition]:
    """Return every die at every temperature with every kind of bias, one die after the other."""
    return [Condition(kind, celsius, number) for number in dies for kind in KINDS for celsius in TEMPERATURES]


def compared(
    name: str,
    summary: str,
    one: Callable[[Condition], T],
    result: type[T],
    records: Sequence[str],
    statements: Callable[[list[T]], tuple[Statement, ...]],
    times: Callable[[list[T]], Times],
    first: int = FIRST,
) -> Experiment:
    """Make the experiment that holds both levels beside each other at all conditions of dies from a first on.

    Parameters
    ----------
    name, summary
        Of the experiment.
    one, result
        Holds both levels beside each other at a condition, and the type of what it finds.
    records
        Names of the records of the models: what is kept is refused when one of them is another.
    statements
        Tell what was found, in the order of the conditions, after how many they are.
    times
        Gives the times that are drawn (`draw_errors`).
    first
        Number of the first die.
    """

    def run(progress: Progress, execution: Execution = ALONE, dies: int = DIES) -> Report:
        """Compare both levels on `dies` dies."""
        digests = tuple(record_digest(current_record(each, AMI_1500)) for each in records)
        campaign = Campaign(name, one, Condition, result, (VERSION, *digests))
        keys = conditions(range(first, first + dies))
        with closing(execution.results(campaign, keys)) as results:
            found = [next(results) for _ in with_progress(keys, progress)]
        rows = judged([("cases", float(len(found)), at_least(ENOUGH))]) + statements(found)
        return Report(rows, lambda figure: draw_errors(times(found), figure))

    return Experiment(name, summary, run, {"dies": DIES})


def on_dies(
    compare: Callable[[Condition], T], dies: Iterable[int], progress: Progress = lambda _: None
) -> list[T]:
    """Return what `compare` finds at every condition of dies, by their numbers, on every core."""
    executor = ThreadPoolExecutor(thread_count(None))  # solving releases Python's lock
    try:
        asked = [executor.submit(compare, each) for each in conditions(dies)]
        return [one.result() for one in with_progress(asked, progress)]
    finally:
        executor.shutdown(cancel_futures=True)


def judged(rows: Iterable[tuple[str, float, Rule]]) -> tuple[Statement, ...]:
    """Return a statement of each number by its name and the margin that it is held to."""
    return tuple(Statement(name, None, value, rule) for name, value, rule in rows)


def largest_error(circuit: F64, model: F64) -> float:
    """Return the largest relative error of the model's numbers, 0 of none, NaN where one is that."""
    return float(np.abs(model / circuit - 1.0).max(initial=0.0))


def draw_errors(times: Times, figure: Figure, what: str = "time") -> None:
    """Draw the error of each time over the circuit's, beside the margin.

    Parameters
    ----------
    times
        Times (s) of the circuit and of the model, float64[n] each, by what the legend calls them.
    figure
        An empty figure.
    what
        What the times are, in a word.
    """
    ax = figure.add_subplot()
    for (name, (circuit, model)), colour in zip(times.items(), COLOURS, strict=False):
        ax.loglog(1e3 * circuit, 1e2 * np.abs(model / circuit - 1.0), "o", color=colour, label=name)
    ax.axhline(1e2 * TIME_SHARE, color="grey", lw=0.8)
    ax.set_xlabel(f"{what} of the circuit, ms")
    ax.set_ylabel("error of the model, %")
    ax.legend()
