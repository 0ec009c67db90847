"""Where an approach loses its target, and which neurons lost it.

A target is lost while the estimate is no longer near it, as the approach's own sentence of success has it.
The run tells of three things that a neuron did wrong meanwhile:

- it was silent: the chip heard the call and the target's echo, the delay was the neuron's own, and neither it
  nor another before the echo had spiked;
- it ran away: it spiked more often than the chip heard calls and echoes together;
- it answered at the wrong delay: it spiked after most calls although no echo came between the delays of its
  two neighbours.

What each transistor of such a neuron has to do with that is tried in `system.approach.healing`.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from chips.ranging import circuit as ranging_chip
from chips.ranging.calibration.found import delays_of, off_of
from circuits.arrays import F64, I64, Bools
from system.approach.scenario import air_of
from system.approach.trace import NEAR, SETTLED, Trace
from system.worlds.sound.acoustics import speed_of_sound
from system.worlds.sound.microphone import Microphone
from system.worlds.sound.targets import range_at

_SHORTEST = 0.1  # s for which a target is away before it is lost; ours
_OFF = 1e-3  # s by which the target's echo may be off from where it is; ours
_LEAD = 5e-3  # s of a window before its first call; ours
_LONGEST = 60e-3  # s of a window after the call; ours
_MOST_CALLS = 0.5  # share of a loss's calls above which they are most


@dataclass(frozen=True, slots=True)
class Reason:
    """What a neuron did wrong at a call.

    Attributes
    ----------
    neuron : int
        Its number.
    why : str
        What it did, in words that follow its name.
    call, echo : float
        When the chip heard the call, and the echo that the neuron should have answered, s; the call again
        where there is none.
    begin, end : float
        The stretch of time that shows it, s.
    least, most : float
        Spikes from the call to the end that would have been right.
    """

    neuron: int
    why: str
    call: float
    echo: float
    begin: float
    end: float
    least: float = 0.0
    most: float = math.inf

    @property
    def name(self) -> str:
        """The neuron's name."""
        return f"neuron[{self.neuron}]"


@dataclass(frozen=True, slots=True, eq=False)
class _Heard:
    """What a chip heard and said in some of a run's calls.

    calls : when it heard each, s. ends : when it heard the next, s. echoes : what it heard between, s after
    the call, float64[n] a call. spikes : times of its spikes between, s, by call and neuron. delays : s, of
    each neuron; infinite where it is off.
    """

    trace: Trace
    calls: F64
    ends: F64
    echoes: tuple[F64, ...]
    spikes: tuple[tuple[F64, ...], ...]
    delays: F64

    @property
    def counts(self) -> I64:
        """Spikes, int64[calls, neurons]."""
        return np.array([[times.size for times in each] for each in self.spikes], dtype=np.int64)

    def at(self, k: int, neuron: int, why: str, echo: float, **right: float) -> Reason:
        """What a neuron did wrong at a call; right: spikes that would have been."""
        call = float(self.calls[k])
        earlier = self.trace.pulses[self.trace.pulses < call]
        begin = max(0.0, float(earlier[-1] if earlier.size else call) - _LEAD)
        return Reason(neuron, why, call, echo, begin, min(float(self.ends[k]), call + _LONGEST), **right)


def _heard(trace: Trace, begin: float, end: float) -> _Heard:
    """What the chip heard and said from the last call before a stretch of time, s, on."""
    before = float(np.max(trace.pulses[trace.pulses <= begin], initial=0.0))
    ends = np.append(trace.pulses[1:], trace.scenario.duration)
    own = (trace.pulses >= before) & (trace.pulses < end)
    spikes = np.array(trace.spikes, dtype=np.float64).reshape(-1, 2)
    delays = np.array(delays_of(trace.scenario.ranging_codes))
    delays[[*off_of(trace.scenario.ranging_codes)]] = np.inf
    calls = list(zip(trace.pulses[own].tolist(), ends[own].tolist(), strict=True))
    trains = [spikes[spikes[:, 1] == k, 0] for k in range(ranging_chip.NEURONS)]
    return _Heard(
        trace, trace.pulses[own], ends[own],
        tuple(_between(trace.echoes, a, b) - a for a, b in calls),
        tuple(tuple(_between(train, a, b) for train in trains) for a, b in calls),
        delays,
    )  # fmt: skip


def _between(times: F64, begin: float, end: float) -> F64:
    return np.asarray(times[(times > begin) & (times < end)])


