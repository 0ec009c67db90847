"""Compiled run of a network on the NEF chip: converters, filters, neurons and the router.

A time step of `DT`:

* a lane's accumulator takes what spikes and nodes have put on it; the converter gives the nearest of its
  levels, and the rest stays, so that nothing is lost by rounding; beyond full scale the rest stays too, up
  to another full scale, and what is above that is lost and counted;
* filters, `Y = gain s^power`, added up in slots, and lines, which split a slot's Y in what is above and below
  their reference; lanes that are read are low-passed by numbers;
* neurons go up by (J - leak) / charge a second from the end of their refractory period on, and down to the
  floor; a spike is placed where they reach 1. Inputs stand for a step, within which this is exact;
* the router passes up to `budget` spikes, those that waited first; others wait in a ring, and those for which
  it has no room are dropped and counted.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from chips.nef.network import kernel as nef_kernel
from chips.nef.network.kernel import DT, Net, State
from chips.nef.noise_kernel import NefNoise, begin_noise, disturb_filters, disturb_neurons
from chips.nef.whole.kernel import (
    Bends,
    add_bent,
    bent,
    position,
    read,
    risen,
    risen_little,
    since,
    until,
)
from circuits.arrays import F64, I64, Bools
from circuits.compiled import compiled

SPIKES, DROPPED, WAITING, CLIPPED, LOST = range(5)  # of the counters: events, and most that ever waited
COUNTERS = ("spikes", "dropped", "most_waiting", "clipped", "lost")
_SLOWEST = 1e-3  # 1/s, at a threshold that a membrane has crossed; ours
_compiled = compiled()


class ChipNet(NamedTuple):
    """A network on a chip, in a form for the kernel.

    net: biases, decoders and, for what is above a line's reference, rows as the chip has them (tau_rc and
    tau_ref are not used); below: as net.encoder, for what is below; sunk: what mirrors draw whatever the
    signals are, thresholds, float64[neurons]; lines: as of `chips.nef.model.Lines`, float64[3, slots];
    first: whether a lane is the first filter of a slot, which brings the middle, bool[lanes]; leak, speed
    (1 / charge), refractory (s), floor: float64[neurons]; step: value of a converter's step, 0 where a lane
    is read, float64[lanes]; levels: highest level; scale, gain: of a filter's input and output,
    float64[lanes]; power: of a filter's output; home: population of each neuron,
    int64[neurons]; budget: events a step.
    """

    net: Net
    below: F64
    sunk: F64
    lines: F64
    first: Bools
    leak: F64
    speed: F64
    refractory: F64
    floor: F64
    step: F64
    levels: float
    scale: F64
    gain: F64
    power: float
    home: I64
    budget: int


class ChipState(NamedTuple):
    """State of a network on a chip, overwritten in place.

    base: as of ideal neurons; s: filters, rest: accumulators, float64[lanes]; queue: neurons whose spikes
    wait, int64[ring]; ends: where the ring begins and how many wait, int64[2]; counters: by `COUNTERS`,
    int64[5].
    """

    base: State
    s: F64
    rest: F64
    queue: I64
    ends: I64
    counters: I64


def new_chip_state(chip: ChipNet, ring: int) -> ChipState:
    """Return a chip at rest, its filters at their middle; ring: how many spikes may wait."""
    lanes = len(chip.scale)
    return ChipState(
        nef_kernel.new_state(chip.net), chip.scale.copy(), np.zeros(lanes), np.zeros(ring, dtype=np.int64),
        np.zeros(2, dtype=np.int64), np.zeros(len(COUNTERS), dtype=np.int64),
    )  # fmt: skip


@_compiled
def advance_chip(c: ChipNet, s: ChipState, steps: int, noise: NefNoise | None, bends: Bends | None) -> None:
    """Take time steps of `DT`; of a noise or bends that are None numba compiles nothing."""
    for _ in range(steps):
        if noise is not None:
            begin_noise(noise)
            disturb_filters(noise, s.s)
        convert(c, s, bends)
        left = deliver(c, s)
        for p in range(c.net.begin.size - 1):
            draw(c, s, p, bends)
            if noise is not None:
                disturb_neurons(noise, c.net, s.base, c.lines, c.leak, c.speed, c.refractory, p)
            left = fire(c, s, p, left, bends)


@_compiled
def add_shown(
    c: ChipNet, s: ChipState, steps: int, noise: NefNoise | None, bends: Bends | None, lanes: I64, total: F64
) -> None:  # fmt: skip
    """Take time steps of `DT`, and add to `total` what `lanes` show at the end of each, float64[lanes]."""
    for _ in range(steps):
        advance_chip(c, s, 1, noise, bends)
        for k in range(lanes.size):
            total[k] += s.base.y[lanes[k]]


@_compiled
def convert(c: ChipNet, s: ChipState, bends: Bends | None) -> None:
    """Step converters, filters and lines, and add them up in slots."""
    b = s.base
    for k in range(b.x.size):
        b.x[k] = 0.0
    for k in range(b.y.size):
        given = b.raw[k] + b.held[k]
        b.raw[k] = 0.0
        step = c.step[k]
        if step == 0.0:
            b.y[k] = given + c.net.keep[k] * (b.y[k] - given)
            continue
        total = s.rest[k] + given
        level = math.floor(total / step + 0.5)
        if abs(level) > c.levels:
            level = math.copysign(c.levels, level)
            s.counters[CLIPPED] += 1
        rest = total - level * step
        most = (c.levels + 0.5) * step
        if abs(rest) > most:
            rest = math.copysign(most, rest)
            s.counters[LOST] += 1
        s.rest[k] = rest
        z = c.scale[k] * (1.0 + level / (c.levels + 1.0))
        if bends is None:
            s.s[k] = z + c.net.keep[k] * (s.s[k] - z)
            b.y[k] = c.gain[k] * math.exp(c.power * math.log(max(s.s[k], 1e-9)))
        else:
            s.s[k] = z + read(bends.keep[k], position(s.s[k])) * (s.s[k] - z)
            b.y[k] = math.exp(read(bends.output[k], position(s.s[k])))
        b.x[c.net.goes[k]] += b.y[k] if c.first[k] else b.y[k] - 1.0


@_compiled
def draw(c: ChipNet, s: ChipState, p: int, bends: Bends | None) -> None:
    """Fill the currents of a population's neurons: their biases, and of each slot what its line gives."""
    n, b = c.net, s.base
    begin, count = n.begin[p], n.begin[p + 1] - n.begin[p]
    current, bias = b.current[begin : begin + count], n.bias[begin : begin + count]
    for i in range(count):
        current[i] = bias[i]
    if bends is not None:
        sunk = bends.draws[begin : begin + count]
        for i in range(count):
            sunk[i] = c.sunk[begin + i]
    for k in range(n.slot[p], n.slot[p + 1]):
        y = b.x[k] - c.lines[0, k]
        if bends is not None:
            y = bent(bends.shape, y)
        row = (n.encoder if y > 0.0 else c.below)[n.row[k] : n.row[k] + count]
        x = c.lines[1, k] * y if y > 0.0 else -c.lines[2, k] * y
        if bends is None:
            add_scaled(current, row, x)
        else:
            add_bent(current, bends.draws[begin : begin + count], row, x)


