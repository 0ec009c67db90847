"""What blocks measure of a run: when nodes pass half the supply, for how long, and when they spike.

The supply is the one that the circuit is wired to (`circuits.lowering.supply`).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial

from circuits.arrays import F64
from circuits.event import falling_crossing, rising_crossing
from circuits.lowering.supply import half_supply
from circuits.measure.scope import TransientRecord
from circuits.measure.signal import extreme
from circuits.solver.transient import Result

Measures = Callable[[Result], Mapping[str, float | None]]


def rise(result: Result, node: str) -> float | None:
    """First time at which a node rises through half the supply, s; None where it never does."""
    return rising_crossing(result.time, result[node], half_supply(result.machine))


def fall(result: Result, node: str) -> float | None:
    """First time at which a node falls through half the supply, s; None where it never does."""
    return falling_crossing(result.time, result[node], half_supply(result.machine))


def peak(result: Result, node: str, begin: float = 0.0) -> tuple[float, float]:
    """Time (s) and voltage (V) of a node's peak from `begin` (s) on: between steps where it is there."""
    signal = TransientRecord(result).voltage(node)
    return extreme(signal, begin, signal.ends[1], 1.0)


def between(begin: float | None, end: float | None) -> float | None:
    """The time from `begin` to `end`, s; None where either is not in the run."""
    return None if begin is None or end is None else end - begin


def high_time(result: Result, node: str) -> float | None:
    """How long the first pulse of a node lasts, s.

    None for a node that begins high, and for one without a pulse.
    """
    return _positive(between(rise(result, node), fall(result, node)))


def low_time(result: Result, node: str) -> float | None:
    """How long a node stays low for the first time, s.

    None for a node that begins low, and for one that does not fall or does not rise again.
    """
    return _positive(between(fall(result, node), rise(result, node)))


def latency(result: Result, since: float, port: str = "spike") -> float | None:
    """From the time `since` (s) to the first spike of a watched port, s; None without a spike."""
    spikes = result.spikes[port]
    return float(spikes[0]) - since if spikes.size else None


def last_rate(spikes: F64) -> float | None:
    """Rate (Hz) by the interval between the last two of several times (s); None where there are fewer."""
    return 1.0 / float(spikes[-1] - spikes[-2]) if spikes.size > 1 else None


def spiked(result: Result, port: str = "spike") -> bool:
    """Whether a watched port has a spike in the run."""
    return bool(result.spikes[port].size)


def spiking(yes: str, no: str, port: str = "spike") -> Callable[[Result], str]:
    """An outcome of runs: the word `yes` where a watched port has spiked, else the word `no`."""
    return partial(_word, yes=yes, no=no, port=port)


def whether(measures: Measures, name: str, yes: str, no: str) -> Callable[[Result], str]:
    """An outcome of runs: the word `yes` where `measures` finds the number `name`, else the word `no`."""
    return partial(_found, measures=measures, name=name, yes=yes, no=no)


def _found(result: Result, measures: Measures, name: str, yes: str, no: str) -> str:
    return no if measures(result)[name] is None else yes


def _word(result: Result, yes: str, no: str, port: str) -> str:
    return yes if spiked(result, port) else no


def spike_outcome(result: Result) -> str:
    """How often the port `spike` of a neuron has spiked: `none`, `one-spike` or `several-spikes`."""
    return ("none", "one-spike", "several-spikes")[min(result.spikes["spike"].size, 2)]


def _positive(time: float | None) -> float | None:
    return time if time is not None and time > 0.0 else None
