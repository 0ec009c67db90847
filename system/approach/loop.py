"""The parts of an approach, and the wires between them, at transistor or behavioural level."""

from __future__ import annotations

from concurrent.futures import Executor
from dataclasses import replace
from typing import Any

import numpy as np

from chips.boards.centroid.model import CentroidModel
from chips.boards.isolation.model import IsolationModel
from chips.boards.vocalization.model import VocalizationModel
from chips.cell import Cell
from chips.hearing.model import hearing_on
from chips.part import Part
from chips.ranging import circuit as ranging_chip
from chips.ranging.calibration.found import delays_of, off_of, values_of
from chips.ranging.chip import RangingChip
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
from circuits.place import circuit_at
from circuits.silicon.silicon import Silicon
from system.approach.behavioural import Models
from system.approach.scenario import Scenario, air_of
from system.loop import AnalogWire, EventWire, Loop
from system.options.noise import device_noise
from system.worlds.sound.ear import SAMPLE_RATE, Ear
from system.worlds.sound.hearing import Hearing
from system.worlds.sound.microphone import Microphone

# Longest round, s; ours, a matter of speed only.
_HORIZON = 4e-3
_BEHAVIOURAL_HORIZON = 20e-3
ENVELOPE_TOLERANCE = 1e-3  # V, thinning of the envelope between detector and neurons; ours
# Ours: neuron 2's spikes come within 3 us of the converged ones. How far calls move when all tolerances are
# divided by ten is measured by benchmarks/approach.py.
CHIP_RTOL = 3e-4
BOARD_RTOL = 1e-3


def build(scenario: Scenario, executor: Executor | None = None) -> Loop:
    """Return the event loop with all parts at rest, wired as in Figure 7."""
    silicon = scenario.silicon_at(scenario.beginning_c)
    parts: dict[str, Part[Any]] = {
        **_chip(scenario, silicon),
        "centroid": _centroid(scenario, silicon, _linear(scenario)),
        "vocalization": _vocalization(scenario, silicon),
        **_hearing(scenario, silicon),
    }
    if scenario.isolation:
        parts["isolation"] = _isolation(scenario, silicon)
    if scenario.amplitude_law == "d4":
        parts["amplitude_centroid"] = _centroid(scenario, silicon, _fourth_power(scenario, silicon))
    horizon = _BEHAVIOURAL_HORIZON if all_behavioural(scenario) else _HORIZON
    events = _event_wires(parts, off_of(scenario.ranging_codes))
    loop = Loop(parts, events, _analog_wires(parts), horizon, executor)
    oscillator = parts["vocalization"]
    if isinstance(oscillator, Cell):
        rising = (np.array([0.0, 1e-6]), np.array([0.0, silicon.process.v_dd]))
        loop.states["vocalization"] = oscillator.drive(loop.states["vocalization"], {"enable": rising})
    return loop


def move(loop: Loop, scenario: Scenario, temperature_c: float) -> None:
    """Take chip and boards to another temperature, degC; their voltages stay, and so does the air's."""
    silicon = scenario.silicon_at(temperature_c)
    parts: dict[str, Part[Any]] = dict(loop.parts)
    for name, part in loop.parts.items():
        if isinstance(part, Cell):
            parts[name], loop.states[name] = part.moved(loop.states[name], temperature_c)
        elif isinstance(part, RangingChip):
            loop.states[name] = part.moved(loop.states[name], temperature_c)
        elif isinstance(part, CentroidModel):
            fourth = name == "amplitude_centroid"
            parts[name] = CentroidModel(
                silicon, _fourth_power(scenario, silicon) if fourth else _linear(scenario)
            )
        elif isinstance(part, VocalizationModel):
            parts[name] = _vocalization(scenario, silicon)
        elif isinstance(part, IsolationModel):
            parts[name] = _isolation(scenario, silicon)
        elif isinstance(part, Hearing):
            parts[name] = _heard(scenario, silicon)
    loop.parts = parts


def all_behavioural(scenario: Scenario) -> bool:
    """Whether every box of a scenario is a measured model."""
    return scenario.modelled


def models_of(scenario: Scenario, temperature_c: float) -> Models:
    """Return the models of a scenario in which every box is one, at a temperature, degC."""
    silicon = scenario.silicon_at(temperature_c)
    noise = device_noise(scenario)
    fourth = _fourth_power(scenario, silicon) if scenario.amplitude_law == "d4" else None
    codes = scenario.ranging_codes
    return Models(
        chip=RangingChip(silicon, noise=noise, bias_kind=scenario.bias_kind, codes=codes),
        off=off_of(codes),
        proximity=CentroidModel(silicon, _linear(scenario)),
        amplitude=None if fourth is None else CentroidModel(silicon, fourth),
        vocalization=VocalizationModel(silicon, noise=noise),
        hearing=_heard(scenario, silicon),
        isolation=_isolation_model(scenario, silicon) if scenario.isolation else None,
    )


