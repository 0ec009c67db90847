"""Networks put on ROLLS by `noctule map`: rates on the nominal die and on others, beside what is expected.

No figure of a paper. Networks are drawn, one to three populations with membranes of 5 to 40 ms, refractory
periods of 0.5 to 4 ms, synapses of 3 to 30 ms, weights of both signs and Poisson events at 50 to 300 Hz. The
bar is of the mapping: each population's mean rate on the nominal die within 10 % or 2 Hz of the network as it
is after quantisation (`system.mapping.rolls.mapped`). The same on drawn dies, with the weights calibrated and
without, and against the network that was asked for, is reported without a rule. Networks and dies have
numbers from 1000 on; the mapping was made on networks 0 to 2.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import version

import numpy as np
from matplotlib.figure import Figure

from chips.aer import Events
from circuits.arrays import F64
from circuits.silicon.die import Die
from circuits.silicon.process import ROLLS_180
from circuits.silicon.silicon import Silicon
from system.experiment import Experiment, Progress, Report
from system.mapping.chips import map_on
from system.mapping.network import Connection, Input, Network, Population
from system.mapping.rolls.calibrate import calibrated
from system.mapping.run import run_mapped
from system.plot import COLOURS, PALE
from system.rule import at_least, unjudged
from system.statement import Statement
from system.study.campaign import ALONE, Campaign, Execution, Numbered

FIRST, NETWORKS = 1000, 12
DURATION = 0.6  # s, of a run
NEAR, FEW = 0.10, 2.0  # of a rate; Hz
CONDITIONS = {"nominal": "on the nominal die", "raw": "on a die", "calibrated": "on a calibrated die"}


@dataclass(frozen=True, slots=True)
class Rates:
    """Mean rates of the populations of a network, Hz, float64[n] each: asked for, expected, on the die."""

    asked: F64
    expected: F64
    die: F64


def drawn(number: int) -> tuple[Network, Events]:
    """Return the network of a number, and events of its input."""
    rng = np.random.default_rng(number)
    populations = tuple(
        Population(
            f"p{k}",
            int(rng.integers(10, 60)),
            float(rng.uniform(5e-3, 40e-3)),
            float(rng.uniform(0.5e-3, 4e-3)),
        )
        for k in range(int(rng.integers(1, 4)))
    )
    channels, tau = int(rng.integers(5, 30)), float(rng.uniform(3e-3, 20e-3))
    connections = [
        Connection("in", p.name, float(rng.uniform(0.05, 0.4)), "random", tau, probability=0.4, seed=number)
        for p in populations
    ]
    for a in populations:
        for b in populations:
            if rng.random() < 0.6:
                weights = rng.normal(rng.normal(0.0, 0.02), 0.05, (b.size, a.size)) * 20.0 / a.size
                there = rng.random((b.size, a.size)) < 0.4
                matrix = tuple(map(tuple, (weights * there).tolist()))
                between = float(rng.uniform(3e-3, 30e-3))
                connections.append(Connection(a.name, b.name, rule="matrix", tau=between, matrix=matrix))
    rate = float(rng.uniform(50.0, 300.0))
    trains = [np.sort(rng.uniform(0.0, DURATION, rng.poisson(rate * DURATION))) for _ in range(channels)]
    times = np.concatenate(trains)
    order = np.argsort(times, kind="stable")
    events = Events(times[order], np.repeat(np.arange(channels), [t.size for t in trains])[order])
    return Network(populations, (Input("in", channels),), tuple(connections)), events


def measured(key: Numbered) -> Rates:
    """Map the network of a key's number, and run it under the key's condition."""
    network, events = drawn(key.number)
    mapped, silicon = map_on("rolls", network), Silicon(ROLLS_180)
    if key.condition != "nominal":
        silicon = Silicon(ROLLS_180, 27.0, Die(number=key.number))
    if key.condition == "calibrated":
        mapped = calibrated(mapped, silicon)
    rates = run_mapped(mapped, events, silicon, DURATION).rates
    return Rates(*(np.array(list(rates[name].values())) for name in ("asked", "expected", "chip")))


def reproduce(progress: Progress, execution: Execution = ALONE, networks: int = NETWORKS) -> Report:
    """Map and run every network under all conditions."""
    keys = [Numbered(name, FIRST + k) for name in CONDITIONS for k in range(networks)]
    campaign = Campaign(EXPERIMENT.name, measured, Numbered, Rates, (version("noctule"), DURATION))
    found = {name: joined(each) for name, each in execution.by_condition(campaign, keys, progress).items()}
    return Report(rows(found), lambda figure: _draw(found, figure))


def rows(found: Mapping[str, Rates]) -> tuple[Statement, ...]:
    """Make the statements about populations within 10 % or 2 Hz, under each condition."""
    made = []
    for name, rates in found.items():
        for what, wanted in (("expected", rates.expected), ("asked for", rates.asked)):
            rule = at_least(1.0) if (name, what) == ("nominal", "expected") else unjudged("reported")
            share = within(rates.die, wanted)
            made.append(Statement(f"share of populations as {what} {CONDITIONS[name]}", None, share, rule))
    return tuple(made)


def joined(networks: Sequence[Rates]) -> Rates:
    """Rates of all networks together."""
    return Rates(
        *(np.concatenate([getattr(r, name) for r in networks]) for name in ("asked", "expected", "die"))
    )


def within(rates: F64, wanted: F64) -> float:
    """Share of rates within 10 % or 2 Hz."""
    return float(np.mean(np.abs(rates - wanted) <= np.maximum(NEAR * wanted, FEW)))


def _draw(found: Mapping[str, Rates], figure: Figure) -> None:
    ax = figure.subplots()
    most = max(float(max(r.expected.max(), r.die.max())) for r in found.values())
    ax.plot([0.0, most], [0.0, most], color=PALE)
    for k, (name, rates) in enumerate(found.items()):
        ax.plot(rates.expected, rates.die, color=COLOURS[k], marker="o", linestyle="", label=CONDITIONS[name])
    ax.set(xlabel="rate after quantisation (Hz)", ylabel="rate of a population (Hz)")
    ax.legend()


EXPERIMENT = Experiment(
    "rolls-mapping",
    "ROLLS: rates of drawn networks that are mapped on its dies",
    reproduce,
    {"networks": NETWORKS},
)