@_compiled
def fall(rise: F64, mirrored: float, speed: F64, draws: F64) -> int:
    """Make of what mirrors draw how all that draws rises, 1/s; return of how many g t may be above 1."""
    steep = 0
    for i in range(draws.size):
        draws[i] = (rise[i] + mirrored * draws[i]) * speed[i]
        steep += draws[i] * DT > 1.0
    return steep


@_compiled
def climb(v: F64, r: F64, given: tuple[F64, F64, F64, F64], g: F64, steep: int) -> None:
    """Step membranes and what is left of refractory periods.

    given: currents, leaks, speeds and floors; steep: of how many `risen_little` may not be asked.
    """
    current, leak, speed, floor = given
    for i in range(v.size):
        free = min(max(DT - r[i], 0.0), DT)
        slope = (current[i] - leak[i]) * speed[i] - g[i] * (v[i] - 0.5)
        more = risen(slope, g[i], free) if steep else risen_little(slope, g[i], free)
        v[i] = max(v[i] + more, floor[i])
        r[i] -= DT


@_compiled
def add_scaled(current: F64, row: F64, x: float) -> None:
    """Add a row times a number to currents."""
    for i in range(current.size):
        current[i] += x * row[i]


@_compiled
def deliver(c: ChipNet, s: ChipState) -> int:
    """Pass the spikes that wait, and return what is left of the step's budget."""
    left = c.budget
    while left > 0 and s.ends[1] > 0:
        route(c, s, s.queue[s.ends[0]])
        s.ends[0] = (s.ends[0] + 1) % s.queue.size
        s.ends[1] -= 1
        left -= 1
    return left


