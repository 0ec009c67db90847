"""The scene of Figure 12 of Wen & Horiuchi 2022: two pings among six obstacles, a reset, and recalls.

A bat flies left at full speed and pings ahead; the network then says where the second ping goes. The third
shows nothing: after a reset nothing must be remembered. Recalls are pings that show nothing, after the first
one, without a reset. Coordinates are ours, near those of our Figure 5, for whose rows they do as well.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from circuits.arrays import F64, I64
from system.openspace.law import ARCS, DIRECTIONS, MIDDLE, Arcs, Bat, arcs_of
from system.spiking_bat.bat import Answer, goal_neuron, ping, seen_from, settled
from system.spiking_bat.network.kernel import NOW, State
from system.spiking_bat.network.network import Network, Spikes, run
from system.spiking_bat.numbers import Numbers
from system.spiking_bat.topology import published

PING_RATE = 10.0  # Hz
# m ahead of the bat and to its left; ours
OBSTACLES = ((2.15, -0.19), (2.79, 0.42), (1.90, -1.33), (2.26, 1.66), (1.57, 1.76), (0.65, -1.87))
HEADING = -math.pi  # the bat flies left, to the goal
_RECALLS = 4
_LISTEN = 0.5  # s, far longer than any inhibition


@dataclass(frozen=True, slots=True)
class Story:
    """What happened: both pings and the one after the reset, recalls without one, and the watched unit.

    memory: latency of the first output spike of each arc (s, nan without) at each ping, float64[3, ARCS];
    fresh: arcs whose integrating neuron spiked at the second ping; recalled: float64[_RECALLS, ARCS], steps;
    silence: s, of the watched INH neuron after its CD's spike, without another ping.
    """

    network: Network
    arcs: Arcs
    numbers: Numbers
    detected: tuple[int, int]
    answers: tuple[Answer, Answer, Answer]
    memory: F64
    fresh: I64
    recalled: F64
    silence: float
    watched: tuple[int, int]
    times: tuple[float, float, float]  # of the pings, s


def tell(
    progress: Callable[[float], None] = lambda _: None,
    numbers: Numbers | None = None,
    build: Callable[[Arcs, Numbers], Network] = published,
) -> Story:
    """Run the scene of Figure 12 with the network that `build` makes."""
    numbers = numbers or Numbers()
    arcs = arcs_of(Bat(ping_rate=PING_RATE))
    network = build(arcs, numbers)
    place = np.array([(-ahead, -left) for ahead, left in OBSTACLES])
    state = settled(network, numbers)
    progress(0.2)
    goal, middle = goal_neuron(arcs, HEADING), DIRECTIONS // 2
    view = seen_from(arcs, place, HEADING, middle)
    watched = _outermost_unit(network, ping(network, copied(state), numbers, middle, goal, view))
    probes = [network.number(name, *watched) for name in ("a", "b", "cd", "inh")]
    probes.append(network.number("integrating", watched[0]))
    start = int(state.counts[NOW]) * network.wiring.step
    one = ping(network, state, numbers, middle, goal, view, probes)
    remembering = copied(state)
    head = middle if one.head is None else one.head
    flown = np.array([-float(arcs.speed[MIDDLE]) * numbers.ping_period, 0.0])
    second_view = seen_from(arcs, place - flown, HEADING, head)
    two = ping(network, state, numbers, head, goal, second_view, probes)
    three = ping(network, state, numbers, head, goal, np.empty((0, 2)), probes)
    progress(0.6)
    times = (start, start + numbers.ping_period, start + 2.0 * numbers.ping_period)
    latencies = [_first_latencies(a.spikes, t) for a, t in zip((one, two, three), times, strict=True)]
    return Story(
        network=network,
        arcs=arcs,
        numbers=numbers,
        detected=(len(view), len(second_view)),
        answers=(one, two, three),
        memory=np.array(latencies),
        fresh=np.unique(two.spikes.of("integrating")[1]),
        recalled=_recalls(network, copied(remembering), numbers),
        silence=_silence(network, remembering, one, watched),
        watched=watched,
        times=times,
    )


def copied(state: State) -> State:
    """The same state, on its own arrays."""
    return State._make(each.copy() for each in state)


def _first_latencies(spikes: Spikes, start: float) -> F64:
    """Latency of each arc's first output spike after a ping at `start` (s), nan without, float64[ARCS]."""
    times, arcs = spikes.of("out")
    found = np.full(ARCS, math.nan)
    for t, p in zip(times[::-1], arcs[::-1], strict=True):
        found[p] = t - start
    return found


def _recalls(network: Network, state: State, numbers: Numbers) -> F64:
    """Latencies at pings that show nothing, without a reset, float64[_RECALLS, ARCS]."""
    found = []
    for _ in range(_RECALLS):
        start = int(state.counts[NOW])
        spikes, _ = run(
            network, state, numbers.ping_period, np.array([(start, network.number("onset"))], dtype=np.int64)
        )
        # in whole steps, so that equal latencies are equal to the bit
        found.append(np.rint(_first_latencies(spikes, start * network.wiring.step) / network.wiring.step))
    return np.array(found)


def _outermost_unit(network: Network, answer: Answer) -> tuple[int, int]:
    """Rightmost memory that stored something, and the first of its units that did."""
    units = network.size("tap")
    cd = answer.spikes.of("cd")[1]
    arc = int((cd // units).max()) if cd.size else 0
    stored = cd[cd // units == arc] % units
    return arc, int(stored[0]) if stored.size else 0


def _silence(network: Network, state: State, answer: Answer, unit: tuple[int, int]) -> float:
    """From a CD's spike at a ping to the next one of its INH neuron, without another ping, s, or inf."""
    flat = int(np.ravel_multi_index(unit, (ARCS, network.size("tap"))))
    cd, numbers = answer.spikes.of("cd")
    spikes, _ = run(network, state, _LISTEN, np.empty((0, 2), dtype=np.int64))
    inh, which = spikes.of("inh")
    stored, later = cd[numbers == flat], inh[which == flat]
    return float(later[0] - stored[0]) if stored.size and later.size else math.inf
