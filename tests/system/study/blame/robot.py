"""A robot that steers straight where a sum of currents of its chip's 8 cells is right, made in a moment.

Of each cell, `near.m1` counts fully and `far.m2` by a tenth; a board's device counts for nothing. Noise of
each trial blurs the sum.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure

from circuits.silicon.process import AMI_1500
from circuits.silicon.silicon import Silicon
from system.option import option
from system.options.on_silicon import OnSilicon
from system.system import Account, System, metrics_with

CELLS = ((("cell", (8,)), ("near", ()), ("m1", ())), (("cell", (8,)), ("far", ()), ("m2", ())))
AREA = 36e-12  # m^2
LIMIT = 4e-3  # V, of the sum's magnitude


@dataclass(frozen=True, slots=True)
class Scenario(OnSilicon):
    """A drive."""

    blur: float = option(0.0, "Noise of the sum", unit="V", least=0.0)


@dataclass(frozen=True, slots=True)
class Trace:
    """The sum that steered it, V."""

    scenario: Scenario
    total: float


def run(scenario: Scenario, progress: object = None) -> Trace:
    silicon = Silicon(AMI_1500, die=scenario.die)
    own = np.reshape(silicon.deviations("toy_chip", CELLS, AREA).v_t0 * np.ones(16), (2, 8))
    silicon.deviations("toy_board", ((("m_in", ()),),), AREA)
    silicon.law("n")
    noise = scenario.blur * np.random.default_rng(scenario.seed).standard_normal()
    return Trace(scenario, float(own[0].sum() + 0.1 * own[1].sum() + noise))


def account(trace: Trace) -> Account:
    return Account(succeeded=abs(trace.total) < LIMIT, reason="time over", ran_on={})


def draw(trace: Trace, figure: Figure) -> None:
    figure.subplots().plot([0.0, 1.0], [0.0, trace.total])


SYSTEM = System(
    name="toy",
    summary="a toy that steers",
    success="the sum is small",
    kind=Scenario,
    run=run,
    account=account,
    numbers=lambda trace: {"total_V": trace.total},
    draw=draw,
    metrics=metrics_with(("total_V",)),
)
