"""What steers a bat by spikes, whatever it is made of: a ping goes in, the answer of the motors comes out.

A brain is told the head's direction, the goal neuron and what the ping shows, and says where the head goes,
which body motors spiked and when, and whether the bat has to turn round, until the next ping.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from circuits.arrays import F64, I64
from circuits.errors import ParameterError
from system.openspace.law import Arcs
from system.spiking_bat.bat import Answer, ping, settled
from system.spiking_bat.maps import longest_latency
from system.spiking_bat.network.kernel import State
from system.spiking_bat.network.network import Network
from system.spiking_bat.numbers import Numbers
from system.spiking_bat.topology import published


class Reply(Protocol):
    """What the motors said after a ping. Times in s after it.

    head: direction of the next ping, None to stay; arcs: whose body motors spiked; turned: when the first of
    them did, None without; emergency: when its neuron spiked, or None.
    """

    @property
    def head(self) -> int | None: ...  # noqa: D102 - of the class

    @property
    def arcs(self) -> I64: ...  # noqa: D102

    @property
    def turned(self) -> float | None: ...  # noqa: D102

    @property
    def emergency(self) -> float | None: ...  # noqa: D102


class Brain(Protocol):
    """A brain that steers a bat."""

    @property
    def period(self) -> float:
        """Time between pings, s."""
        ...

    def ping(self, head: int, goal: int, seen: F64) -> Reply:
        """Ping in direction `head` to goal neuron `goal`.

        seen: obstacles in view, float64[n, 2], m along the ping and to its left.
        """
        ...


@dataclass(frozen=True, slots=True)
class NetworkBrain:
    """The published network, or another of its kind, whose state goes on from ping to ping.

    numbers : of the network.
    """

    network: Network
    numbers: Numbers
    state: State

    @property
    def period(self) -> float:
        """Time between pings, s."""
        return self.numbers.ping_period

    def ping(self, head: int, goal: int, seen: F64) -> Answer:
        """Ping, and run the network to the next one."""
        return ping(self.network, self.state, self.numbers, head, goal, seen)


def network_brain(
    arcs: Arcs, numbers: Numbers, build: Callable[[Arcs, Numbers], Network] = published
) -> NetworkBrain:
    """The network that `build` makes of a bat's arcs, settled; raises `ParameterError` as `check_timing`."""
    check_timing(arcs, numbers)
    network = build(arcs, numbers)
    return NetworkBrain(network, numbers, settled(network, numbers))


def check_timing(arcs: Arcs, numbers: Numbers) -> None:
    """Refuse numbers of paths, taps and times that do not fit each other.

    Raises `ParameterError` for paths that are not the bat's, a ping period shorter than the longest echo, or
    than the readout, or longer than a memory lasts, and a delay line shorter than the longest latency.
    """
    s = numbers
    if s.paths != arcs.curvature.size:
        raise ParameterError(
            f"paths: {s.paths} memories, must be {arcs.curvature.size}, the arcs of the bat; build the chip"
            " for them"
        )
    echo, latency = longest_latency(arcs, s)
    rate = 1.0 / s.ping_period
    if s.ping_period < echo:
        raise ParameterError(
            f"ping_rate: {rate:g} Hz, a period of {1e3 * s.ping_period:.3g} ms is shorter than the longest"
            f" echo, {1e3 * echo:.3g} ms; ping at most {1.0 / echo:.3g} times a second"
        )
    for name, least in (("delay line", s.taps * s.tap_delay), ("emergency neuron", s.emergency)):
        if not least < s.reset_at:
            raise ParameterError(
                f"ping_rate: {rate:g} Hz, the {name} takes {1e3 * least:.3g} ms, must be less than the"
                f" {1e3 * s.reset_at:.3g} ms until the reset; ping more slowly,"
                " or use fewer taps"
            )
    if s.ping_period > s.memory:
        raise ParameterError(
            f"ping_rate: {rate:g} Hz, a period of {1e3 * s.ping_period:.3g} ms is longer than a memory"
            f" lasts, {1e3 * s.memory:.3g} ms; ping at least {1.0 / s.memory:.3g} times a second"
        )
    if s.taps * s.tap_delay < latency:
        raise ParameterError(
            f"taps: {s.taps}, a delay line of {1e3 * s.taps * s.tap_delay:.3g} ms, must reach the longest"
            f" latency of {1e3 * latency:.3g} ms; use at least {int(-(-latency // s.tap_delay))}"
        )
