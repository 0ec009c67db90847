"""What experiments share that hold a chip's model under the full law against its transistors on unseen dies.

Each is on dies with mismatch and process variation of which no model was made, at three temperatures, with
several kinds of bias. The margins are those that every model of a chip is held to; they are ours.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

import numpy as np
from matplotlib.figure import Figure

from circuits.arrays import F64
from circuits.circuit import BiasKind
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500
from circuits.silicon.silicon import Silicon
from system.experiment import Progress, with_progress
from system.plot import COLOURS
from system.rule import Rule, at_least, at_most
from system.statement import Statement
from system.study.campaign import thread_count

TEMPERATURES = (-10.0, 27.0, 60.0)  # degC
KINDS: tuple[BiasKind, ...] = ("gate", "generator")
TIME_SHARE = 0.03  # by which a time may be off; ours
NEAR = at_most(TIME_SHARE)
ALIKE, TIED = at_least(0.99), at_most(0.02)  # share of answers that are alike, and that are undecided; ours

T = TypeVar("T")


def on_dies(
    compare: Callable[[BiasKind, Silicon], T],
    dies: Iterable[int],
    progress: Progress = lambda _: None,
    kinds: Iterable[BiasKind] = KINDS,
) -> list[T]:
    """Return what `compare` finds with every kind of bias, at every temperature, on every die.

    Parameters
    ----------
    compare
        Holds both levels beside each other, with biases of a kind on a silicon.
    dies
        Numbers of the dies.
    progress
        Is told the share that is done.
    kinds
        Kinds of bias.
    """
    every = [
        (kind, Silicon(AMI_1500, celsius, Die(number=number)))
        for kind in kinds
        for celsius in TEMPERATURES
        for number in dies
    ]
    executor = ThreadPoolExecutor(thread_count(None))  # solving releases Python's lock
    try:
        asked = [executor.submit(compare, *each) for each in every]
        return [one.result() for one in with_progress(asked, progress)]
    finally:
        executor.shutdown(cancel_futures=True)


def judged(rows: Iterable[tuple[str, float, Rule]]) -> tuple[Statement, ...]:
    """Return a statement of each number by its name and the margin that it is held to."""
    return tuple(Statement(name, None, value, rule) for name, value, rule in rows)


def largest_error(circuit: F64, model: F64) -> float:
    """Return the largest relative error of the model's numbers, 0 of none, NaN where one is that."""
    return float(np.abs(model / circuit - 1.0).max(initial=0.0))


def draw_errors(times: Mapping[str, tuple[F64, F64]], what: str, figure: Figure) -> None:
    """Draw the error of each time over the circuit's, beside the margin.

    Parameters
    ----------
    times
        Times (s) of the circuit and of the model, float64[n] each, by what the legend calls them.
    what
        What the times are, in a word.
    figure
        An empty figure.
    """
    ax = figure.add_subplot()
    for (name, (circuit, model)), colour in zip(times.items(), COLOURS, strict=False):
        ax.loglog(1e3 * circuit, 1e2 * np.abs(model / circuit - 1.0), "o", color=colour, label=name)
    ax.axhline(1e2 * TIME_SHARE, color="grey", lw=0.8)
    ax.set_xlabel(f"{what} of the circuit, ms")
    ax.set_ylabel("error of the model, %")
    ax.legend()
