"""First-target isolation's model beside its circuit."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

from chips.boards.isolation.measure import circuit_output, compare, crossings, model_output
from chips.boards.isolation.model import UNSURE, IsolationModel
from chips.cell import Cell
from chips.record import kept_record
from circuits.bias import rebias
from circuits.blocks.sonar import first_target_isolation
from circuits.errors import ParameterError
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon


def test_it_isolates_from_the_first_spike_to_the_next_call_as_the_circuit_does() -> None:
    silicon = Silicon(AMI_1500_IDEAL)
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
    assert levels == pytest.approx([5.0, 5.0, 4.301, 4.301, 5.0], abs=1e-6)


def test_the_open_level_is_what_the_board_is_trimmed_to() -> None:
    silicon = Silicon(AMI_1500_IDEAL, 40.0, Die(number=1003))
    board = rebias(first_target_isolation.build(), {"v_ex_max_set": 4.18})
    start = first_target_isolation.rest(silicon.process.v_dd)
    cell = Cell(board, silicon, ("v_ex_max",), rtol=1e-3, start=start)
    level = float(cell.voltages(cell.begin())[0])
    assert IsolationModel(silicon, v_ex_max=4.18).open_level == pytest.approx(level, abs=1e-4)


# s, of a spike behind a call; the pulses last 10 us, the tie is at -0.08 us
LAGS = (-15e-6, -5e-6, -0.2e-6, -0.12e-6, -0.05e-6, 0.0, 0.3e-6, 5e-6, 9.9e-6, 10.3e-6, 15e-6)


@pytest.mark.parametrize("lag", LAGS)
@pytest.mark.parametrize(
    "silicon", [Silicon(AMI_1500_IDEAL), Silicon(AMI_1500_IDEAL, temperature_c=60.0, die=Die(number=1003))]
)
def test_a_spike_near_a_call_ends_as_in_the_circuit(lag: float, silicon: Silicon) -> None:
    call = 40e-6
    events = [("call", call), ("spike[3]", call + lag)]
    train = sorted(events, key=lambda e: e[1])
    one, (other, undecided) = circuit_output(silicon, train), model_output(silicon, train)
    assert undecided == 0
    late, off, alone = compare(one, other)
    assert alone == 0
    errors = kept_record("first_target_isolation").errors
    # twice what the record says of other dies, and the solver's own nanosecond
    assert np.abs(late).max(initial=0.0) < 2.0 * errors["change_max_s"] + 1e-9
    assert np.abs(off).max() < 1e-3


def test_events_at_one_instant_are_in_any_order_what_the_circuit_makes_of_them() -> None:
    model = IsolationModel(Silicon(AMI_1500_IDEAL))
    events = [("call", 1e-6), ("spike[1]", 1e-6)]
    outputs = [model.advance(model.begin(), 1e-3, e)[2] for e in (events, events[::-1])]
    for output in outputs:
        # the call's pulse holds the latch, the spike's outlasts it within the gates' delays
        (change,) = crossings(output.time, output.voltage[:, 0], 4.65)
        assert change == pytest.approx(1e-6 + model.held)


def test_a_spike_at_the_tie_is_counted_as_undecided() -> None:
    model = IsolationModel(Silicon(AMI_1500_IDEAL))
    for lag, undecided in ((0.0, 1), (0.9 * UNSURE, 1), (1.1 * UNSURE, 0), (-1.1 * UNSURE, 0)):
        events = [("call", 40e-6), ("spike[1]", 40e-6 + model.tie + lag)]
        assert model.advance(model.begin(), 1e-3, events)[0].undecided == undecided


def test_any_cuts_of_a_run_give_the_same_changes() -> None:
    model = IsolationModel(Silicon(AMI_1500_IDEAL))
    events = [
        ("spike[1]", 10e-6),
        ("call", 30e-6),
        ("spike[2]", 33e-6),
        ("call", 80e-6),
        ("spike[0]", 200e-6),
    ]
    _, _, whole = model.advance(model.begin(), 300e-6, events)
    time, voltage, state = [], [], model.begin()
    for k, until in enumerate(np.linspace(0.0, 300e-6, 3001)[1:]):
        due = [e for e in events if k * 0.1e-6 <= e[1] < until] if k else [e for e in events if e[1] < until]
        state, _, line = model.advance(pickle.loads(pickle.dumps(state)), float(until), due)
        assert (np.diff(line.time) > 0.0).all()
        time.append(line.time)
        voltage.append(line.voltage[:, 0])
    cut = crossings(np.concatenate(time), np.concatenate(voltage), 4.65)
    assert cut == pytest.approx(crossings(whole.time, whole.voltage[:, 0], 4.65), abs=1e-12)
    assert len(cut) == 5


def test_outside_the_record_it_is_refused() -> None:
    with pytest.raises(ParameterError, match=r"board/isolation.temperature: 80 degC, must be -10 to 65 degC"):
        IsolationModel(Silicon(AMI_1500_IDEAL, temperature_c=80.0), path="board/isolation")
