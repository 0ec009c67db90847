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
from concurrent.futures import Executor, ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from chips.boards.centroid.model import CentroidModel
from chips.boards.isolation.model import IsolationModel
from chips.boards.vocalization.model import VocalizationModel
from chips.cell import Cell
from chips.hearing.model import hearing_on
from chips.part import Part
from chips.ranging import circuit as ranging_chip
from chips.ranging.chip import RangingChip
from circuits.arrays import F64
from circuits.bias import rebias
from circuits.blocks.sonar import (
    centroid_board,
    envelope_detector,
    first_target_isolation,
    high_threshold_neuron,
    onset_neuron,
    vocalization_controller,
)
from circuits.circuit import Circuit
from circuits.errors import ParameterError
from circuits.place import circuit_at
from circuits.silicon.silicon import Silicon
from system.approach import kernel
from system.approach.behavioural import Flight, Models, fly_behavioural
from system.approach.trace import (
    SUCCESS,
    SUMMARY,
    Scenario,
    Trace,
    account,
    air_of,
    document,
    draw,
    estimated_range,
    summarise,
    title,
)
from system.loop import AnalogWire, EventWire, Loop, Round
from system.options.noise import silicon_noise
from system.system import System, metrics_with
from system.worlds.sound.ear import SAMPLE_RATE, Ear
from system.worlds.sound.hearing import Hearing
from system.worlds.sound.microphone import Microphone
from system.worlds.sound.targets import describe, range_at

# Longest round, s; ours, a matter of speed only.
HORIZON = 4e-3
BEHAVIOURAL_HORIZON = 20e-3
ENVELOPE_TOLERANCE = 1e-3  # V, thinning of the envelope between detector and neurons; ours
GRID = 10e-3  # s, spacing of the reported arrays
# Ours: neuron 2's spikes come within 3 us of the converged ones. How far calls move when all tolerances are
# divided by ten is measured by benchmarks/approach.py.
CHIP_RTOL = 3e-4
BOARD_RTOL = 1e-3

STUDY_DURATION = 4.0  # s, unless asked


@dataclass(slots=True)
class _Log:
    """Events as they come, and the boards' voltages at the end of every round."""

    calls: list[tuple[float, float]] = field(default_factory=list)
    pulses: list[float] = field(default_factory=list)
    echoes: list[float] = field(default_factory=list)
    spikes: list[tuple[float, int]] = field(default_factory=list)
    boards: list[tuple[float, float, float]] = field(default_factory=list)


def run(
    scenario: Scenario, progress: Callable[[float], None] | None = None, workers: int | None = None
) -> Trace:
    """Run a scenario; the answer does not depend on `workers` (threads, all cores unless given)."""
    if all_behavioural(scenario):
        flight = fly_behavioural(_models(scenario), scenario.duration, progress)
        return _read(scenario, flight)
    return run_in_loop(scenario, progress, workers)


def run_in_loop(
    scenario: Scenario, progress: Callable[[float], None] | None = None, workers: int | None = None
) -> Trace:
    """Run a scenario, at whatever levels, by the general event loop."""
    with ThreadPoolExecutor(workers or os.cpu_count() or 1) as executor:
        loop = build(scenario, None if all_behavioural(scenario) else executor)
        log = _Log()
        while loop.time < scenario.duration:
            _note(log, loop, loop.step(scenario.duration))
            if progress is not None:
                progress(loop.time / scenario.duration)
    return _trace(scenario, log, np.array(log.boards), _counts(loop))


def _note(log: _Log, loop: Loop, done: Round) -> None:
    amplitude = float(done.outputs["vocalization"].voltage[-1, 0])
    log.boards.append((done.stop, float(done.outputs["centroid"].voltage[-1, 0]), amplitude))
    for part, port, time in done.events:
        if part == "vocalization":
            log.calls.append((time, amplitude))
        elif "high_threshold" in {part, port}:
            log.pulses.append(time)
        elif "onset" in {part, port}:
            log.echoes.append(time)
        elif part.startswith("neuron"):
            log.spikes.append((time, _index(part)))
        elif part == "chip":
            log.spikes.append((time, _index(port)))


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


