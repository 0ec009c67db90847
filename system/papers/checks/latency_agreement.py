"""The latency chip against the network of Wen & Horiuchi 2022: winner groups on the same recorded pings.

No figure of the paper. Compared with the network's winner groups are those of the chip, and those of the same
network of integrate-and-fire neurons alone. The network flies through forests with seeds from 1006 on, each
until a collision or `FLIGHT` pings, until `PINGS` are recorded. The chip's few free numbers (lead of the
delay line, T_C, recurrent inhibition) were chosen on 900 pings of seeds below 1000, those of the
integrate-and-fire network before any ping. The chip is the nominal die; both run open loop. The rule: the
lower 95 % limit of Cohen's kappa at least 0.8.
"""

from __future__ import annotations

import itertools
from contextlib import closing
from dataclasses import dataclass
from operator import attrgetter

import numpy as np
from matplotlib.figure import Figure

from circuits.arrays import F64
from system.experiment import Experiment, Progress, Report
from system.openspace.law import Arcs, Bat, arcs_of
from system.papers.wen2022.fig5 import NAMES
from system.plot import PALE, sized_axes
from system.rule import at_least
from system.spiking_bat.agreement import Recorder, confusion, kappa_interval, replayed, replayed_by
from system.spiking_bat.brain import network_brain
from system.spiking_bat.campaign import decided_by
from system.spiking_bat.chip_brain import chip_brain
from system.spiking_bat.flight import fly
from system.spiking_bat.lif import all_lif
from system.spiking_bat.numbers import Numbers
from system.spiking_bat.run import place
from system.spiking_bat.scenario import Scenario
from system.statement import Statement
from system.study.campaign import ALONE, Campaign, Execution, Numbered

FIRST_SEED = 1006
PINGS, FLIGHT = 2000, 250  # in all at least, and of a flight; ours
LEAST = 0.8  # of kappa's lower limit


@dataclass(frozen=True, slots=True)
class Winners:
    """Winner groups at the pings of a flight: the network's, the chip's, and integrate-and-fire neurons'."""

    network: tuple[int, ...]
    chip: tuple[int, ...]
    lif: tuple[int, ...]


def reproduce(
    progress: Progress, execution: Execution = ALONE, pings: int = PINGS, flight: int = FLIGHT
) -> Report:
    """Fly the network, then play its pings to the chip."""
    found: list[Winners] = []
    count = 0
    campaign = Campaign("latency-agreement", fly_one, Numbered, Winners, (*decided_by(), flight))
    keys = (Numbered(f"{flight} pings", seed) for seed in itertools.count(FIRST_SEED))
    with closing(execution.results(campaign, keys)) as runs:
        while count < pings:
            found.append(next(runs))
            count += len(found[-1].network)
            progress(min(1.0, count / pings))
    network, chip, lif = (
        np.array([group for each in found for group in of(each)], dtype=np.int64)
        for of in map(attrgetter, ("network", "chip", "lif"))
    )
    kappa, low, high = kappa_interval(network, chip)
    other, other_low, other_high = kappa_interval(network, lif)
    table = confusion(network, chip)
    rows = (
        Statement("pings", float(PINGS), float(network.size), at_least(text="at least")),
        Statement("kappa_lower_limit", LEAST, low, at_least(LEAST)),
        Statement(
            "lif_kappa_lower_limit", LEAST, other_low, at_least(LEAST, "at least {limit:g}: similar results")
        ),
    )
    notes = (
        f"kappa {kappa:.4f}, interval {low:.4f} to {high:.4f}, {len(found)} flights",
        f"integrate-and-fire neurons alone: kappa {other:.4f}, interval {other_low:.4f} to {other_high:.4f}",
        f"the chip's is the same group at {np.trace(table) / table.sum():.2%} of {network.size} pings",
    )
    return Report(rows, lambda figure: _draw(table, figure), notes)


def fly_one(key: Numbered) -> Winners:
    """Give the winner groups of network, chip and integrate-and-fire network over a flight of the first."""
    flight, seed = key
    numbers = Numbers()
    arcs = arcs_of(Bat(ping_rate=1.0 / numbers.ping_period))
    heard = recorded(arcs, numbers, seed, int(flight.split()[0])).rows
    return Winners(
        tuple(int(row.group) for row in heard),
        tuple(replayed(chip_brain(arcs, numbers), heard).tolist()),
        tuple(replayed_by(network_brain(arcs, numbers, all_lif), heard).tolist()),
    )


def recorded(arcs: Arcs, numbers: Numbers, seed: int, pings: int) -> Recorder:
    """Fly the network through a forest, and record what it heard and answered."""
    recorder = Recorder(network_brain(arcs, numbers))
    forest, start = place(Scenario(seed=seed), arcs)
    fly(recorder, arcs, forest, start, pings)
    return recorder


def _draw(table: F64, figure: Figure) -> None:
    """How often the network (rows) and the chip (columns) named each group."""
    ax = sized_axes(figure, 6.0, 5.4)
    names = [*NAMES, "none", "emergency"]
    ax.imshow(np.log1p(table), cmap="Blues")
    for i, j in np.ndindex(table.shape):
        dark = table[i, j] > np.sqrt(table.max())
        ax.text(j, i, f"{table[i, j]:.0f}", ha="center", va="center", fontsize=8, color="w" if dark else "k")
    ax.set_xticks(range(len(names)), names, rotation=40, ha="right", fontsize=8)
    ax.set_yticks(range(len(names)), names, fontsize=8)
    ax.set(xlabel="chip's winner group", ylabel="network's")
    ax.spines[:].set_color(PALE)


EXPERIMENT = Experiment(
    "latency-agreement", "the latency chip's winners against the network's", reproduce,
    {"pings": PINGS, "flight": FLIGHT},
)  # fmt: skip
