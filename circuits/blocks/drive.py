"""Sources of a block's testbench: its supply, and what drives its other ports.

A source has the name of the node that it drives. A wave is a waveform, or a number for a level that stays.
"""

from __future__ import annotations

from collections.abc import Mapping

from circuits.circuit import Port
from circuits.count import pulse_count
from circuits.devices.source import Constant, PiecewiseLinear, Source, Waveform

Wave = Waveform | float  # a number is a level that stays, in V or A


def powered(v_dd: float, waves: Mapping[str, Wave] | None = None) -> tuple[Source, ...]:
    """The supply of `v_dd` (V) at the port `vdd`, and behind it a voltage source at each node of `waves`."""
    return driven({"vdd": v_dd, **(waves or {})})


def driven(waves: Mapping[str, Wave]) -> tuple[Source, ...]:
    """A voltage source at each node of `waves`, in V."""
    return tuple(Source(node, node, _wave(wave)) for node, wave in waves.items())


def current_into(node: str, wave: Wave) -> Source:
    """Make a source that drives a current into a node.

    Parameters
    ----------
    node
        The node, by which the source is named.
    wave
        The current, A: a waveform, or a number for a level that stays.
    """
    return Source(node, node, _wave(wave), "current")


def elements(port: Port, waves: Mapping[int, Wave]) -> dict[str, Wave]:
    """The waves of a port's elements, by node: those of `waves`, by index, and 0 V for all others."""
    return {node: waves.get(k, 0.0) for k, node in enumerate(port.elements())}


def step(begin: float, end: float, before: float, after: float) -> PiecewiseLinear:
    """A level (V or A) that changes once, along a straight line.

    Parameters
    ----------
    begin, end
        When the change begins and ends, s.
    before, after
        The level before and after it, V or A.
    """
    return PiecewiseLinear((0.0, begin, end), (before, before, after))


def train(name: str, count: float, rate: float, first: float) -> tuple[float, ...]:
    """Times of `count` pulses at `rate` (Hz), the first at `first`, s.

    Raises `ParameterError`, which calls the count `name`, for none or too many, or for a rate of 0 or below.
    """
    return tuple(first + k / rate for k in range(pulse_count(name, count, rate)))


def _wave(wave: Wave) -> Waveform:
    return Constant(wave) if isinstance(wave, int | float) else wave
