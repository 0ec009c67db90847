"""Measurement of the hearing's record from microphone to spikes, and of its model's errors.

| quantity | measured as |
|---|---|
| threshold_V | smallest peak at the microphone of a lone sound that makes a spike, bisected |
| latency_s | from a lone sound's onset to its spike, over peak / threshold |
| recovery_s | shortest gap between two sounds' onsets at which the second fires, over both peaks, bisected |
| rest_margin_V | of the onset neuron, see `chips.hearing.mismatch_measure`, as are the gradients |

Over temperature and shared threshold shift; thresholds and rest margin also by device. Then the model meets
other dies: trains of sounds of random peaks.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence

import numpy as np

from chips.cell import Cell
from chips.hearing.kernel import SOUND_DURATION
from chips.hearing.mismatch import PARAMETERS
from chips.hearing.mismatch_measure import (
    REST_SHIFTS,
    gradients,
    rest_bends,
    rest_margins,
    threshold_errors,
)
from chips.hearing.model import NEURONS, Deafened, HearingState, circuits, hear, hearing_on
from chips.measured.held_out import every_silicon, rms_and_max
from chips.measured.search import narrowed_by_share
from chips.measured.table_record import Quantities, measure_over, shifts
from chips.model import plain_model
from chips.polyline import thin
from chips.record import Axis, Record, Table
from circuits.arrays import F64
from circuits.blocks.sonar import envelope_detector
from circuits.circuit import Circuit
from circuits.devices import Source
from circuits.devices.source import Constant, Polyline
from circuits.silicon.process import Process
from circuits.silicon.silicon import Silicon
from circuits.solver.transient import simulate
from circuits.testbench import Testbench

Sound = tuple[float, float]  # onset, s, and peak at the microphone, V

RTOL, NEURON_RTOL = 1e-3, 3e-4
SHIFTS = shifts(3)  # V
TOLERANCE = 1e-3  # V, thinning of the envelope
START = 0.5e-3  # s, onset of the first sound
LOUDEST = 12.0  # V: the call at full scale, clipped
BRACKET = {"onset": (2e-3, 0.2), "high_threshold": (0.5, 2.4)}  # V, within which a threshold lies
RATIOS = {
    "onset": 1.0 + np.geomspace(0.01, 400.0, 30),
    "high_threshold": 1.0 + np.geomspace(0.01, 8.0, 16),
}
PEAKS = {"onset": np.geomspace(0.05, LOUDEST, 5), "high_threshold": np.array([1.8, 4.0, LOUDEST])}
GAPS = (0.2e-3, 15e-3)  # s, within which a recovery lies
RESOLUTION = 0.02  # of a bisected quantity


def measure(process: Process) -> Record:
    """Measure the record in a process without its errors; it takes about seven minutes on one core."""
    axes: dict[str, tuple[str, ...]] = {}
    for name in NEURONS:
        axes[f"{name}_latency_s"] = (f"{name}_ratio",)
        axes[f"{name}_recovery_s"] = (f"{name}_peak_V", f"{name}_second_peak_V")
    known = {f"{n}_ratio": RATIOS[n] for n in NEURONS} | {f"{n}_peak_V": PEAKS[n] for n in NEURONS}
    places: dict[str, Axis] = {name: tuple(values.tolist()) for name, values in known.items()}
    places |= {"rest_shift": REST_SHIFTS, "mismatch": PARAMETERS}
    tables = {name: Table(("temperature", "mismatch"), values) for name, values in gradients(process).items()}
    tables["onset_rest_margin_V"] = Table(("temperature", "polarity", "rest_shift"), rest_margins(process))
    tables["onset_rest_margin_bend"] = Table(("temperature",), rest_bends(process))
    return measure_over(_at, circuits(), SHIFTS, axes, process).extended(tables, places)


class Ears:
    """The three circuits of the hearing at transistor level on a silicon."""

    def __init__(self, silicon: Silicon) -> None:
        """Prepare the circuits for the solver and find their rest."""
        self.silicon = silicon
        self._detector, onset, high = circuits()
        envelope = self._envelope((), 1e-4)
        self._rest = float(envelope[1][0])
        self.cells = {n: self._cell(c) for n, c in zip(NEURONS, (onset, high), strict=True)}

    def spikes(self, sounds: Sequence[Sound], names: Sequence[str] = NEURONS) -> dict[str, list[float]]:
        """Return the spikes (s) of the neurons `names` under sounds.

        The run ends 4 ms after the last onset.
        """
        stop = max(t for t, _ in sounds) + 4e-3
        line = thin(*self._envelope(sounds, stop), TOLERANCE)
        found: dict[str, list[float]] = {n: [] for n in names}
        for name in names:
            cell = self.cells[name]
            state = cell.drive(cell.begin(), {"envelope": line})
            reached = 0.0
            while reached < stop:
                state, reached, output = cell.advance(state, stop)
                found[name] += [time for _, time in output.events]
        return found

    def _cell(self, circuit: Circuit) -> Cell:
        return Cell(circuit, self.silicon, held={"envelope": self._rest}, rtol=NEURON_RTOL)

    def _envelope(self, sounds: Sequence[Sound], stop: float) -> Polyline:
        v_dd = self.silicon.process.v_dd
        bursts = tuple((time, SOUND_DURATION, peak) for time, peak in sounds)
        wave = envelope_detector.tone_bursts(bursts, stop, 0.5 * v_dd, v_dd)
        sources = (Source("vdd", "vdd", Constant(v_dd)), Source("microphone", "microphone", wave))
        bench = Testbench("envelope detector", self._detector, sources, stop)
        result = simulate(bench, self.silicon, rtol=RTOL, record=("envelope",))
        return result.time, result["envelope"]


def random_sounds(rng: np.random.Generator) -> list[Sound]:
    """Return five calls of random peaks with two echoes each, as a flight has them; none overlap."""
    sounds: list[Sound] = []
    for k in range(5):
        call = START + 40e-3 * k + rng.uniform(0.0, 1e-3)
        volts = float(rng.uniform(0.9, 4.8))
        near = float(rng.uniform(2.2e-3, 12e-3))
        far = near + float(rng.uniform(1.2e-3, 10e-3))
        sounds.append((call, 2.4 * volts))
        sounds += [(call + d, 0.2304 * volts * (5.8e-3 / d) ** 2) for d in (near, far)]
    return sounds


def model_spikes(silicon: Silicon, sounds: Sequence[Sound]) -> tuple[dict[str, list[float]], int]:
    """Return the model's spikes (s) by neuron, and how many sounds it left undecided."""
    state = hear(hearing_on(silicon), HearingState(), sounds)
    return {n: [t for t, name in state.due if name == n] for n in NEURONS}, state.undecided


