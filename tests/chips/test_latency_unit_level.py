"""A unit of transistors inside a run says what the model says, on a die with mismatch."""

import numpy as np
import pytest

from chips.latency_chip import LatencyChip
from chips.latency_errors import usual_design
from chips.latency_model import usual_biases
from chips.latency_unit_level import TransistorUnit
from circuits.die import Die
from circuits.silicon import Silicon

PLACE = (16, 4)


def test_the_unit_stores_repeats_and_forgets_as_the_model_does() -> None:
    design = usual_design()
    biases, silicon = usual_biases(design, "generator"), Silicon(die=Die(number=1003))
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
