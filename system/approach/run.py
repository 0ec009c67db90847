"""Approach: a bat-like sonar closes in on a target (Cheely & Horiuchi 2003, section 4, Figures 7 and 11).

call -> speaker -> air -> microphone -> envelope detector -> high-threshold neuron (the chip's call) and
onset neuron (its echo) -> 13 range-tuned neurons -> centroid board -> proximity voltage -> vocalization
controller -> rate and amplitude of the next call. First-target isolation cuts the chip's echo input after
the first spike until the next call. The amplitude follows the proximity voltage linearly, or the fourth
power of range through a second look-up table (the paper: possible, not done).

At transistor level every box is its own circuit; at behavioural level the boards, the hearing and the chip
are their measured models, single boxes at transistor level where `Scenario.transistors` says so. See
`system.loop` for how the parts move together, and `system.approach.behavioural` for how they do where all of
them are models.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from functools import partial

import numpy as np

from chips.cell import Cell
from chips.ranging.calibration.found import off_of
from chips.ranging.chip import RangingChip
from circuits.arrays import F64
from circuits.silicon.course import course_through, told_when
from system.approach import kernel
from system.approach.behavioural import Flight, fly_behavioural
from system.approach.film import film
from system.approach.loop import all_behavioural, build, circuits, models_of, move
from system.approach.scenario import Scenario
from system.approach.trace import (
    DOCUMENT,
    SUCCESS,
    SUMMARY,
    Trace,
    account,
    document,
    draw,
    draw_beside,
    estimated_range,
    spike_trains,
    summarise,
    title,
)
from system.loop import Loop, Round
from system.meaning import of_run
from system.options.on_silicon import IDEAL_CHIP
from system.options.outside import inside_boxes
from system.spikes.output import spikes_output
from system.system import System
from system.worlds.sound.targets import describe, range_at

GRID = 10e-3  # s, spacing of the reported arrays

STUDY_DURATION = 4.0  # s, unless asked


@dataclass(slots=True)
class _Log:
    """Events as they come, and the boards' voltages at the end of every round."""

    calls: list[tuple[float, float]] = field(default_factory=list)
    pulses: list[float] = field(default_factory=list)
    echoes: list[float] = field(default_factory=list)
    spikes: list[tuple[float, int]] = field(default_factory=list)
    boards: list[tuple[float, float, float]] = field(default_factory=list)


@inside_boxes
def run(
    scenario: Scenario, progress: Callable[[float], None] | None = None, workers: int | None = None
) -> Trace:
    """Run a scenario; the answer does not depend on `workers` (threads, all cores unless given)."""
    _refuse_early(scenario)
    if all_behavioural(scenario):
        models = partial(models_of, scenario)
        flight = fly_behavioural(models, scenario.stretches, scenario.duration, progress)
        return _read(scenario, flight)
    return run_in_loop(scenario, progress, workers)


def _refuse_early(scenario: Scenario) -> None:
    """Refuse, before any work, a course that leaves what the ranging chip's model was measured for."""
    course = course_through(scenario.course)
    if course is not None and scenario.level_of("chip") == "behavioural":
        silicon = scenario.silicon_at(course.begin)
        chip = RangingChip(silicon, bias_kind=scenario.bias_kind, codes=scenario.ranging_codes)
        course.check(scenario.duration, chip.neurons_at)


def run_in_loop(
    scenario: Scenario, progress: Callable[[float], None] | None = None, workers: int | None = None
) -> Trace:
    """Run a scenario, at whatever levels, by the general event loop."""
    with ThreadPoolExecutor(workers or os.cpu_count() or 1) as executor:
        loop = build(scenario, None if all_behavioural(scenario) else executor)
        log, off = _Log(), off_of(scenario.ranging_codes)
        for begin, end, celsius in scenario.stretches:
            if begin > 0.0:
                with told_when(begin):
                    move(loop, scenario, celsius)
            while loop.time < end:
                _note(log, loop.step(end), off)
                if progress is not None:
                    progress(loop.time / scenario.duration)
    return _trace(scenario, log, np.array(log.boards), _counts(loop))


def _note(log: _Log, done: Round, off: tuple[int, ...]) -> None:
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


def _read(scenario: Scenario, flight: Flight) -> Trace:
    """Sort the compiled loop's log."""
    table = np.concatenate(flight.rows)
    calls, pulses, echoes, spikes, boards = (table[table[:, 0] == kind, 1:] for kind in kernel.KINDS)
    log = _Log(
        calls=calls[:, :2].tolist(),
        pulses=pulses[:, 0].tolist(),
        echoes=echoes[:, 0].tolist(),
        spikes=[(time, int(n)) for time, n, _ in spikes.tolist()],
    )
    return _trace(scenario, log, boards, flight.counts)


def _trace(scenario: Scenario, log: _Log, boards: F64, counts: dict[str, int]) -> Trace:
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


def _counts(loop: Loop) -> dict[str, int]:
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


SYSTEM = System(
    name="approach",
    summary="bat's sonar that closes in on a target, from transistors up (Cheely & Horiuchi 2003)",
    kind=Scenario,
    success=SUCCESS,
    run=run,
    account=account,
    numbers=summarise,
    draw=draw,
    draw_beside=draw_beside,
    film=film,
    ideal=IDEAL_CHIP,
    study_metrics=("held_fraction", "range_error_mean_m"),
    study=lambda _: {"duration": STUDY_DURATION},
    document=document,
    meanings=of_run(SUMMARY, DOCUMENT),
    title=title,
    before=lambda trace: [describe(target) for target in trace.scenario.targets],
    outputs={
        "spikes": spikes_output("the spikes of the ranging chip and of both hearing neurons", spike_trains)
    },
    circuits=circuits,
)
