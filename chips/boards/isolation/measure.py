"""Measurement of the first-target isolation's record, and of its model's errors on other dies.

| quantity | measured as |
|---|---|
| open_V, isolated_V | output at rest, and 50 us after a spike |
| set_delay_s, reset_delay_s | from a spike's or a call's event to the output's passage half-way between |
| held_delay_s | the same from a call's event, of a spike that outlasts the call |
| tie_s | smallest lag of a spike behind a call after which the array ends isolated, bisected |

An event is the beginning of its pulse's edge. Over temperature and shared threshold shift. Then the model
meets other dies: random trains of spikes and calls, a third of them within a pulse of the one before.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol, TypeVar

import numpy as np

from chips.boards.isolation.model import IsolationModel, circuits
from chips.cell import Cell
from chips.measured.held_out import every_silicon, rms_and_max
from chips.measured.search import narrowed
from chips.measured.table_record import Quantities, measure_over, shifts
from chips.model import plain_model
from chips.part import Event, Output
from chips.record import Record
from circuits.arrays import F64
from circuits.blocks.sonar import first_target_isolation
from circuits.blocks.sonar.centroid_board import NEURONS
from circuits.devices.source import Polyline
from circuits.event import WIDTH
from circuits.silicon.process import Process
from circuits.silicon.silicon import Silicon

S = TypeVar("S")

RTOL = 1e-4
SHIFTS = shifts(5)  # V
START = 1e-6  # s, of the first event
SETTLE = 50e-6  # s, from an event to the next one that must find the board at rest
INSIDE = 0.5 * WIDTH  # s, lag of the spike that outlasts a call
TIES = -2e-6, 2e-6  # s, within which the tie lies
RESOLUTION = 1e-9  # s, of the tie
TRAIN = 40  # events of a held-out train
SAME = 1e-6  # s, within which changes on both levels are one and the same


class _Board(Protocol[S]):
    """A board at either level."""

    def advance(self, state: S, until: float, events: Sequence[Event] = ()) -> tuple[S, float, Output]:
        """Advance to `until` (s)."""


def measure(process: Process) -> Record:
    """Measure the record in a process without its errors; it takes half a minute on one core."""
    return measure_over(_at, circuits(), SHIFTS, {}, process)


def held_out_errors(process: Process) -> dict[str, float]:
    """Return the model's errors on dies that were not measured, under random trains.

    They are errors of the output's changes (s) and levels (V), and the shares of changes that only one level
    of description has, and of events that the model leaves undecided.
    """
    late: list[float] = []
    off: list[float] = []
    tie: list[float] = []
    alone, undecided, events = 0, 0, 0
    for die, silicon in every_silicon(process):
        train = random_train(np.random.default_rng(die))
        one = circuit_output(silicon, train)
        other, unsure = model_output(silicon, train)
        found = compare(one, other)
        late, off, alone = late + found[0], off + found[1], alone + found[2]
        undecided, events = undecided + unsure, events + len(train)
        tie.append(IsolationModel(silicon).tie - _tie(_cell(silicon), _half(one[1])))
    return rms_and_max("change", late, "s") | {
        "level_max_V": float(np.abs(off).max()),
        "tie_max_s": float(np.abs(tie).max()),
        "unmatched_share": alone / (len(late) + alone),
        "undecided_share": undecided / events,
    }


def random_train(rng: np.random.Generator) -> list[Event]:
    """Return spikes of random neurons and calls, a third of them within 12 us of the one before, in order."""
    near = rng.random(TRAIN) < 1.0 / 3.0
    gaps = np.where(near, rng.uniform(0.0, 12e-6, TRAIN), rng.uniform(25e-6, SETTLE, TRAIN))
    ports = [f"spike[{rng.integers(0, NEURONS)}]" if spikes else "call" for spikes in rng.random(TRAIN) < 0.6]
    return list(zip(ports, (START + np.cumsum(gaps)).tolist(), strict=True))


def circuit_output(silicon: Silicon, train: Sequence[Event]) -> Polyline:
    """Return the circuit's output under a train of events: times (s) and voltages (V)."""
    cell = _cell(silicon)
    return _output(cell, cell.begin(), train)[0]


