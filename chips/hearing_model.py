"""Hearing at behavioural level: sounds in, spikes of the onset and of the high-threshold neuron out.

Stands for envelope detector, onset neuron and high-threshold neuron. A sound is a 1 ms tone with 0.2 ms
edges, its onset (s) and peak at the microphone before clipping (V). Equations in `chips.board_kernel`,
thresholds, latencies and recoveries from `chips.hearing_measurement`. Sounds that overlap add up with a phase
that is not known here: a sound that begins while another lasts is counted as undecided, and so is one within
5 % of a threshold or of a recovery. Noise is not modelled.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from chips.board_kernel import Hearing, hears
from chips.board_record import check_box, matching_record, on_silicon
from circuits.blocks import envelope_detector, high_threshold_neuron, onset_neuron
from circuits.circuit import Circuit
from circuits.silicon import Silicon

F64 = NDArray[np.float64]

SOUND_DURATION = 1e-3  # s, of the sounds that were measured
MEMORY = 20e-3  # s, longer than any recovery: what is kept of the past; ours
NEURONS = ("onset", "high_threshold")


@dataclass(frozen=True, slots=True)
class HearingState:
    """sounds: (onset s, peak V) of the past 20 ms and to come; due: (time s, neuron) of spikes to come."""

    sounds: tuple[tuple[float, float], ...] = ()
    due: tuple[tuple[float, str], ...] = ()
    undecided: int = 0


@dataclass(frozen=True, slots=True)
class HearingModel:
    """Both neurons' numbers."""

    onset: Hearing
    high_threshold: Hearing


def circuits() -> tuple[Circuit, ...]:
    """The circuits that the model stands for."""
    return envelope_detector.build(), onset_neuron.build(), high_threshold_neuron.build()


def hearing_on(silicon: Silicon, path: str = "hearing") -> HearingModel:
    """The model on `silicon`.

    Raises `ParameterError` outside the record and `DataError` where the record is stale.
    """
    check_box(path, silicon)
    data = matching_record("hearing", circuits(), silicon.process)
    return HearingModel(*(_neuron(data, name, silicon) for name in NEURONS))


def _neuron(data: xr.Dataset, name: str, silicon: Silicon) -> Hearing:
    threshold, latency, recovery = (
        on_silicon(data, f"{name}_{q}", silicon) for q in ("threshold_V", "latency_s", "recovery_s")
    )
    knots = np.log(np.asarray(data[f"{name}_ratio"].values))
    loudness = np.log(np.asarray(data[f"{name}_peak_V"].values))
    return Hearing(float(threshold), knots, latency, loudness, recovery)


def hear(model: HearingModel, state: HearingState, sounds: Sequence[tuple[float, float]]) -> HearingState:
    """Add sounds (onset s, peak V), none of which begins before those that are already known."""
    known, due, undecided = state.sounds, list(state.due), state.undecided
    for sound in sorted(sounds):
        known = (*(s for s in known if s[0] > sound[0] - MEMORY), sound)
        table = np.array(known)
        overlaps = any(
            sound[0] - onset < SOUND_DURATION and peak >= model.onset.threshold for onset, peak in known[:-1]
        )
        unsure = overlaps and sound[1] >= model.onset.threshold
        for name, numbers in zip(NEURONS, (model.onset, model.high_threshold), strict=True):
            time, near = hears(numbers, table, len(known))
            unsure = unsure or near
            if time < math.inf:
                due.append((float(time), name))
        undecided += unsure
    return HearingState(known, tuple(sorted(due)), undecided)
