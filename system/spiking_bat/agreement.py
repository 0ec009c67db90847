"""Whether the latency chip decides as the network does on the same pings: in open loop, by Cohen's kappa.

The network flies; every ping's inputs, the head's direction, and whether a reset followed are kept. The chip
then gets the same inputs in the same order, resets where the network's motors asked for them, and its own
winners change nothing of what comes. The winner group is that of the second layer's first spike; none, and
the emergency neuron, count as groups of their own.

    kappa = (p_o - p_e) / (1 - p_e)

p_o being the share of pings with the same group, p_e what it would be by chance. Neighbouring pings are
alike, so that its interval is a bootstrap (percentiles) over runs of `BLOCK` successive pings.

Source: Cohen (1960), "A coefficient of agreement for nominal scales".
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from circuits.arrays import F64, I64
from circuits.catalogue import later
from system.openspace.law import DIRECTIONS
from system.spiking_bat.bat import ping
from system.spiking_bat.brain import Brain, NetworkBrain, Reply
from system.spiking_bat.chip_brain import ChipBrain

stats = later("scipy.stats")

NOBODY, EMERGENCY = DIRECTIONS, DIRECTIONS + 1  # beside the groups
GROUPS = DIRECTIONS + 2
BLOCK = 25  # pings; ours
LEVEL = 0.95
RESAMPLES = 2000
_LEAST = 3  # runs of pings, of which a bootstrap can be made


@dataclass(frozen=True, slots=True)
class Heard:
    """A ping's inputs, and the network's answer: its winner group, and whether a reset followed.

    head : direction of the ping.
    goal : goal neuron that spiked.
    seen : obstacles in view, float64[n, 2], m along the ping and to its left.
    spoken : whether a reset followed.
    """

    head: int
    goal: int
    seen: F64 = field(repr=False)
    group: int
    spoken: bool


@dataclass(slots=True)
class Recorder:
    """A brain that keeps what another brain heard and answered.

    rows : what was heard and answered so far.
    """

    brain: Brain
    rows: list[Heard] = field(default_factory=list)

    @property
    def period(self) -> float:
        """Time between pings, s."""
        return self.brain.period

    def ping(self, head: int, goal: int, seen: F64) -> Reply:
        """Ask the other brain and keep its answer."""
        reply = self.brain.ping(head, goal, seen)
        spoken = reply.turned is not None or reply.emergency is not None
        self.rows.append(Heard(head, goal, seen.copy(), group_of(reply), spoken))
        return reply


def group_of(reply: Reply) -> int:
    """Return the winner group of a reply."""
    if reply.emergency is not None:
        return EMERGENCY
    return NOBODY if reply.head is None else reply.head


def replayed(brain: ChipBrain, rows: Sequence[Heard]) -> I64:
    """Return the chip's winner groups on recorded pings, int64[pings]."""
    found = []
    for row in rows:
        found.append(group_of(brain.answer(row.head, row.goal, row.seen)))
        brain.end(spoken=row.spoken)
    return np.array(found, dtype=np.int64)


def replayed_by(brain: NetworkBrain, rows: Sequence[Heard]) -> I64:
    """Return another network's winner groups on recorded pings, int64[pings]."""
    b = brain
    return np.array(
        [
            group_of(ping(b.network, b.state, b.numbers, r.head, r.goal, r.seen, spoken=r.spoken))
            for r in rows
        ],
        dtype=np.int64,
    )


def confusion(a: I64, b: I64) -> F64:
    """Return how often each pair of groups occurred, float64[GROUPS, GROUPS]."""
    table = np.zeros((GROUPS, GROUPS))
    np.add.at(table, (a, b), 1.0)
    return table


def cohens_kappa(table: F64) -> float:
    """Return kappa of a table of counts; 1 where both always name one and the same group."""
    share = table / table.sum()
    chance = float(share.sum(axis=0) @ share.sum(axis=1))
    return 1.0 if chance == 1.0 else (float(np.trace(share)) - chance) / (1.0 - chance)


def kappa_interval(a: I64, b: I64, seed: int = 0) -> tuple[float, float, float]:
    """Return kappa of two sequences of groups, and both limits of its interval."""
    blocks = [confusion(a[k : k + BLOCK], b[k : k + BLOCK]) for k in range(0, a.size, BLOCK)]
    tables, whole = np.array(blocks), cohens_kappa(confusion(a, b))
    if len(blocks) < _LEAST:
        return whole, -1.0, 1.0

    def statistic(chosen: I64) -> float:
        return cohens_kappa(tables[chosen].sum(axis=0))

    found = stats.bootstrap(
        (np.arange(len(blocks)),), statistic, vectorized=False, n_resamples=RESAMPLES,
        confidence_level=LEVEL, method="percentile", rng=np.random.default_rng(seed),
    ).confidence_interval  # fmt: skip
    return whole, float(found.low), float(found.high)
