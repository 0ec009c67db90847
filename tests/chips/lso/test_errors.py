"""The model against transistors at their places on dies that the record was not built from."""

import numpy as np
import pytest

from chips.lso.errors import inputs, level_delays, neuron_spikes
from chips.lso.measure import AT, FROM
from chips.lso.model import RECORD, head_on
from chips.record import kept_record
from circuits.circuit import BiasKind
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500, AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon

ERROR = 0.011  # of a spike's time, the largest in the record
LATE = 3e-6  # s, of a level unit's, likewise

CASES: list[tuple[BiasKind, int, float]] = [
    ("gate", 1003, 10.0),
    ("ideal", 1006, 45.0),
    ("generator", 1008, 27.0),
]


@pytest.mark.parametrize(("kind", "number", "celsius"), CASES)
def test_spikes_are_those_of_the_transistors(kind: BiasKind, number: int, celsius: float) -> None:
    silicon = Silicon(AMI_1500_IDEAL, temperature_c=celsius, die=Die(number=number))
    head, side = head_on(silicon, kind), number % 2
    ours, theirs = neuron_spikes(head, silicon, kind, side, inputs(number))
    assert theirs.size > 0
    assert ours.size == theirs.size
    assert ours - AT == pytest.approx(theirs - AT, rel=ERROR)
    place = (side, number % 10)
    assert head.rest[place] < -FROM
    mine, its = level_delays(head, silicon, kind, place, 2e3)
    assert mine == pytest.approx(its, abs=LATE)


@pytest.mark.parametrize(("kind", "number", "celsius"), [("gate", 1000, 27.0), ("generator", 1003, -10.0)])
def test_under_the_full_law_too(kind: BiasKind, number: int, celsius: float) -> None:
    silicon = Silicon(AMI_1500, celsius, Die(number=number))
    head, side = head_on(silicon, kind), number % 2
    ours, theirs = neuron_spikes(head, silicon, kind, side, inputs(number))
    assert ours.size == theirs.size > 0
    assert ours - AT == pytest.approx(theirs - AT, rel=ERROR)
    place = (side, number % 10)
    mine, its = level_delays(head, silicon, kind, place, 2e3)
    assert (head.rest[place] < -FROM) == np.isfinite(its)
    assert mine == pytest.approx(its, abs=5e-6)


def test_capacitors_of_a_die_are_followed() -> None:
    full, drawn = (
        Silicon(AMI_1500, die=Die(number=504, variation=extent)) for extent in ("full", "transistors")
    )
    head = head_on(full, "gate")
    assert np.abs(head.charge / head_on(drawn, "gate").charge - 1.0).min() > 0.01
    ours, theirs = neuron_spikes(head, full, "gate", 0, inputs(504))
    assert abs(ours.size - theirs.size) <= 1  # of 22; the same without capacitors
    both = min(ours.size, theirs.size)
    assert ours[:both] - AT == pytest.approx(theirs[:both] - AT, rel=ERROR)


def test_a_deaf_level_unit_is_deaf_in_the_circuit() -> None:
    silicon = Silicon(AMI_1500_IDEAL, die=Die(number=515))
    head, place = head_on(silicon, "ideal"), (1, 5)
    assert head.rest[place] > -FROM
    assert level_delays(head, silicon, "ideal", place, 2e3)[1] == np.inf


def test_under_the_full_law_a_unit_that_rests_as_if_it_heard_is_still_deaf() -> None:
    silicon, place = Silicon(AMI_1500, 60.0, Die(number=102)), (0, 2)
    head = head_on(silicon, "gate")
    assert head.rest[place] > -FROM
    assert level_delays(head, silicon, "gate", place, 800.0)[1] == np.inf


def test_errors_on_other_dies_are_in_the_record() -> None:
    found = kept_record(RECORD).errors
    assert found["first_die"] == 500.0
    # stated: counts and deaf units were all right, times within a percent
    assert found["counts_wrong"] == found["level_decisions_wrong"] == 0.0
    assert found["spike_rms_relative"] < 0.003
    assert found["level_rms_s"] < 2e-6
    assert found["small_counts_wrong"] == found["small_count_max"] == 0.0
    assert found["small_level_decisions_wrong"] == 0.0
    assert found["small_spike_rms_relative"] < 0.006


def test_inputs_are_of_both_sides_and_within_an_echo() -> None:
    found = inputs(7)
    on = found[np.isfinite(found)]
    assert np.array_equal(found, inputs(7))
    assert AT <= on.min() <= on.max() <= AT + 0.15e-3
    assert np.isfinite(found[1]).sum() >= np.isfinite(found[0]).sum()
