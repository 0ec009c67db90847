"""Events that inputs send by themselves: regular ones, which bring a constant current in the mean.

An input with a rate of `r` sends event k = 0, 1, ... of each of its channels at (k + 1/2) / r after the
start. All other channels are those of outside: events come on them, or rates are given for them, in the order
of the inputs.
"""

from __future__ import annotations

import numpy as np

from chips.aer import Events
from circuits.arrays import F64, I64
from system.mapping.network import Network


def own_rates(network: Network) -> F64:
    """Return the rate at which each channel sends by itself, Hz, float64[channels]; 0 of one of outside."""
    return np.repeat([p.rate for p in network.inputs], [p.size for p in network.inputs]).astype(np.float64)


def outside(network: Network) -> I64:
    """Return the numbers of the channels of outside, int64[n]."""
    return np.flatnonzero(own_rates(network) == 0.0)


def with_own(network: Network, events: Events, begin: float, end: float) -> Events:
    """Return events with those that channels send by themselves from `begin` until `end`, s, in order."""
    times, channels = [events.times], [events.addresses]
    for channel, rate in enumerate(own_rates(network).tolist()):
        if rate > 0.0:
            first, stop = (int(np.ceil(time * rate - 0.5 - 1e-9)) for time in (begin, end))
            times.append((np.arange(first, stop) + 0.5) / rate)
            channels.append(np.full(stop - first, channel))
    if len(times) == 1:
        return events
    when = np.concatenate(times)
    order = np.argsort(when, kind="stable")
    return Events(when[order], np.concatenate(channels)[order])


def with_own_rates(network: Network, rates: F64) -> F64:
    """Return rates of all channels, float64[..., channels], from those of outside, float64[..., n], Hz."""
    own = own_rates(network)
    found = np.broadcast_to(own, (*rates.shape[:-1], own.size)).copy()
    found[..., own == 0.0] = rates
    return found
