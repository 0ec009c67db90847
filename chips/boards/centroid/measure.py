"""Measurement of the centroid board's record with the transistor-level solver, and of its model's errors.

| quantity | measured as |
|---|---|
| log_far_default | ln of the hold node (V) at rest |
| offset_V | proximity voltage above the low-pass, well above ground |
| slew_time_s | rise of the follower 0.1 ms after the first neuron's spike, from rest |
| log_share | a spike of each neuron: `ln[(V_k - before) / (V_k - after)]`, mean from rest and from 3 V |
| leak_time_s | fall of the hold node over 1 s towards the far default, from 3 V |
| filter_time_s | rise of the low-pass over 40 ms after the hold node jumped, solved for its time |

Over temperature and shared threshold shift. Then the model meets other dies: the proximity voltage under
random trains. Local mismatch is left out: under these trains it moves the circuit's own proximity voltage by
0.4 mV at most (0.08 mV rms; dies A/1000 to A/1019 against the nominal one, 0, 27 and 60 degC). The look-up
voltages are ideal biases, the followers have no input pair, and a gate is a tenth of its resistor.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from chips.boards.centroid.model import CentroidModel, circuits
from chips.cell import Cell, CellState
from chips.measured.held_out import every_silicon, rms_and_max
from chips.measured.table_record import Quantities, measure_over, shifts
from chips.model import plain_model
from chips.part import Event
from chips.record import Record
from circuits.arrays import F64
from circuits.blocks.sonar import centroid_board
from circuits.catalogue import later
from circuits.silicon.process import Process
from circuits.silicon.silicon import Silicon

optimise = later("scipy.optimize")

RTOL = 1e-5
SHIFTS = shifts(7)  # V
FLOOR = 0.15  # V, smallest distance from an entry from which a spike's share is measured; ours
SETTLE = 30e-6  # s, after a spike
FALL = 1.0  # s, over which the leak is measured
SLEWING = 0.1e-3  # s, after which the slewing is measured
CAUGHT = 5e-3  # s, after which the follower has caught up
RISE = 40e-3  # s, after which the low-pass is measured
TRAIN = 0.4  # s, length of a held-out train
TRAIN_SPIKES = 60


def measure(process: Process) -> Record:
    """Measure the record in a process without its errors; it takes half a minute on one core."""
    return measure_over(_at, circuits(), SHIFTS, {"log_share": ("neuron",)}, process)


def held_out_errors(process: Process) -> dict[str, float]:
    """Return errors of the output voltage on dies that were not measured, under random trains of spikes."""
    difference = [
        train_error(s, random_train(np.random.default_rng(die))) for die, s in every_silicon(process)
    ]
    return rms_and_max("proximity", np.concatenate(difference), "V")


def random_train(rng: np.random.Generator) -> list[Event]:
    """Return spikes of random neurons in random volleys, in the order of their times; some overlap."""
    first = rng.uniform(0.0, 0.7 * TRAIN, TRAIN_SPIKES)
    close = first[rng.integers(0, TRAIN_SPIKES, TRAIN_SPIKES // 3)] + rng.uniform(0, 20e-6, TRAIN_SPIKES // 3)
    time = np.sort(np.concatenate([first, close]))
    return [(f"spike[{rng.integers(0, centroid_board.NEURONS)}]", float(t)) for t in time]


def train_error(silicon: Silicon, train: Sequence[Event]) -> F64:
    """Return the model's output voltage less that of the circuit, V, after every spike and at the end."""
    cell = Cell(centroid_board.build(), silicon, ("proximity",), rtol=RTOL)
    model = CentroidModel(silicon)
    one, other = cell.begin(), model.begin()
    found = []
    for (port, time), stop in zip(train, [*(t for _, t in train[1:]), TRAIN], strict=True):
        one, _, _ = cell.advance(one, time)
        one, _, wave = cell.advance(one, stop, [(port, time)])
        other, _, line = model.advance(other, time)
        other, _, line = model.advance(other, stop, [(port, time)])
        found.append(line.voltage[-1, 0] - wave.voltage[-1, 0])
    return np.array(found)


def _at(silicon: Silicon) -> Quantities:
    cell = Cell(centroid_board.build(), silicon, ("common", "proximity", "held", "filtered"), rtol=RTOL)
    rest = cell.begin()
    far, _, held, _ = cell.voltages(rest)
    begun, _, _ = cell.advance(rest, 1e-6)
    begun, _, _ = cell.advance(begun, 1e-6 + SLEWING, [("spike[0]", 1e-6)])
    v_dd = silicon.process.v_dd
    slew = SLEWING / math.log((v_dd - held) / (v_dd - cell.voltages(begun)[2]))
    high = rest
    for k in range(8):
        high = _spiked(cell, high, 0, rest.solver.now + 1e-6 + 2.0 * SETTLE * k)
    shares = []
    for k, entry in enumerate(centroid_board.linear_lookup()):
        found = []
        for state in (rest, high):
            before = cell.voltages(state)[0]
            after = cell.voltages(_spiked(cell, state, k, state.solver.now + 1e-6))[0]
            if abs(entry - before) > FLOOR:
                found.append(np.log((entry - before) / (entry - after)))
        shares.append(np.mean(found))
    start = high.solver.now + CAUGHT
    high, _, _ = cell.advance(high, start)
    middle, _, _ = cell.advance(high, start + RISE)
    low, _, _ = cell.advance(middle, start + FALL)
    top, _, _, first = cell.voltages(high)
    _, proximity, _, wanted = cell.voltages(middle)
    leak = FALL / math.log((top - far) / (cell.voltages(low)[0] - far))

    def lag(low_pass: float) -> float:
        gain = 1.0 / (1.0 - low_pass / leak)
        fast, slow = math.exp(-RISE / leak), math.exp(-RISE / low_pass)
        return float(far + (first - far) * slow + (top - far) * gain * (fast - slow) - wanted)

    return {
        "log_far_default": math.log(far),
        "offset_V": proximity - wanted,
        "log_share": np.array(shares),
        "leak_time_s": leak,
        "filter_time_s": float(optimise.brentq(lag, 5e-3, 0.5)),
        "slew_time_s": slew,
    }


def _spiked(cell: Cell, state: CellState, neuron: int, time: float) -> CellState:
    state, _, _ = cell.advance(state, time)
    state, _, _ = cell.advance(state, time + SETTLE, [(f"spike[{neuron}]", time)])
    return state


MODEL = plain_model("centroid-board", circuits, measure, held_out_errors, CentroidModel)
