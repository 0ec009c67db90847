"""Compiled rates of neurons on a die at currents that stand still, and spikes that are counted of signals.

With J less the leak, and half of what all that draws rises by from reset to threshold taken off it,

    rate = 1 / (refractory + charge / above),    above = rise / ln(1 + rise / end)

where `end` is what is left at the threshold: what charges as fast as a current that falls by `rise` to it.
Without a rise `above` is the current less the leak.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from chips.nef.whole.kernel import add_bent
from circuits.arrays import F64
from circuits.compiled import compiled
from circuits.devices.packable import even_log1p

_compiled = compiled()


class Law(NamedTuple):
    """What the rates of neurons follow: as of `chips.nef.model.NeuronLaw`, float64[n] each."""

    leak: F64
    charge: F64
    refractory: F64
    rise: F64
    mirrored: float


@_compiled
def fill_rates(law: Law, current: F64, sunk: F64, rates: F64) -> None:
    """Fill the rates of each row of currents, Hz, float64[rows, n]; sunk: what mirrors draw, thresholds."""
    for k in range(current.shape[0]):
        _row(law, current[k], sunk[k], rates[k])


@_compiled
def count_spikes(
    law: Law, standing: F64, shares: F64, stages: F64, window: float, room: F64, counted: F64
) -> None:
    """Count spikes in a window, s, at each of some points, and make rates of them, Hz, float64[points, n].

    standing: what neurons get whatever the signals, and what of it mirrors draw, thresholds, float64[2, n];
    shares: what lines give at a point, above and below in turn, full scales of which one is 0,
    float64[points, 2 d]; stages: what the stages make of a full scale, float64[2 d, n]; room: working space,
    float64[3, n]; counted: for each the share of a period since its last spike as the window begins, then
    the rates.
    """
    current, sunk, rate = room[0], room[1], room[2]
    for k in range(counted.shape[0]):
        for i in range(current.size):
            current[i], sunk[i] = standing[0, i], standing[1, i]
        for j in range(shares.shape[1]):
            if shares[k, j] != 0.0:
                add_bent(current, sunk, stages[j], shares[k, j])
        _row(law, current, sunk, rate)
        own = counted[k]
        for i in range(own.size):
            own[i] = np.floor(rate[i] * window + own[i]) / window


@_compiled
def _row(law: Law, current: F64, sunk: F64, rate: F64) -> None:
    """Rates of all neurons at a current each."""
    if law.mirrored == 0.0:
        for i in range(current.size):
            above = current[i] - law.leak[i]
            period = law.refractory[i] + law.charge[i] / (above if above > 0.0 else 1.0)
            rate[i] = 1.0 / period if above > 0.0 else 0.0
        return
    steep = 0
    for i in range(current.size):
        rise = law.rise[i] + law.mirrored * sunk[i]
        end = current[i] - law.leak[i] - 0.5 * rise
        share = rise / (end if end > 0.0 else 1.0)
        above = rise / even_log1p(min(share, 1.0))
        period = law.refractory[i] + law.charge[i] / above
        rate[i] = 1.0 / period if end > 0.0 else 0.0
        steep += share > 1.0
    if not steep:
        return
    for i in range(current.size):
        rise = law.rise[i] + law.mirrored * sunk[i]
        end = current[i] - law.leak[i] - 0.5 * rise
        if 0.0 < end < rise:
            above = rise / math.log1p(rise / end)
            rate[i] = 1.0 / (law.refractory[i] + law.charge[i] / above)
