"""A unit of transistors inside a run says what the model says, on a die with mismatch, as it warms too."""

import numpy as np
import pytest

from chips.latency.chip import LatencyChip
from chips.latency.errors import usual_design
from chips.latency.kernel import recall
from chips.latency.model import usual_biases
from chips.latency.unit_level import TransistorUnit
from circuits.arrays import F64
from circuits.circuit import BiasKind
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500, AMI_1500_IDEAL, Process
from circuits.silicon.silicon import Silicon

PLACE = (16, 4)


@pytest.mark.parametrize("process", [AMI_1500_IDEAL, AMI_1500])
def test_the_unit_stores_repeats_and_forgets_as_the_model_does(process: Process) -> None:
    design = usual_design()
    biases, silicon = usual_biases(design, "ideal", process), Silicon(process, die=Die(number=1003))
    both = []
    for units in ({}, {PLACE: TransistorUnit(biases, silicon, *PLACE)}):
        chip = LatencyChip(design, biases, silicon, units=units)
        memory, found = chip.new_memory(), []
        onset = chip.addresses.onset
        for k in range(4):
            heard = k == 0
            times = np.array([0.0, 10e-3]) if heard else np.zeros(1)
            addresses = np.array([onset, PLACE[0]]) if heard else np.array([onset])
            found.append(chip.ping(memory, 0.1 * (k + 1), times, addresses).detected[PLACE])
            if k == 2:
                chip.reset(memory, 0.1 * (k + 1) + 0.09)
        both.append(found)
    model, circuit = both
    assert np.isfinite(model).tolist() == [True, True, True, False]
    # the node's rise of 14 us is 20 % off, and an edge of 0.1 us
    assert circuit == pytest.approx(model, abs=5e-6)


def rises(time: F64, volts: F64) -> list[float]:
    return [float(t) for t in time[1:][(volts[1:] >= 2.5) & (volts[:-1] < 2.5)]]


@pytest.mark.parametrize(
    ("process", "kind", "before", "after"),
    [
        (AMI_1500_IDEAL, "ideal", 27.0, 47.0),
        (AMI_1500_IDEAL, "gate", 47.0, 27.0),
        (AMI_1500, "gate", 27.0, 47.0),
        (AMI_1500, "generator", 27.0, 7.0),
    ],
)
def test_a_silence_goes_on_at_another_temperature_as_the_model_says(
    process: Process, kind: BiasKind, before: float, after: float
) -> None:
    design = usual_design()
    biases, silicon = usual_biases(design, kind, process), Silicon(process, before, Die(number=1004))
    unit = TransistorUnit(biases, silicon, *PLACE, record=("inh_spike",))
    chip = LatencyChip(design, biases, silicon, units={PLACE: unit})
    memory, kept = chip.new_memory(), chip.lumped
    tap = float(np.cumsum(kept.tap)[PLACE[1] + 1])
    spoken = np.full(design.paths, np.inf)
    spoken[PLACE[0]] = tap + 0.3e-3
    detected, out = np.empty((design.paths, design.taps)), np.empty(design.paths)
    recall(kept, memory, 0.1, spoken, np.full(detected.shape, np.nan), detected, out)
    assert unit.ping(0.1, tap, tap + 0.3e-3) == pytest.approx(detected[PLACE], abs=5e-6)
    now = 0.1 + tap + 0.5 * float(kept.hold[PLACE])
    chip = chip.moved(memory, after, now)
    expected = float(memory.release[PLACE] + chip.lumped.tonic[PLACE])
    unit.advance(expected + 0.5 * float(chip.lumped.tonic[PLACE]))
    found = min(t for time, volts in unit.kept for t in rises(time, volts[:, 0]) if t > now)
    # at one temperature the model's silence is up to 0.5 % off on this die, seen from the middle of one
    assert found - now == pytest.approx(expected - now, rel=0.006)
