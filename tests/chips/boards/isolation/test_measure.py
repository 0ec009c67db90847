"""What is measured of the first-target isolation is what its record holds, and its errors are its errors."""

from __future__ import annotations

import numpy as np
import pytest

from chips.boards.isolation import measure as m
from chips.measured.held_out import DIES
from chips.measured.table_record import on_silicon
from chips.record import kept_record
from circuits.event import WIDTH
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon


def test_the_record_holds_what_is_measured() -> None:
    data = kept_record("first_target_isolation")
    found = m._at(Silicon(AMI_1500_IDEAL))
    for name, value in found.items():
        # times to the tie's resolution, levels to a millionth
        assert float(on_silicon(data, name, Silicon(AMI_1500_IDEAL))) == pytest.approx(
            float(value), rel=1e-6, abs=1e-9
        )
    assert WIDTH < found["held_delay_s"] < WIDTH + 1e-6
    assert found["open_V"] == pytest.approx(4.301, abs=1e-3)


def test_the_errors_on_other_dies_are_those_of_the_record() -> None:
    errors = kept_record("first_target_isolation").errors
    silicon = Silicon(AMI_1500_IDEAL, temperature_c=60.0, die=Die("0", DIES[0]))
    train = m.random_train(np.random.default_rng(DIES[0]))
    late, _, alone = m.compare(m.circuit_output(silicon, train), m.model_output(silicon, train)[0])
    assert alone == 0
    assert len(late) > 10
    assert np.abs(late).max() <= errors["change_max_s"] + 1e-9  # another machine chooses other steps


def test_a_difference_between_levels_is_seen() -> None:
    silicon = Silicon(AMI_1500_IDEAL)
    train = m.random_train(np.random.default_rng(0))
    one = m.circuit_output(silicon, train)
    late, off, alone = m.compare(one, (one[0] + 50e-9, one[1] + 0.02))
    assert late == pytest.approx([50e-9] * len(late), abs=5e-9)
    assert np.median(off) == pytest.approx(0.02, abs=1e-6)
    flat = (np.array([one[0][0], one[0][-1]]), np.array([4.3, 5.0]))
    assert m.compare(one, flat)[2] > 10
    assert alone == 0


def test_crossings_both_ways() -> None:
    time, voltage = np.array([0.0, 1.0, 2.0]), np.array([4.0, 5.0, 4.0])
    assert m.crossings(time, voltage, 4.75) == pytest.approx([0.75, 1.25])