@_compiled
def fire(c: ChipNet, s: ChipState, p: int, left: int, bends: Bends | None) -> int:
    """Step a population's neurons and send its spikes; return what is left of the budget."""
    b, first, last = s.base, c.net.begin[p], c.net.begin[p + 1]
    count = last - first
    v, r, j = b.u[first:last], b.rest[first:last], b.current[first:last]
    leak, speed, floor = c.leak[first:last], c.speed[first:last], c.floor[first:last]
    if bends is None:
        for i in range(count):
            free = min(max(DT - r[i], 0.0), DT)
            v[i] = max(v[i] + (j[i] - leak[i]) * speed[i] * free, floor[i])
            r[i] -= DT
    else:
        draws = bends.draws[first:last]
        steep = fall(bends.rise[first:last], bends.mirrored, speed, draws)
        climb(v, r, (j, leak, speed, floor), draws, steep)
    found = 0
    for i in range(count):
        if v[i] >= 1.0:
            b.fired[found] = i
            found += 1
    for k in range(found):
        i = b.fired[k]
        slope = (j[i] - leak[i]) * speed[i]
        g = 0.0
        if bends is None:
            over = (v[i] - 1.0) / slope  # s since the spike, at the end of the step
        else:
            g = bends.draws[first + i]
            over = since(max(slope - g * (v[i] - 0.5), _SLOWEST), g, v[i] - 1.0)
            slope += 0.5 * g
        left = send(c, s, first + i, left)
        while over >= c.refractory[first + i]:
            over -= c.refractory[first + i]
            rising = 1.0 / slope if bends is None else until(slope, g)
            if over < rising:
                break
            over -= rising
            left = send(c, s, first + i, left)
        else:
            v[i], r[i] = 0.0, c.refractory[first + i] - over
            continue
        v[i], r[i] = over * slope if bends is None else risen(slope, g, over), 0.0
    return left


@_compiled
def send(c: ChipNet, s: ChipState, neuron: int, left: int) -> int:
    """Route a spike, or let it wait, or drop it; return what is left of the budget."""
    s.base.spikes[neuron] += 1
    s.counters[SPIKES] += 1
    if left > 0:
        route(c, s, neuron)
        return left - 1
    if s.ends[1] >= s.queue.size:
        s.counters[DROPPED] += 1
        return 0
    s.queue[(s.ends[0] + s.ends[1]) % s.queue.size] = neuron
    s.ends[1] += 1
    s.counters[WAITING] = max(s.counters[WAITING], s.ends[1])
    return 0


@_compiled
def route(c: ChipNet, s: ChipState, neuron: int) -> None:
    """Put the decoders of a neuron's spike on its population's lanes."""
    n = c.net
    p = c.home[neuron]
    lane, count = n.lane[p], n.lane[p + 1] - n.lane[p]
    begin = n.block[p] + (neuron - n.begin[p]) * count
    for q in range(count):
        s.base.raw[n.reaches[lane + q]] += n.decoder[begin + q]
