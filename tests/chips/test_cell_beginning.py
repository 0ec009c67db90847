"""A circuit as a part of a system leaves a rest state that is not stable, and says so."""

from __future__ import annotations

import pytest

from chips.cell import Cell
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.beginning import Disturbed
from tests.circuits.solver.oscillators import OSCILLATORS


def test_an_oscillator_sends_events_by_itself() -> None:
    cell = Cell(OSCILLATORS["ring"](AMI_1500_IDEAL, 3, 1.0).circuit, Silicon(AMI_1500_IDEAL))
    with pytest.warns(Disturbed, match="10 mV added at spike"):
        state = cell.begin()
    for _ in range(3):
        state, reached, output = cell.advance(state, 1e-6)
        assert [port for port, _ in output.events] == ["spike"]
        assert reached < 30e-9