def held_out_errors(process: Process) -> dict[str, float]:
    """Return errors of spikes and thresholds on dies that were not measured, deaf ones included."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", Deafened)
        return {**_spike_errors(process), **threshold_errors(every_silicon(process))}


def _spike_errors(process: Process) -> dict[str, float]:
    """Share of spikes on one level only, and error (s) of the times of the others."""
    alone, matched, late, undecided, heard = 0, 0, [], 0, 0
    for die, silicon in every_silicon(process):
        sounds = random_sounds(np.random.default_rng(die))
        one = Ears(silicon).spikes(sounds)
        other, unsure = model_spikes(silicon, sounds)
        undecided, heard = undecided + unsure, heard + len(sounds)
        for name in NEURONS:
            pairs, single = paired(one[name], other[name])
            alone, matched = alone + single, matched + len(pairs)
            late += [b - a for a, b in pairs]
    shares = {"unmatched_share": alone / (matched + alone), "undecided_share": undecided / heard}
    return shares | rms_and_max("latency", late, "s")


def paired(one: Sequence[float], other: Sequence[float]) -> tuple[list[tuple[float, float]], int]:
    """Pair spikes within 0.5 ms of each other; return the pairs (s), and how many spikes have no partner."""
    left = list(other)
    pairs = []
    for time in one:
        near = min(left, key=lambda t: abs(t - time), default=None)
        if near is not None and abs(near - time) < 0.5e-3:
            pairs.append((time, near))
            left.remove(near)
    return pairs, len(one) + len(other) - 2 * len(pairs)


def _at(silicon: Silicon) -> Quantities:
    ears = Ears(silicon)
    found: dict[str, float | F64] = {}
    for name in NEURONS:
        threshold = _threshold(ears, name)
        found[f"{name}_threshold_V"] = threshold
        latency = [_latency(ears, name, threshold * ratio) for ratio in RATIOS[name]]
        found[f"{name}_latency_s"] = np.array(latency)
        peaks = PEAKS[name]
        found[f"{name}_recovery_s"] = np.array([[_recovery(ears, name, a, b) for b in peaks] for a in peaks])
    return found


def _threshold(ears: Ears, name: str) -> float:

    def heard(peak: float) -> bool:
        return bool(ears.spikes([(START, peak)], (name,))[name])

    return narrowed_by_share(heard, *BRACKET[name], 0.05 * RESOLUTION)[1]


def _latency(ears: Ears, name: str, peak: float) -> float:
    return ears.spikes([(START, peak)], (name,))[name][0] - START


def _recovery(ears: Ears, name: str, first: float, second: float) -> float:
    """Shortest gap (s) at which the second of two sounds adds a spike."""

    def both(gap: float) -> bool:
        return len(ears.spikes([(START, first), (START + gap, second)], (name,))[name]) > 1

    return narrowed_by_share(both, *GAPS, RESOLUTION)[1]


MODEL = plain_model("hearing", circuits, measure, held_out_errors, hearing_on)
