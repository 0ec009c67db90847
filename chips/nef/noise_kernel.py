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
from circuits.arrays import F64, I64
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
    total: working space, float64[neurons]; slow: flicker; neurons, filters: draws; step: how many steps were
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
    for i in range(count):
        k = begin + i
        left = b.rest[k]
        free = min(max(DT - left, 0.0), DT)
        if free > 0.0:
            rising = b.current[k] - leak[k]
            slope = rising * speed[k]
            crosses = b.u[k] + slope * free > 1.0
            span = max((1.0 - b.u[k]) / slope if crosses else free, LEAST)
            variance = t.grain * total[i] / span
            more = 0.0
            if left > 0.0:
                variance += (rising * rising * t.dead[k] + t.reset) / (span * span)
                more = rising * refractory[k] / span
            shift = math.sqrt(variance) * t.neurons.normal[k]
            if t.slow.deviation.size:
                shift -= leak[k] * t.slow.value[SLOW_LEAK, k] + more * t.slow.value[SLOW_REFRACTORY, k]
            if t.lines.shift.size:
                line = t.lines.shift
                shift += n.bias[k] * line[LINE_BIAS] - leak[k] * line[LINE_LEAK]
                shift += more * line[LINE_REFRACTORY]
            b.current[k] += shift
