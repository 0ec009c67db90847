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
from functools import partial

import numpy as np

from chips.ranging.calibration.found import off_of
from chips.ranging.chip import RangingChip
from circuits.errors import ParameterError
from circuits.silicon.course import course_through, told_when
from system.approach import kernel
from system.approach.behavioural import Flight, fly_behavioural
from system.approach.film import film
from system.approach.live import LiveApproach, in_hand
from system.approach.log import Log, counts_of, note, trace_of
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
    spike_trains,
    summarise,
    title,
)
from system.meaning import of_run
from system.options.on_silicon import IDEAL_CHIP
from system.options.outside import inside_boxes
from system.spikes.output import spikes_output
from system.system import System
from system.worlds.sound.targets import describe

STUDY_DURATION = 4.0  # s, unless asked


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
        log, off = Log(), off_of(scenario.ranging_codes)
        for begin, end, celsius in scenario.stretches:
            if begin > 0.0:
                with told_when(begin):
                    move(loop, scenario, celsius)
            while loop.time < end:
                note(log, loop.step(end), off)
                if progress is not None:
                    progress(loop.time / scenario.duration)
    return trace_of(scenario, log, np.array(log.boards), counts_of(loop))


def open_sonar(scenario: Scenario) -> LiveApproach:
    """Return the sonar of a scenario at rest, which goes on by 10 ms, at whatever levels.

    Raises `ParameterError` for a course of temperature, which a run step by step has none of.
    """
    if scenario.course:
        raise ParameterError("temperature: a course, must be one number in a run step by step; give degC")
    return LiveApproach(scenario, in_hand(build(scenario)))


def _read(scenario: Scenario, flight: Flight) -> Trace:
    """Sort the compiled loop's log."""
    table = np.concatenate(flight.rows)
    calls, pulses, echoes, spikes, boards = (table[table[:, 0] == kind, 1:] for kind in kernel.KINDS)
    log = Log(
        calls=calls[:, :2].tolist(),
        pulses=pulses[:, 0].tolist(),
        echoes=echoes[:, 0].tolist(),
        spikes=[(time, int(n)) for time, n, _ in spikes.tolist()],
    )
    return trace_of(scenario, log, boards, flight.counts)


SYSTEM = System(
    name="approach",
    summary="bat's sonar that closes in on a target, from transistors up (Cheely & Horiuchi 2003)",
    kind=Scenario,
    success=SUCCESS,
    run=run,
    account=account,
    numbers=summarise,
    draw=draw,
    film=film,
    draw_beside=draw_beside,
    ideal=IDEAL_CHIP,
    study_metrics=("held_fraction", "range_error_mean_m"),
    open=open_sonar,
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
