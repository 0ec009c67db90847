"""Measurement of the vocalization controller's record, and of its model's errors on other dies.

| quantity | measured as |
|---|---|
| base_Hz, slope_Hz_per_V, dead_time_s | intervals at constant proximity p: `1 / (base + slope p) + dead` |
| first_phase | first call after enabling: `(1 + first) / (base + slope p)` |
| amplitude_V, amplitude_slope | amplitude against its control voltage: a straight line |
| mirror | ln base and ln slope over the mirror's differences of V_T0 and beta, fitted to dies |

Over temperature and shared threshold shift. Then the model meets other dies: call times under
ramps of the proximity voltage.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TypeVar

import numpy as np

from chips.boards.vocalization.model import VocalizationModel, circuits, mirror_mismatch
from chips.cell import Cell
from chips.measured.held_out import every_silicon
from chips.measured.table_record import TEMPERATURES, Quantities, measure_over, shifts
from chips.model import plain_model
from chips.part import Part
from chips.record import Record, Table
from circuits.arrays import F64
from circuits.blocks.sonar import vocalization_controller
from circuits.catalogue import later
from circuits.devices.source import Polyline
from circuits.silicon.die import Die
from circuits.silicon.process import Process
from circuits.silicon.silicon import Silicon

optimise = later("scipy.optimize")

S = TypeVar("S")

RTOL = 1e-4
SHIFTS = shifts(7)  # V
PROXIMITY = np.linspace(0.0, 3.0, 5)  # V
MIRROR_DIES = tuple(range(12))
LONGEST = 0.7  # s, within which three calls come at 0 V
RAMP = 0.6  # s, length of a held-out ramp
QUANTITIES = ("base_Hz", "slope_Hz_per_V", "dead_time_s", "first_phase", "amplitude_V", "amplitude_slope")


def measure(process: Process) -> Record:
    """Measure the record in a process without its errors; it takes half a minute on one core."""
    mirror = np.array([_mirror(process, t) for t in TEMPERATURES])
    record = measure_over(_at, circuits(), SHIFTS, {}, process)
    return record.extended({"mirror": Table(("temperature", "rate", "difference"), mirror)})


def held_out_errors(process: Process) -> dict[str, float]:
    """Return the largest errors on dies that were not measured, under random ramps of the proximity voltage.

    They are of a call's interval, relative, and of its amplitude, V.
    """
    interval, amplitude = [], []
    for die, silicon in every_silicon(process):
        ramp = random_ramp(np.random.default_rng(die))
        one, other = circuit_calls(silicon, ramp), model_calls(silicon, ramp)
        n = min(len(one), len(other))
        spans = np.diff(one[:n, 0], prepend=0.0), np.diff(other[:n, 0], prepend=0.0)
        interval.append(np.abs(spans[1] / spans[0] - 1.0).max())
        amplitude.append(np.abs(one[:n, 1] - other[:n, 1]).max())
    return {"interval_max": float(max(interval)), "amplitude_max_V": float(max(amplitude))}


def random_ramp(rng: np.random.Generator) -> Polyline:
    """Return a proximity voltage of straight pieces between 0 and 3 V: times (s) and voltages (V)."""
    return np.linspace(0.0, RAMP, 7), rng.uniform(0.0, 3.0, 7)


def circuit_calls(silicon: Silicon, proximity: Polyline) -> F64:
    """Return the calls of the circuit, enabled at 0 s: times (s) and amplitudes (V), float64[calls, 2]."""
    cell = _cell(silicon)
    state = cell.begin()
    enable = np.array([0.0, 1e-6]), np.array([0.0, silicon.process.v_dd])
    lines = {"enable": enable, "proximity": proximity, "amplitude_control": proximity}
    return _calls(cell, cell.drive(state, lines), {}, float(proximity[0][-1]))


def model_calls(silicon: Silicon, proximity: Polyline) -> F64:
    """Return the calls of the model, as `circuit_calls` does those of the circuit."""
    model = VocalizationModel(silicon)
    lines = {"proximity": proximity, "amplitude_control": proximity}
    return _calls(model, model.begin(), lines, float(proximity[0][-1]))


def _calls(part: Part[S], state: S, lines: Mapping[str, Polyline], until: float) -> F64:
    """Calls of either level up to `until` (s), float64[calls, 2]: time (s) and amplitude (V)."""
    found, reached = [], 0.0
    while reached < until:
        state, reached, output = part.advance(state, until, (), lines)
        found += [(time, float(output.voltage[-1, 0])) for _, time in output.events]
    return np.array(found).reshape(-1, 2)


def _cell(silicon: Silicon) -> Cell:
    held = {"proximity": 0.0, "amplitude_control": 0.0, "enable": 0.0}
    return Cell(vocalization_controller.build(), silicon, ("amplitude",), held=held, rtol=RTOL)


def _at(silicon: Silicon) -> Quantities:
    interval, first, amplitude = [], [], []
    for proximity in PROXIMITY:
        calls = circuit_calls(silicon, (np.array([0.0, LONGEST]), np.full(2, proximity)))[:3]
        first.append(calls[0, 0])
        interval.append(calls[2, 0] - calls[1, 0])
        amplitude.append(calls[1, 1])
    seen = np.array(interval)

    def misfit(x: F64) -> F64:
        return np.asarray((1.0 / (x[0] + x[1] * PROXIMITY) + 1e-3 * x[2]) / seen - 1.0)

    base, slope, dead = optimise.least_squares(misfit, (5.0, 8.0, 0.4), x_scale=(1.0, 1.0, 0.1), xtol=1e-12).x
    lacking = np.array(first) * (base + slope * PROXIMITY) - 1.0
    gain, start = np.polyfit(PROXIMITY, amplitude, 1)
    return dict(zip(QUANTITIES, (base, slope, 1e-3 * dead, float(lacking.mean()), start, gain), strict=True))


def _mirror(process: Process, temperature: float) -> F64:
    """Derivatives of ln base and ln slope by the mirror's differences, float64[2, 2], 1/V and 1."""
    nominal = _at(Silicon(process, temperature))
    differences, rates = [], []
    for die in MIRROR_DIES:
        silicon = Silicon(process, temperature, Die("0", die, process=False))
        found = _at(silicon)
        differences.append(mirror_mismatch(silicon))
        rates.append([math.log(float(found[n]) / float(nominal[n])) for n in QUANTITIES[:2]])
    return np.asarray(np.linalg.lstsq(np.array(differences), np.array(rates), rcond=None)[0].T)


MODEL = plain_model("vocalization-controller", circuits, measure, held_out_errors, VocalizationModel)
