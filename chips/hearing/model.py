"""Behavioural model of the hearing: sounds go in, spikes of two neurons come out.

Stands for envelope detector, onset neuron and high-threshold neuron. A sound is a 1 ms tone with 0.2 ms
edges, its onset (s) and peak at the microphone before clipping (V). Equations in `chips.hearing.kernel`,
thresholds, latencies and recoveries from `chips.hearing.measure`. Sounds that overlap add up with a phase
that is not known here: a sound that begins while another lasts is counted as undecided, and so is one within
5 % of a threshold or of a recovery. Noise of the devices moves thresholds from sound to sound
(`chips.hearing.noise`).

Local mismatch moves both thresholds. It also decides whether the resting onset neuron hears at all: on a die
whose rest margin is below zero no refractory ends at rest, and a loud sound, whose tail ends it, must come
before each weak one. That is not modelled: such a die is warned of with the instance path.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cache

import numpy as np

from chips.hearing.kernel import MEMORY, Hearing, hear_sound
from chips.hearing.mismatch import LEVEL, RATIO, deviations
from chips.hearing.noise import HearingNoise, hearing_noise, no_hearing_noise, threshold_factors
from chips.measured.table_record import (
    all_on_silicon,
    check_box,
    on_silicon,
    tables_of,
    temperature_weights,
)
from chips.noise import SiliconNoise
from chips.record import Record
from circuits.arrays import F64
from circuits.blocks.sonar import envelope_detector, high_threshold_neuron, onset_neuron
from circuits.circuit import Circuit
from circuits.silicon.silicon import Silicon

NEURONS = ("onset", "high_threshold")


class Deafened(UserWarning):
    """Warning of a die whose onset neuron does not hear at rest, or is too near to that to tell."""


@dataclass(frozen=True, slots=True)
class HearingState:
    """State of the hearing.

    sounds: onset (s) and peak (V) of those of the past 20 ms and to come; due: spikes to come in order, (time
    s, neuron); undecided: sounds that were too near to call; heard: how many sounds there were.
    """

    sounds: tuple[tuple[float, float], ...] = ()
    due: tuple[tuple[float, str], ...] = ()
    undecided: int = 0
    heard: int = 0


@dataclass(frozen=True, slots=True)
class HearingModel:
    """Both neurons of the hearing on a die, and their noise."""

    onset: Hearing
    high_threshold: Hearing
    noise: HearingNoise = field(default_factory=no_hearing_noise)


@cache
def circuits() -> tuple[Circuit, ...]:
    """Return the circuits that the model stands for: envelope detector, onset and high-threshold neuron."""
    return envelope_detector.build(), onset_neuron.build(), high_threshold_neuron.build()


def hearing_on(
    silicon: Silicon, path: str = "hearing", noise: SiliconNoise | None = None, v_level: float = LEVEL
) -> HearingModel:
    """Return the hearing on a silicon.

    path: named in warnings; noise: of its devices, none unless given; v_level: to which its board is
    trimmed, V.

    Raises `ParameterError` for silicon outside the record's box, and `DataError` where the record is of other
    circuits. Warns with `Deafened` of a die whose onset neuron does not hear at rest.
    """
    data = check_hearing(silicon, path)
    own = deviations(silicon, v_level)
    margin, unsure = _rest_margin(data, silicon, own), 2.0 * data.errors.get("rest_margin_rms_V", 0.0)
    if margin < unsure:
        warnings.warn(
            f"{path}.onset: rest margin {margin:.2g} V, must be > {unsure:.2g} V, else a loud sound must come"
            " before weak ones are heard; use the transistor level",
            Deafened,
            stacklevel=2,
        )
    onset, high = (_neuron(data, name, silicon, own) for name in NEURONS)
    return HearingModel(onset, high, hearing_noise(onset, high, silicon, noise))


def check_hearing(silicon: Silicon, path: str = "hearing") -> Record:
    """Return the record in force; raises `ParameterError` for silicon outside its box."""
    data = tables_of("hearing", circuits, silicon.process)
    check_box(path, silicon, data)
    return data


def rest_margin_on(silicon: Silicon, v_level: float = LEVEL) -> float:
    """Return by how much v_level may fall before the resting onset neuron is deaf, V, below 0 if it is."""
    data = tables_of("hearing", circuits, silicon.process)
    return _rest_margin(data, silicon, deviations(silicon, v_level))


def _rest_margin(data: Record, silicon: Silicon, own: F64) -> float:
    at = temperature_weights(data, silicon.temperature_c)
    shared = float(on_silicon(data, "onset_rest_margin_V", silicon, "rest_shift"))
    ratio = _by_mismatch(data, "onset_rest_margin", silicon, own * RATIO)
    bend = float(at @ data["onset_rest_margin_bend"])
    return shared + _by_mismatch(data, "onset_rest_margin", silicon, own) + 0.5 * bend * ratio**2


def _by_mismatch(data: Record, name: str, silicon: Silicon, own: F64) -> float:
    at = temperature_weights(data, silicon.temperature_c)
    return float(np.tensordot(at, data[f"{name}_gradient"], (0, 0)) @ own)


def _neuron(data: Record, name: str, silicon: Silicon, own: F64) -> Hearing:
    names = [f"{name}_{q}" for q in ("threshold_V", "latency_s", "recovery_s")]
    threshold, latency, recovery = all_on_silicon(data, names, silicon)
    threshold = threshold * math.exp(_by_mismatch(data, f"{name}_threshold", silicon, own))
    knots = np.log(data[f"{name}_ratio"])
    loudness = np.log(data[f"{name}_peak_V"])
    return Hearing(float(threshold), knots, latency, loudness, recovery)


def hear(model: HearingModel, state: HearingState, sounds: Sequence[tuple[float, float]]) -> HearingState:
    """Return the state with more sounds, (onset s, peak V), none earlier than those that are known."""
    known, due, undecided, heard = state.sounds, list(state.due), state.undecided, state.heard
    for sound in sorted(sounds):
        known = (*(s for s in known if s[0] > sound[0] - MEMORY), sound)
        both = model.onset, model.high_threshold
        by = threshold_factors(model.noise, heard, *(sound[1] / m.threshold for m in both))
        onset, high = (m._replace(threshold=m.threshold * x) for m, x in zip(both, by, strict=True))
        *times, unsure = hear_sound(onset, high, np.array(known), len(known))
        heard += 1
        due += [(float(t), name) for t, name in zip(times, NEURONS, strict=True) if t < math.inf]
        undecided += unsure
    return HearingState(known, tuple(sorted(due)), undecided, heard)
