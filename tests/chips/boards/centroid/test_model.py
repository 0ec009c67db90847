"""The centroid board's model beside its circuit, and its laws."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

from chips.boards.centroid.measure import random_train, train_error
from chips.boards.centroid.model import CentroidModel
from circuits.blocks.sonar import centroid_board
from circuits.errors import ParameterError
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon

DIES = (
    Silicon(AMI_1500_IDEAL),
    Silicon(AMI_1500_IDEAL, temperature_c=60.0),
    Silicon(AMI_1500_IDEAL, temperature_c=5.0, die=Die("A", 1003)),
)


@pytest.mark.parametrize("silicon", DIES, ids=str)
def test_the_proximity_voltage_follows_the_circuit_under_random_trains(silicon: Silicon) -> None:
    error = train_error(silicon, random_train(np.random.default_rng(7)))
    # the record's largest error on other dies is 2 mV, of 3 V
    assert np.abs(error).max() < 3e-3


def test_one_spike_moves_the_hold_node_most_of_the_way_and_simultaneous_ones_average() -> None:
    model = CentroidModel(Silicon(AMI_1500_IDEAL))
    table = centroid_board.linear_lookup()
    state, _, _ = model.advance(model.begin(), 50e-6, [("spike[2]", 0.0)])
    assert state.board[1] == pytest.approx(0.61 * table[2], rel=0.02)
    pair = [(f"spike[{k}]", 50e-6 + 20e-6 * n) for n in range(20) for k in (2, 6)]
    for event in pair:
        state, _, _ = model.advance(state, event[1])
        state, _, _ = model.advance(state, event[1], [event])
    state, _, _ = model.advance(state, 1e-3)
    assert state.board[1] == pytest.approx(0.5 * (table[2] + table[6]), rel=0.01)


def test_the_answer_does_not_depend_on_where_a_run_is_cut() -> None:
    model = CentroidModel(Silicon(AMI_1500_IDEAL))
    events = [("spike[3]", 1e-3), ("spike[9]", 1.004e-3)]
    whole, _, _ = model.advance(model.begin(), 60e-3, events)
    cut = model.begin()
    for until in (0.4e-3, 1e-3, 1.002e-3, 5e-3, 60e-3):
        now = [e for e in events if cut.time <= e[1] < until]
        cut, _, _ = model.advance(pickle.loads(pickle.dumps(cut)), until, now)
    # exact stretches: only the slewing's end is cut differently
    assert cut.board == pytest.approx(whole.board, abs=2e-5)


def test_a_second_spike_within_the_pulse_is_merged() -> None:
    model = CentroidModel(Silicon(AMI_1500_IDEAL))
    state, _, _ = model.advance(model.begin(), 1e-3, [("spike[0]", 0.0), ("spike[0]", 5e-6)])
    assert state.merged == 1


def test_outside_the_record_it_refuses_with_its_path() -> None:
    with pytest.raises(ParameterError, match=r"board\.temperature: 100 degC"):
        CentroidModel(Silicon(AMI_1500_IDEAL, temperature_c=100.0), path="board")