def build(scenario: Scenario, executor: Executor | None = None) -> Loop:
    """All parts at rest, wired as in Figure 7."""
    silicon = Silicon(temperature_c=scenario.temperature_c, die=scenario.die)
    parts: dict[str, Part[Any]] = {
        **_chip(scenario, silicon),
        "centroid": _centroid(scenario, silicon),
        "vocalization": _vocalization(scenario, silicon),
        **_hearing(scenario, silicon),
    }
    if scenario.isolation:
        parts["isolation"] = _isolation(scenario, silicon)
    if scenario.amplitude_law == "d4":
        parts["amplitude_centroid"] = _centroid(scenario, silicon, _fourth_power(silicon))
    horizon = BEHAVIOURAL_HORIZON if all_behavioural(scenario) else HORIZON
    loop = Loop(parts, _event_wires(parts), _analog_wires(parts), horizon, executor)
    oscillator = parts["vocalization"]
    if isinstance(oscillator, Cell):
        rising = (np.array([0.0, 1e-6]), np.array([0.0, silicon.process.v_dd]))
        loop.states["vocalization"] = oscillator.drive(loop.states["vocalization"], {"enable": rising})
    return loop


def all_behavioural(scenario: Scenario) -> bool:
    """Whether every box is a model."""
    return scenario.level == "behavioural" and not scenario.transistors


def _models(scenario: Scenario) -> Models:
    """The boxes of a run in which every one is a model."""
    silicon = Silicon(temperature_c=scenario.temperature_c, die=scenario.die)
    noise = silicon_noise(scenario.silicon_noise, scenario.seed)
    fourth = _fourth_power(silicon) if scenario.amplitude_law == "d4" else None
    return Models(
        chip=RangingChip(silicon, noise=noise),
        proximity=CentroidModel(silicon),
        amplitude=None if fourth is None else CentroidModel(silicon, fourth),
        vocalization=VocalizationModel(silicon, noise=noise),
        hearing=_heard(scenario, silicon),
        isolation=IsolationModel(silicon) if scenario.isolation else None,
    )


def _fourth_power(silicon: Silicon) -> tuple[float, ...]:
    """Entries of the second board's table, V."""
    law = vocalization_controller.amplitude_law(vocalization_controller.Params(), silicon.process.v_dd)
    return centroid_board.fourth_power_lookup(ranging_chip.BEST_DELAYS, law).voltages


def _chip(scenario: Scenario, silicon: Silicon) -> dict[str, Part[Any]]:
    if scenario.level_of("chip") == "behavioural":
        return {"chip": RangingChip(silicon, noise=silicon_noise(scenario.silicon_noise, scenario.seed))}
    if scenario.silicon_noise != "off":
        raise ParameterError(
            f"approach.silicon_noise: {scenario.silicon_noise}, must be off for a chip at transistor level;"
            " take the behavioural one"
        )
    chip = ranging_chip.build()
    held = {"v_ex_max": 4.301} if scenario.isolation else {}
    parts: dict[str, Part[Any]] = {}
    for k in range(ranging_chip.NEURONS):
        circuit, place = circuit_at(chip, (("neuron", (k,)),))
        there = replace(silicon, place=place)
        parts[f"neuron[{k}]"] = Cell(circuit, there, held=held, rtol=CHIP_RTOL)
    return parts


def _centroid(scenario: Scenario, silicon: Silicon, lookup: tuple[float, ...] | None = None) -> Part[Any]:
    if scenario.level_of("centroid") == "behavioural":
        return CentroidModel(silicon, lookup)
    board = centroid_board.build(centroid_board.Params())
    chosen = board if lookup is None else rebias(board, {"lookup": lookup})
    return Cell(chosen, silicon, ("proximity",), rtol=BOARD_RTOL)


def _vocalization(scenario: Scenario, silicon: Silicon) -> Part[Any]:
    if scenario.level_of("vocalization") == "behavioural":
        noise = silicon_noise(scenario.silicon_noise, scenario.seed)
        return VocalizationModel(silicon, noise=noise)
    board = vocalization_controller.build(vocalization_controller.Params())
    held = {"proximity": 0.0, "amplitude_control": 0.0, "enable": 0.0}
    return Cell(board, silicon, ("amplitude",), held=held, rtol=BOARD_RTOL)


def _hearing(scenario: Scenario, silicon: Silicon) -> dict[str, Part[Any]]:
    """Microphone to spikes: one model, or the ear, the envelope detector and both neurons."""
    if scenario.level_of("hearing") == "behavioural":
        return {"hearing": _heard(scenario, silicon)}
    microphone = _microphone(scenario)
    detector = envelope_detector.build(envelope_detector.Params())
    rest = {"microphone": microphone.mid_supply}
    ear = Cell(detector, silicon, ("envelope",), {"microphone": SAMPLE_RATE}, rest, BOARD_RTOL)
    parts: dict[str, Part[Any]] = {"ear": Ear(microphone, scenario.targets), "envelope": ear}
    silence = {"envelope": float(ear.voltages(ear.begin())[0])}
    for name, block in (("onset", onset_neuron), ("high_threshold", high_threshold_neuron)):
        parts[name] = Cell(block.build(block.Params()), silicon, held=silence, rtol=CHIP_RTOL)
    return parts