def _linear(scenario: Scenario) -> tuple[float, ...] | None:
    """Entries of the table, V, where it is trimmed to the chip; else None, for the board's own."""
    codes, design = scenario.ranging_codes, ranging_chip.BEST_DELAYS
    return None if codes is None else centroid_board.lookup_at(delays_of(codes), design[0], design[-1])


def _fourth_power(scenario: Scenario, silicon: Silicon) -> tuple[float, ...]:
    """Entries of the second board's table, V."""
    law = vocalization_controller.amplitude_law(vocalization_controller.Params(), silicon.process.v_dd)
    return centroid_board.fourth_power_lookup(delays_of(scenario.ranging_codes), law).voltages


def _chip(scenario: Scenario, silicon: Silicon) -> dict[str, Part[Any]]:
    if scenario.level_of("chip") == "behavioural":
        noise = device_noise(scenario)
        codes = scenario.ranging_codes
        return {"chip": RangingChip(silicon, noise=noise, bias_kind=scenario.bias_kind, codes=codes)}
    chip = rebias(ranging_chip.build(), values_of(scenario.ranging_codes), scenario.bias_kind)
    held = {"v_ex_max": float(np.asarray(chip.bias("v_ex_max").value))} if scenario.isolation else {}
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
        noise = device_noise(scenario)
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
    onset = rebias(onset_neuron.build(onset_neuron.Params()), {"v_level": scenario.hearing_level})
    high = high_threshold_neuron.build(high_threshold_neuron.Params())
    for name, neuron in (("onset", onset), ("high_threshold", high)):
        parts[name] = Cell(neuron, silicon, held=silence, rtol=CHIP_RTOL)
    return parts


def _heard(scenario: Scenario, silicon: Silicon) -> Hearing:
    noise = device_noise(scenario)
    heard = hearing_on(silicon, noise=noise, v_level=scenario.hearing_level)
    return Hearing(_microphone(scenario), scenario.targets, heard)


def _microphone(scenario: Scenario) -> Microphone:
    return Microphone(noise_rms=scenario.noise_rms, seed=scenario.seed, air=air_of(scenario))


def _isolation(scenario: Scenario, silicon: Silicon) -> Part[Any]:
    if scenario.level_of("isolation") == "behavioural":
        return _isolation_model(scenario, silicon)
    latch = first_target_isolation.build(first_target_isolation.Params())
    volts = trimmed(scenario)
    latch = latch if volts is None else rebias(latch, {"v_ex_max_set": volts})
    start = first_target_isolation.rest(silicon.process.v_dd)
    return Cell(latch, silicon, ("v_ex_max",), rtol=BOARD_RTOL, start=start)


def _isolation_model(scenario: Scenario, silicon: Silicon) -> IsolationModel:
    return IsolationModel(silicon, v_ex_max=trimmed(scenario))


def trimmed(scenario: Scenario) -> float | None:
    """V_ex,max to which the board is trimmed for the chip, V; None for the board's own."""
    codes = scenario.ranging_codes
    return None if codes is None else codes.trims["v_ex_max"][0]


def _event_wires(parts: dict[str, Part[Any]], off: tuple[int, ...]) -> list[EventWire]:
    """Wires of events; `off`: neurons whose spikes reach nothing."""
    model = "hearing" in parts
    pulse = ("hearing", "high_threshold") if model else ("high_threshold", "spike")
    onset = ("hearing", "onset") if model else ("onset", "spike")
    wires = [EventWire("vocalization", "call", "hearing" if model else "ear", "call")]
    boards = [n for n in ("centroid", "amplitude_centroid", "isolation") if n in parts]
    listeners = ["chip"] if "chip" in parts else [f"neuron[{k}]" for k in range(ranging_chip.NEURONS)]
    for name in listeners:
        wires += [EventWire(*pulse, name, "call"), EventWire(*onset, name, "echo")]
    for k in sorted({*range(ranging_chip.NEURONS)} - {*off}):
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
    """Return the circuits that the system is made of."""
    blocks = (
        centroid_board, vocalization_controller, envelope_detector, onset_neuron, high_threshold_neuron,
        first_target_isolation,
    )  # fmt: skip
    return (ranging_chip.build(), *(block.build() for block in blocks))
