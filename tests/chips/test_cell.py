"""A cell lives by events, and answers as its circuit does in one transient."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

from chips.cell import Cell, CellState, add_pulse
from circuits.blocks.sonar import rebound_neuron
from circuits.errors import TopologyError
from circuits.event import EDGE, WIDTH
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.transient import simulate

CALL, ECHO = 1e-3, 7.4e-3


@pytest.fixture(scope="module")
def neuron() -> Cell:
    return Cell(rebound_neuron.build(), Silicon(AMI_1500_IDEAL), ("v_mem",))


def _spike(cell: Cell) -> tuple[CellState, float, tuple[tuple[str, float], ...]]:
    state, _, _ = cell.advance(cell.begin(), CALL)
    state, _, _ = cell.advance(state, ECHO, [("call", CALL)])
    state, reached, output = cell.advance(state, 15e-3, [("echo", ECHO)])
    return state, reached, output.events


def test_a_cell_fires_when_its_circuit_does(neuron: Cell) -> None:
    stimuli = rebound_neuron.BLOCK.defaults
    bench = rebound_neuron.testbench(rebound_neuron.build(), stimuli, 5.0)
    _, reached, events = _spike(neuron)
    assert [port for port, _ in events] == ["spike"]
    # twice the solver's own error at the default tolerance, 2 us
    assert abs(reached - simulate(bench, Silicon(AMI_1500_IDEAL)).spikes["spike"][0]) < 4e-6


def test_spans_of_a_run_move_a_spike_by_less_than_the_solver_s_error(neuron: Cell) -> None:
    _, whole, _ = _spike(neuron)
    state, found = neuron.begin(), []
    for end in np.linspace(0.0, 12e-3, 13)[1:].tolist():
        given = [(port, at) for port, at in (("call", CALL), ("echo", ECHO)) if end - 1e-3 <= at < end]
        reached = -1.0
        while reached < end:
            state, reached, output = neuron.advance(state, end, given)
            given, found = [], [*found, *output.events]
    ((_, cut),) = found
    # an eightieth of the solver's own error at the default tolerance, 2 us
    assert abs(cut - whole) < 25e-9


def test_a_cell_stops_at_its_event_and_goes_on(neuron: Cell) -> None:
    state, reached, events = _spike(neuron)
    assert events[0][1] == reached == state.solver.now
    state, reached, output = neuron.advance(state, 15e-3)
    assert reached == pytest.approx(15e-3, abs=1e-12)
    assert output.events == ()


def test_advancing_leaves_the_old_state_as_it_was(neuron: Cell) -> None:
    state, _, _ = neuron.advance(neuron.begin(), CALL, [("call", 0.5e-3)])
    before = pickle.dumps(state)
    first = neuron.advance(state, 3e-3)[0]
    assert pickle.dumps(state) == before
    again = neuron.advance(pickle.loads(before), 3e-3)[0]
    assert np.array_equal(first.solver.voltage, again.solver.voltage)


def test_an_event_within_the_pulse_before_is_merged_and_counted(neuron: Cell) -> None:
    state, _, _ = neuron.advance(neuron.begin(), 1e-3, [("call", 0.5e-3), ("call", 0.505e-3)])
    assert state.merged == 1


def test_a_pulse_has_the_boundary_s_form() -> None:
    (time, value), merged = add_pulse((np.zeros(1), np.zeros(1)), 1e-3, 5.0)
    assert merged == 0
    assert np.interp(1e-3 + 0.5 * EDGE, time, value) == pytest.approx(2.5)
    assert np.interp(1e-3 + EDGE + 0.5 * WIDTH, time, value) == 5.0
    assert value[-1] == 0.0


def test_an_open_input_is_named() -> None:
    part = rebound_neuron.comparator(rebound_neuron.Params())
    with pytest.raises(TopologyError, match="v_mem"):
        Cell(part, Silicon(AMI_1500_IDEAL))
