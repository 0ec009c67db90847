"""Many runs of the Pushbot, a chip at a time, and shares with their intervals.

Dies and seeds from FIRST on report; those below tuned. Every run has noise of its own; a die comes again
every `dies` runs, so that a chip is made once for all of its runs.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from math import sqrt

import numpy as np

from circuits.die import Die
from circuits.errors import ParameterError
from system.arena import Scene
from system.pushbot import Scenario, Trace, make_brain, run_with, scene_of, summarise
from system.pushbot_loop import Brain
from system.study.interval import Interval, clopper_pearson

FIRST = 6000  # of dies and seeds that report; those below were seen while codes and levels were chosen
DIES = 10  # of a campaign; ours
Summary = dict[str, float | None]
Make = Callable[[Scenario], Brain]


@dataclass(frozen=True, slots=True)
class Share:
    """How many of so many, and the 95 % interval of their share."""

    passed: int
    of: int

    @property
    def value(self) -> float:
        """Share, 0 of none."""
        return self.passed / max(self.of, 1)

    @property
    def interval(self) -> Interval:
        """Clopper and Pearson's."""
        return clopper_pearson(self.passed, self.of)

    def __str__(self) -> str:
        """As `19 of 20 (75 to 100 %)`."""
        ends = self.interval
        return f"{self.passed} of {self.of} ({100.0 * ends.low:.0f} to {100.0 * ends.high:.0f} %)"


def trials(base: Scenario, count: int, dies: int = DIES, first: int = FIRST) -> list[Scenario]:
    """`count` runs of a scenario on `dies` dies, each with a seed of its own.

    Raises `ParameterError` for no run or no die.
    """
    if count < 1 or dies < 1:
        raise ParameterError(f"campaign: {count} runs on {dies} dies, must be at least 1 each")
    return [replace(base, seed=first + k, die=Die(number=first + k % dies)) for k in range(count)]


def drive_each(
    scenarios: Sequence[Scenario],
    keep: Callable[[Trace], Summary] = summarise,
    progress: Callable[[float], None] | None = None,
    make: Make = make_brain,
    world: Callable[[Scenario], Scene] = scene_of,
) -> list[Summary]:
    """What `keep` says of every run, in the order of the scenarios; a chip is made once."""
    keys = [
        (
            s.die.number or 0, s.temperature_c, s.bias_kind, repr(s.architecture()), s.calibrated,
            repr(s.device_noise()),
        )
        for s in scenarios
    ]  # fmt: skip
    order = sorted(range(len(scenarios)), key=keys.__getitem__)
    found: dict[int, Summary] = {}
    brain, last = None, None
    for done, k in enumerate(order):
        scenario = scenarios[k]
        if brain is None or keys[k] != last:
            brain, last = make(scenario), keys[k]
        found[k] = keep(run_with(brain, scenario, world(scenario), scenario.read()))
        if progress is not None:
            progress((done + 1) / len(order))
    return [found[k] for k in range(len(scenarios))]


def share_of(found: Sequence[Summary], name: str) -> Share:
    """Share of the runs whose number `name` is not 0."""
    return Share(sum(1 for s in found if s[name]), len(found))


def mean_sd(found: Sequence[Summary], name: str) -> tuple[float, float, int]:
    """Mean, standard deviation and how many of what is defined; NaN of none."""
    values = [v for s in found if (v := s[name]) is not None]
    if not values:
        return float("nan"), float("nan"), 0
    deviation = float(np.std(values, ddof=1)) if len(values) > 1 else 0.0
    return float(np.mean(values)), deviation, len(values)


def standard_error(deviation: float, count: int) -> float:
    """Of a mean."""
    return deviation / sqrt(max(count, 1))
