"""Pings to the spike-latency network, and what the spikes of its motors make a bat do.

A ping gives the network its onset, its direction, the goal, and an echo for every obstacle in the field of
view, at that obstacle's echo delay, into the neuron of the head map whose place is nearest. A spike of a head
motor turns the head for the next ping. Spikes of body motors turn the body: onto the arc whose turn rate, and
speed, are the mean of theirs. Where they did, and after an emergency, a reset erases the memories.

Ours: the goal neuron is the arc nearest to the goal by the analog model's rule; the body turns at the first
body motor's spike; the reset comes at `reset_at` after the ping, when all motors have spoken that will.

Source: Wen & Horiuchi 2022, section 3, "Motor Layer" and "Sensory Layer".
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from circuits.arrays import F64, I64
from circuits.compiled import compiled
from system.openspace.kernel import goal_arc
from system.openspace.law import Arcs
from system.openspace.view import in_view
from system.spiking_bat.maps import echo_delay, nearest_place, places
from system.spiking_bat.network.kernel import NOW, State
from system.spiking_bat.network.network import Network, Spikes, new_state, run
from system.spiking_bat.numbers import Numbers

_NONE = np.empty((0, 2), dtype=np.int64)


@dataclass(frozen=True, slots=True)
class Answer:
    """What the network did between a ping and the next one; times are in s after the ping.

    head: direction of the next ping, None to stay; arcs: whose body motors spiked; turned: when the first of
    them did; emergency: when its neuron spiked, or None.

    spikes : all spikes of the period.
    traces : membranes of the neurons that were probed, float64[steps, probes].
    """

    spikes: Spikes
    head: int | None
    arcs: I64
    turned: float | None
    emergency: float | None
    traces: F64 = field(repr=False)


def settled(network: Network, numbers: Numbers, periods: int = 1) -> State:
    """State after so many periods without a ping, in which the tonic neurons have come to their rhythm.

    The first layer, which nobody has inhibited, races once, and its recurrent inhibition holds it.
    """
    state = new_state(network)
    run(network, state, periods * numbers.ping_period, _NONE)
    return state


def seen_from(arcs: Arcs, offset: F64, heading: float, head: int) -> F64:
    """Obstacles in the field of view, float64[n, 2], m along the ping and to its left.

    offset: float64[m, 2], m from the bat, in the world; heading: rad; head: direction of the ping.
    """
    found = np.empty((len(offset), 2))
    which = np.empty(len(offset), dtype=np.int64)
    count = look(arcs, np.ascontiguousarray(offset), heading, head, found, which)
    return found[:count]


@compiled()
def look(arcs: Arcs, offset: F64, heading: float, head: int, found: F64, which: I64) -> int:
    """As `seen_from`, into `found` and, for their numbers, `which`; returns how many are seen."""
    angle = heading + arcs.direction[head]
    cos, sin = math.cos(angle), math.sin(angle)
    count = 0
    for k in range(offset.shape[0]):
        x, y = offset[k, 0], offset[k, 1]
        ahead, left = cos * x + sin * y, cos * y - sin * x
        if math.hypot(x, y) <= arcs.max_range and in_view(arcs, ahead, left):
            found[count, 0], found[count, 1], which[count] = ahead, left, k
            count += 1
    return count


def goal_neuron(arcs: Arcs, heading: float) -> int:
    """Return the goal neuron that spikes where the goal lies due west of a heading (rad)."""
    return int(goal_arc(arcs, heading) + 0.5)


def ping(
    network: Network,
    state: State,
    numbers: Numbers,
    head: int,
    goal: int,
    seen: F64,
    probes: Sequence[int] = (),
    *,
    spoken: bool | None = None,
) -> Answer:
    """Ping in direction `head` with obstacles `seen` (m along it and to its left), until the next ping.

    spoken: whether a reset follows; as the motors have it unless given.
    """
    start, step = int(state.counts[NOW]), network.wiring.step
    given = [(start, network.number("onset")), (start, network.number("ping", head))]
    given.append((start, network.number("goal", goal)))
    if len(seen):
        late = np.rint(echo_delay(np.hypot(*seen.T)) / step).astype(int)
        for neuron, after in zip(nearest_place(seen, places()), late, strict=True):
            given.append((start + int(after), network.number("echo", int(neuron))))
    inputs = np.array(given, dtype=np.int64)
    first, early = run(network, state, numbers.reset_at, inputs, probes)
    answer = _read(first, start * step)
    if spoken is None:
        spoken = answer.turned is not None or answer.emergency is not None
    reset = np.array([(state.counts[NOW], network.number("reset"))]) if spoken else _NONE
    rest, late_traces = run(network, state, numbers.ping_period - numbers.reset_at, reset, probes)
    spikes = Spikes(
        network, np.concatenate([first.step, rest.step]), np.concatenate([first.source, rest.source])
    )
    return replace(answer, spikes=spikes, traces=np.concatenate([early, late_traces]))


def _read(spikes: Spikes, start: float) -> Answer:
    """Motors' spikes since `start` (s)."""
    heads = spikes.of("head")[1]
    times, arcs = spikes.of("body")
    emergency = spikes.of("emergency")[0]
    return Answer(
        spikes,
        int(heads[0]) if heads.size else None,
        np.unique(arcs),
        float(times[0] - start) if times.size else None,
        float(emergency[0] - start) if emergency.size else None,
        np.empty((0, 0)),
    )