def _heard(scenario: Scenario, silicon: Silicon) -> Hearing:
    noise = silicon_noise(scenario.silicon_noise, scenario.seed)
    return Hearing(_microphone(scenario), scenario.targets, hearing_on(silicon, noise=noise))


def _microphone(scenario: Scenario) -> Microphone:
    return Microphone(noise_rms=scenario.noise_rms, seed=scenario.seed, air=air_of(scenario))


def _isolation(scenario: Scenario, silicon: Silicon) -> Part[Any]:
    if scenario.level_of("isolation") == "behavioural":
        return IsolationModel(silicon)
    latch = first_target_isolation.build(first_target_isolation.Params())
    start = first_target_isolation.rest(silicon.process.v_dd)
    return Cell(latch, silicon, ("v_ex_max",), rtol=BOARD_RTOL, start=start)


def _event_wires(parts: dict[str, Part[Any]]) -> list[EventWire]:
    model = "hearing" in parts
    pulse = ("hearing", "high_threshold") if model else ("high_threshold", "spike")
    onset = ("hearing", "onset") if model else ("onset", "spike")
    wires = [EventWire("vocalization", "call", "hearing" if model else "ear", "call")]
    boards = [n for n in ("centroid", "amplitude_centroid", "isolation") if n in parts]
    listeners = ["chip"] if "chip" in parts else [f"neuron[{k}]" for k in range(ranging_chip.NEURONS)]
    for name in listeners:
        wires += [EventWire(*pulse, name, "call"), EventWire(*onset, name, "echo")]
    for k in range(ranging_chip.NEURONS):
        source = ("chip", f"spike[{k}]") if "chip" in parts else (f"neuron[{k}]", "spike")
        wires += [EventWire(*source, board, f"spike[{k}]") for board in boards]
    if "isolation" in parts:
        wires.append(EventWire(*pulse, "isolation", "call"))
    return wires


def _analog_wires(parts: dict[str, Part[Any]]) -> list[AnalogWire]:
    control = "amplitude_centroid" if "amplitude_centroid" in parts else "centroid"
    wires = [
        AnalogWire("centroid", "proximity", "vocalization", "proximity"),
        AnalogWire(control, "proximity", "vocalization", "amplitude_control"),
    ]
    if "hearing" in parts:
        wires.append(AnalogWire("vocalization", "amplitude", "hearing", "amplitude"))
    else:
        wires += [
            AnalogWire("vocalization", "amplitude", "ear", "amplitude"),
            AnalogWire("ear", "microphone", "envelope", "microphone", 0.0),
            AnalogWire("envelope", "envelope", "onset", "envelope", ENVELOPE_TOLERANCE),
            AnalogWire("envelope", "envelope", "high_threshold", "envelope", ENVELOPE_TOLERANCE),
        ]
    if "isolation" in parts:
        targets = [n for n in parts if n == "chip" or n.startswith("neuron")]
        wires += [AnalogWire("isolation", "v_ex_max", name, "v_ex_max") for name in targets]
    return wires


def circuits() -> tuple[Circuit, ...]:
    """What the system is made of."""
    blocks = (
        centroid_board, vocalization_controller, envelope_detector, onset_neuron, high_threshold_neuron,
        first_target_isolation,
    )  # fmt: skip
    return (ranging_chip.build(), *(block.build() for block in blocks))


SYSTEM = System(
    name="approach",
    summary="bat-like sonar that closes in on a moving target, at transistor or behavioural level",
    about="A bat's sonar closes in on targets (Cheely & Horiuchi 2003).",
    success=SUCCESS,
    kind=Scenario,
    run=run,
    account=account,
    numbers=summarise,
    draw=draw,
    metrics=metrics_with(SUMMARY),
    study_metrics=("held_fraction", "range_error_mean_m"),
    study=lambda _: {"duration": STUDY_DURATION},
    document=document,
    title=title,
    before=lambda trace: [describe(target) for target in trace.scenario.targets],
    circuits=circuits,
)
