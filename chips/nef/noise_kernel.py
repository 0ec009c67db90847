"""Compiled noise of a network on the NEF chip, which its neurons' currents and its filters get.

A neuron's noise stands still for what it charges in a step, at most up to where it would spike, so that it
moves the spike as white noise would. In the first step after a refractory period it has the jitter of the
period, `(J - leak)^2 q t_ref / I_rfr` of charge squared, and the `k T C` of the reset as well.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from chips.lines.steps import LineSteps, bring_lines
from chips.nef.network.kernel import DT, Net, State
from chips.noise_draw import Draws, Slow, bring, draw
from circuits.arrays import F32, F64, I64
from circuits.compiled import compiled

SLOW_LEAK, SLOW_REFRACTORY = range(2)  # slow processes, relative
LINE_LEAK, LINE_REFRACTORY, LINE_BIAS = range(3)  # lines that all neurons share
LEAST = 0.02 * DT  # s, shortest time for which a noise current is taken to stand still; ours

_compiled = compiled()


class NefNoise(NamedTuple):
    """Noise of a network on a chip; currents in thresholds.

    above, below, bias: currents of the stages as `ChipNet` has them, each as often as its noise is that of an
    electron's; grain: charge of an electron, thresholds s; dead: `q t_ref / I_rfr`, s^2, float64[neurons];
    reset: `k T C`, (thresholds s)^2; lanes: relative deviation that a step adds to a filter, float64[lanes];
    total, late: working space, what flows in total, then the noise, and what a period by a share longer takes
    of a step's current, float64[neurons]; slow: flicker; neurons, filters: draws; step: how many steps were
    taken, int64[1]; lines: of the chip's generator, none where they do not wander.
    """

    above: F64
    below: F64
    bias: F64
    grain: float
    dead: F64
    reset: float
    lanes: F64
    total: F64
    late: F64
    slow: Slow
    neurons: Draws
    filters: Draws
    step: I64
    lines: LineSteps


@_compiled
def begin_noise(t: NefNoise) -> None:
    """Draw a step's noise of all neurons and filters."""
    number = t.step[0]
    bring(t.slow, t.neurons, number)
    draw(t.neurons, number, 0)
    draw(t.filters, number, 0)
    bring_lines(t.lines, number)
    t.step[0] = number + 1


@_compiled
def disturb_filters(t: NefNoise, s: F64) -> None:
    """Add noise to the filters' states, float64[lanes]."""
    for k in range(s.size):
        s[k] += s[k] * t.lanes[k] * t.filters.normal[k]


@_compiled
def disturb_neurons(
    t: NefNoise, n: Net, b: State, lines: F64, leak: F64, speed: F64, refractory: F64, p: int
) -> None:
    """Add noise to the currents of population p in this step; lines: of the chip, float64[3, slots]."""
    begin, count = n.begin[p], n.begin[p + 1] - n.begin[p]
    total = t.total[begin : begin + count]
    for i in range(count):
        total[i] = t.bias[begin + i] + leak[begin + i]
    for k in range(n.slot[p], n.slot[p + 1]):
        y, row = b.x[k] - lines[0, k], n.row[k]
        rows = t.above[row : row + count] if y > 0.0 else t.below[row : row + count]
        x = lines[1, k] * y if y > 0.0 else -lines[2, k] * y
        for i in range(count):
            total[i] += x * rows[i]
    given = b.rest[begin : begin + count], b.u[begin : begin + count], b.current[begin : begin + count]
    own = leak[begin : begin + count], speed[begin : begin + count], refractory[begin : begin + count]
    late, normal = t.late[begin : begin + count], t.neurons.normal[begin : begin + count]
    shake(given, own, (t.grain, t.reset), t.dead[begin : begin + count], normal, total, late)
    if t.slow.deviation.size:
        slow_leak = t.slow.value[SLOW_LEAK, begin : begin + count]
        slow_dead = t.slow.value[SLOW_REFRACTORY, begin : begin + count]
        for i in range(count):
            total[i] -= own[0][i] * slow_leak[i] + late[i] * slow_dead[i]
    if t.lines.shift.size:
        line, bias = t.lines.shift, n.bias[begin : begin + count]
        for i in range(count):
            total[i] += bias[i] * line[LINE_BIAS] - own[0][i] * line[LINE_LEAK]
            total[i] += late[i] * line[LINE_REFRACTORY]
    for i in range(count):
        given[2][i] += total[i] if given[0][i] < DT else 0.0


@_compiled
def shake(
    given: tuple[F64, F64, F64],
    own: tuple[F64, F64, F64],
    charges: tuple[float, float],
    dead: F64,
    normal: F32,
    total: F64,
    late: F64,
) -> None:
    """Make of what flows in total the white noise of a step, thresholds, in place.

    given: what is left of refractory periods, membranes and currents; own: leaks, speeds and refractory
    periods; charges: grain and reset; dead, late: as of `NefNoise`.
    """
    (rest, u, current), (leak, speed, refractory), (grain, reset) = given, own, charges
    for i in range(total.size):
        left = rest[i]
        free = min(max(DT - left, 0.0), DT)
        rising = current[i] - leak[i]
        slope = rising * speed[i]
        until = (1.0 - u[i]) / slope
        crosses = u[i] + slope * free > 1.0
        span = max(until if crosses else free, LEAST)
        variance = grain * total[i] / span
        ends = (rising * rising * dead[i] + reset) / (span * span)
        over = rising * refractory[i] / span
        variance += ends if left > 0.0 else 0.0
        late[i] = over if left > 0.0 else 0.0
        total[i] = math.sqrt(variance) * normal[i]
