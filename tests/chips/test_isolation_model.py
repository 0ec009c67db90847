"""First-target isolation's model beside its circuit."""

from __future__ import annotations

import pytest

from chips.cell import Cell
from chips.isolation_model import IsolationModel
from circuits.blocks import first_target_isolation
from circuits.silicon import Silicon


def test_it_isolates_from_the_first_spike_to_the_next_call_as_the_circuit_does() -> None:
    silicon = Silicon()
    start = first_target_isolation.rest(silicon.process.v_dd)
    cell = Cell(first_target_isolation.build(), silicon, ("v_ex_max",), rtol=1e-3, start=start)
    model = IsolationModel(silicon)
    one, other = cell.begin(), model.begin()
    time = 0.0
    levels = []
    for port in ("spike[3]", "spike[5]", "call", "call", "spike[0]"):
        time += 50e-6
        one, _, _ = cell.advance(one, time)
        other, _, _ = model.advance(other, time)
        one, _, wave = cell.advance(one, time + 40e-6, [(port, time)])
        other, _, line = model.advance(other, time + 40e-6, [(port, time)])
        assert line.voltage[-1, 0] == pytest.approx(wave.voltage[-1, 0], abs=2e-3)
        levels.append(float(line.voltage[-1, 0]))
    assert levels == [5.0, 5.0, 4.301, 4.301, 5.0]


def test_a_call_wins_over_a_spike_of_the_same_instant() -> None:
    model = IsolationModel(Silicon())
    state, _, output = model.advance(model.begin(), 1e-3, [("call", 0.0), ("spike[1]", 0.0)])
    assert not state.isolated
    assert output.voltage[-1, 0] == pytest.approx(4.301)
