"""What is noted of an approach while it goes on, and the trace that is made of it."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from chips.cell import Cell
from circuits.arrays import F64
from system.approach.scenario import Scenario
from system.approach.trace import Trace, estimated_range
from system.loop import Loop, Round
from system.worlds.sound.targets import range_at

GRID = 10e-3  # s, spacing of the reported arrays


@dataclass(slots=True)
class Log:
    """Events as they come, and the boards' voltages at the end of every round.

    calls : time (s) and amplitude (V); pulses, echoes : of the hearing's neurons, s; spikes : time (s) and
    neuron; boards : time (s), proximity and amplitude (V).
    """

    calls: list[tuple[float, float]] = field(default_factory=list)
    pulses: list[float] = field(default_factory=list)
    echoes: list[float] = field(default_factory=list)
    spikes: list[tuple[float, int]] = field(default_factory=list)
    boards: list[tuple[float, float, float]] = field(default_factory=list)


def note(log: Log, done: Round, off: tuple[int, ...]) -> None:
    """Note what a round brought; off: neurons whose spikes reach nothing."""
    amplitude = float(done.outputs["vocalization"].voltage[-1, 0])
    log.boards.append((done.stop, float(done.outputs["centroid"].voltage[-1, 0]), amplitude))
    for part, port, time in done.events:
        if part == "vocalization":
            log.calls.append((time, amplitude))
        elif "high_threshold" in {part, port}:
            log.pulses.append(time)
        elif "onset" in {part, port}:
            log.echoes.append(time)
        elif part == "chip" or part.startswith("neuron"):
            k = _index(port if part == "chip" else part)
            if k not in off:
                log.spikes.append((time, k))


def _index(name: str) -> int:
    return int(name[name.index("[") + 1 : -1])


def trace_of(scenario: Scenario, log: Log, boards: F64, counts: dict[str, int]) -> Trace:
    """Return the trace of a run; boards: time (s), proximity and amplitude (V), float64[n, 3]."""
    time = np.arange(0.0, scenario.duration + 0.5 * GRID, GRID)
    boards = np.concatenate([[[0.0, *boards[0, 1:]]], boards])
    proximity = np.interp(time, boards[:, 0], boards[:, 1])
    calls = np.array(log.calls).reshape(-1, 2)
    rate = np.full(time.size, np.nan)
    if len(calls) > 1:
        last = np.searchsorted(calls[:, 0], time, side="right") - 1
        interval = np.diff(calls[:, 0])
        rate = np.where(last >= 1, 1.0 / interval[np.maximum(last - 1, 0)], np.nan)
    return Trace(
        scenario=scenario,
        time_s=time,
        range_m=range_at(scenario.targets[0].trajectory, time),
        estimate_m=estimated_range(proximity, scenario),
        proximity_V=proximity,
        call_rate_Hz=rate,
        call_amplitude_V=np.interp(time, boards[:, 0], boards[:, 2]),
        calls=calls,
        pulses=np.array(log.pulses),
        echoes=np.array(log.echoes),
        spikes=tuple(log.spikes),
        counts=counts,
    )


def counts_of(loop: Loop) -> dict[str, int]:
    """Return the counters of a loop."""
    states = loop.states
    counts = {
        "solver_steps": sum(
            int(states[n].solver.counts[0]) for n, p in loop.parts.items() if isinstance(p, Cell)
        ),
        "merged_events": sum(getattr(state, "merged", 0) for state in states.values()),
        "repeated_advances": loop.repeated,
    }
    if "ear" in states:
        counts["clipped_samples"] = states["ear"].microphone.clipped
    if "hearing" in states:
        counts["undecided_sounds"] = states["hearing"].heard.undecided
        counts["clipped_sounds"] = states["hearing"].clipped
    if "chip" in states:
        counts["undecided_spikes"] = states["chip"].undecided
    return counts
