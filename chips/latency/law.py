"""Closed forms of the two neurons that turn latencies into latencies (Wen and Horiuchi 2022).

The integrating neuron, to which each spike switches on a current E_0, spikes at

    T_eval = (C V_th + E_0 sum t_i) / (n E_0),    t_1 <= ... <= t_n < T_eval        (9)

and a neuron of the race, with a passive current, charges, and inhibitory currents switched on at t_i, at

    T_WTA = (C V_th - Q_goal - Q_dir - sum I_i t_i) / (I_exc - sum I_i),    t_i < T_WTA        (10)

Valid as long as every current is still on, charges came before the spike, and the net current is above 0.
Here currents and charges are in units of C V_th: thresholds a second, and thresholds.
"""

from __future__ import annotations

import math
from collections.abc import Sequence


def evaluation_latency(times: Sequence[float], current: float) -> float:
    """Return T_eval (s) by equation (9), inf for no spike.

    times: of the inputs, s; current: that each of them switches on, thresholds/s.
    """
    total, ordered = 0.0, sorted(times)
    for n, t in enumerate(ordered, 1):
        total += t
        latency = (1.0 + current * total) / (n * current)
        if n == len(ordered) or latency <= ordered[n]:
            return latency
    return math.inf


def race_latency(passive: float, charge: float, inhibitions: Sequence[tuple[float, float]]) -> float:
    """Return T_WTA (s) by equation (10), inf for no spike.

    passive: current, thresholds/s; charge: thresholds; inhibitions: pairs of a time (s) and a current
    (thresholds/s).
    """
    net, level = passive, 1.0 - charge
    ordered = sorted(inhibitions)
    for t, current in ordered:
        if net > 0.0 and level / net <= t:
            break
        net -= current
        level -= current * t
    return level / net if net > 0.0 else math.inf