def model_output(silicon: Silicon, train: Sequence[Event]) -> tuple[Polyline, int]:
    """Return the model's output under a train, likewise, and how many events it left undecided."""
    model = IsolationModel(silicon)
    line, state = _output(model, model.begin(), train)
    return line, state.undecided


def _output(part: _Board[S], state: S, train: Sequence[Event]) -> tuple[Polyline, S]:
    """Output of either level, told of each event when it comes; and its last state."""
    time, voltage = [], []
    for (port, moment), stop in zip(train, [*(t for _, t in train[1:]), train[-1][1] + SETTLE], strict=True):
        for until, events in ((moment, ()), (stop, ((port, moment),))):
            state, _, line = part.advance(state, until, events)
            time.append(line.time)
            voltage.append(line.voltage[:, 0])
    return (np.concatenate(time), np.concatenate(voltage)), state


def compare(one: Polyline, other: Polyline) -> tuple[list[float], list[float], int]:
    """Compare two outputs: return errors of changes (s) and of settled levels (V), and unmatched changes."""
    threshold = _half(other[1])
    left = crossings(*other, threshold)
    late, alone = [], 0
    for time in crossings(*one, threshold):
        near = min(left, key=lambda t: abs(t - time), default=np.inf)
        if abs(near - time) < SAME:
            late.append(near - time)
            left.remove(near)
        else:
            alone += 1
    settled = np.arange(one[0][0], one[0][-1], SAME)
    both = np.array([np.interp(settled, *line) for line in (one, other)])
    moving = np.array([np.ptp(both[1, max(k - 20, 0) : k + 1]) > 0.0 for k in range(settled.size)])
    same = ~moving & ((both[0] > threshold) == (both[1] > threshold))
    return late, (both[1] - both[0])[same].tolist(), alone + len(left)


def crossings(time: F64, voltage: F64, threshold: float) -> list[float]:
    """Return the times (s) at which a polyline passes a voltage (V), in either direction."""
    above = voltage > threshold
    k = np.flatnonzero(above[1:] != above[:-1])
    share = (threshold - voltage[k]) / (voltage[k + 1] - voltage[k])
    found: list[float] = (time[k] + share * (time[k + 1] - time[k])).tolist()
    return found


def _half(voltage: F64) -> float:
    return 0.5 * float(voltage.min() + voltage.max())


def _cell(silicon: Silicon) -> Cell:
    start = first_target_isolation.rest(silicon.process.v_dd)
    return Cell(first_target_isolation.build(), silicon, ("v_ex_max",), rtol=RTOL, start=start)


def _at(silicon: Silicon) -> Quantities:
    cell = _cell(silicon)
    spike, call = START, START + SETTLE
    rest = cell.begin()
    low = float(cell.voltages(rest)[0])
    isolated, _, _ = cell.advance(rest, call, [("spike[0]", spike)])
    high = float(cell.voltages(isolated)[0])

    half = 0.5 * (low + high)
    set_alone, reset = _changes(cell, -0.5 * SETTLE, half)
    return {
        "open_V": low,
        "isolated_V": high,
        "set_delay_s": set_alone + 0.5 * SETTLE,
        "reset_delay_s": reset,
        "held_delay_s": _changes(cell, INSIDE, half)[0],
        "tie_s": _tie(cell, half),
    }


def _tie(cell: Cell, half: float) -> float:
    """Lag (s) of a spike behind a call from which on the array ends isolated."""
    return 0.5 * sum(narrowed(lambda lag: len(_changes(cell, lag, half)) % 2 == 1, *TIES, RESOLUTION))


def _changes(cell: Cell, lag: float, half: float) -> list[float]:
    """Changes after a call with a spike `lag` (s) behind it, relative to the call."""
    events = sorted([("call", SETTLE), ("spike[0]", SETTLE + lag)], key=lambda e: e[1])
    _, _, output = cell.advance(cell.begin(), 3.0 * SETTLE, events)
    return [t - SETTLE for t in crossings(output.time, output.voltage[:, 0], half)]


MODEL = plain_model("first-target-isolation", circuits, measure, held_out_errors, IsolationModel)