def losses(trace: Trace) -> list[tuple[float, float]]:
    """Return the stretches of time, s, in which the target is lost."""
    lost = _away(trace) & (trace.time_s >= SETTLED)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], lost, [False]]).astype(np.int8)))
    times = np.append(trace.time_s, trace.scenario.duration)
    pairs = [(float(times[a]), float(times[b])) for a, b in edges.reshape(-1, 2)]
    return [(begin, end) for begin, end in pairs if end - begin >= _SHORTEST]


def reasons(trace: Trace, begin: float, end: float) -> Iterator[Reason]:
    """Yield what neurons did wrong in a stretch of time, s: of each kind the neuron that did it most."""
    heard = _heard(trace, begin, end)
    if heard.calls.size:
        yield from _run_away(heard)
        yield from _at_wrong_delay(heard)
        yield from _silent(heard)


def _away(trace: Trace) -> Bools:
    """Where the estimate is not near the first target, bool[T]."""
    error = np.abs(trace.estimate_m - trace.range_m)
    others = [range_at(t.trajectory, trace.time_s) for t in trace.scenario.targets[1:]]
    if not others:
        return np.asarray(error > NEAR)
    return np.asarray(error >= np.min([np.abs(trace.estimate_m - r) for r in others], axis=0))


def _runaways(heard: _Heard) -> I64:
    """Neurons that spike more often than calls and echoes can have made them, those that do it most first."""
    made = heard.calls.size + sum(echoes.size for echoes in heard.echoes)
    spikes = heard.counts.sum(axis=0)
    order = np.argsort(-spikes, kind="stable")
    return np.asarray(order[spikes[order] > made])


def _run_away(heard: _Heard) -> Iterator[Reason]:
    found, counts = _runaways(heard), heard.counts
    if found.size:
        first = int(found[0])
        others = "" if found.size == 1 else f", as {found.size - 1} more"
        k = int(np.argmax(counts[:, first]))
        why = f"runs away with {counts[:, first].mean():.0f} spikes a call{others}"
        yield heard.at(k, first, why, float(heard.calls[k]), most=1.0 + heard.echoes[k].size)


def _at_wrong_delay(heard: _Heard) -> Iterator[Reason]:
    on = np.flatnonzero(np.isfinite(heard.delays))
    on = on[np.argsort(heard.delays[on], kind="stable")]
    if on.size < 2:
        return
    own = heard.delays[on]
    ends = np.concatenate([[2.0 * own[0] - own[1]], own, [2.0 * own[-1] - own[-2]]])
    away, counts = set(_runaways(heard).tolist()), heard.counts
    wrong = np.zeros((heard.calls.size, len(heard.delays)), dtype=np.bool_)
    for neuron, low, high in zip(on.tolist(), ends[:-2], ends[2:], strict=True):
        none = [not _between(echoes, low, high).size for echoes in heard.echoes]
        wrong[:, neuron] = np.array(none) & (counts[:, neuron] > 0) & (neuron not in away)
    calls = wrong.sum(axis=0)
    most = int(np.argmax(calls))
    if calls[most] > _MOST_CALLS * heard.calls.size:
        k = int(np.argmax(wrong[:, most]))
        others = int((calls > _MOST_CALLS * heard.calls.size).sum()) - 1
        more = f", as {others} more" if others else ""
        why = f"answers {calls[most]} of {heard.calls.size} calls without an echo at its delay{more}"
        yield heard.at(k, most, why, float(heard.calls[k]), most=0.0)


def _silent(heard: _Heard) -> Iterator[Reason]:
    """The neuron of the target's delay at the first call whose echo neither it nor one before answered."""
    trace = heard.trace
    speed, apart = speed_of_sound(air_of(trace.scenario).temperature), Microphone().mouth_ear_delay
    for k, call in enumerate(heard.calls.tolist()):
        delay = 2.0 * float(np.interp(call, trace.time_s, trace.range_m)) / speed - apart
        near = heard.echoes[k][np.abs(heard.echoes[k] - delay) < _OFF] + call
        neuron = int(np.argmin(np.abs(heard.delays - delay)))
        first = min((float(times[0]) for times in heard.spikes[k] if times.size), default=math.inf)
        if near.size and not heard.spikes[k][neuron].size and first >= near[0]:
            yield heard.at(k, neuron, "does not answer", float(near[0]), least=1.0)
            return
