"""The ranging chip at both levels in one run, and its validity box at run time."""

from __future__ import annotations

import pickle
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from chips.cell import Cell
from chips.part import Event, Part
from chips.ranging import circuit as ranging_chip
from chips.ranging.chip import ChipState, RangingChip
from chips.validity import outside_boxes
from circuits.bias import rebias
from circuits.devices.source import Polyline
from circuits.errors import ParameterError, UnknownNameError
from circuits.place import circuit_at
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500, AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from system.loop import EventWire, Loop
from tests.chips.looped import Script

DIE = Silicon(AMI_1500_IDEAL, die=Die(number=1007, process=False))  # has neurons of several classes
PAIRS = ((1e-3, 7.4e-3), (61e-3, 82.5e-3))  # s, call and echo


@pytest.fixture(scope="module")
def chip() -> RangingChip:
    return RangingChip(Silicon(AMI_1500_IDEAL), path="bat.ranging_chip", bias_kind="gate")


def _run(chip: RangingChip, events: Sequence[Event], until: float, **lines: Polyline) -> list[Event]:
    state, now = chip.begin(), 0.0
    state, now, output = chip.advance(state, until, events, lines)
    found = list(output.events)
    while now < until:
        state, now, output = chip.advance(state, until)
        found += output.events
    return found


def test_both_levels_in_one_run_give_the_same_spikes() -> None:
    events = tuple(
        sorted([*(("call", c) for c, _ in PAIRS), *(("echo", e) for _, e in PAIRS)], key=lambda e: e[1])
    )
    parts: dict[str, Part[Any]] = {
        "script": Script(tuple(events)),
        "model": RangingChip(DIE, bias_kind="gate"),
    }
    circuit = ranging_chip.build()
    for k in range(ranging_chip.NEURONS):
        neuron, place = circuit_at(circuit, (("neuron", (k,)),))
        parts[f"neuron[{k}]"] = Cell(neuron, replace(DIE, place=place), rtol=1e-5)
    wires = [EventWire("script", p, t, p) for t in parts if t != "script" for p in ("call", "echo")]
    loop = Loop(parts, wires, [], horizon=20e-3)
    model: list[tuple[int, float]] = []
    cells: list[tuple[int, float]] = []
    while loop.time < 100e-3:
        for part, port, time in loop.step(100e-3).events:
            if part == "model":
                model.append((int(port[len("spike[") : -1]), time))
            elif part != "script":
                cells.append((int(part[len("neuron[") : -1]), time))
    assert len(cells) >= 4
    by_neuron = [[sorted(e for e in found if e[0] == k) for k in range(13)] for found in (model, cells)]
    assert [len(x) for x in by_neuron[0]] == [len(x) for x in by_neuron[1]]
    # the error that the edges are allowed; the measured one is below 0.02 ms
    for ours, theirs in zip(sorted(model), sorted(cells), strict=True):
        assert ours[1] == pytest.approx(theirs[1], abs=0.1e-3)


def test_the_neuron_of_the_delay_fires(chip: RangingChip) -> None:
    spikes = _run(chip, [("call", 1e-3), ("echo", 7.4e-3)], 50e-3)
    assert [p for p, _ in spikes] == ["spike[2]"]


def test_how_it_is_advanced_does_not_change_events(chip: RangingChip) -> None:
    state, now = chip.begin(), 0.0
    found: list[Event] = []
    pending = [("call", 1e-3), ("echo", 7.4e-3)]
    while now < 20e-3:
        due = [e for e in pending if e[1] <= now + 1e-12]
        pending = [e for e in pending if e not in due]
        until = min([now + 1e-3, *(t for _, t in pending)])
        state, now, output = chip.advance(state, until, due)
        found += output.events
    ((port, time),) = found
    ((_, expected),) = _run(chip, [("call", 1e-3), ("echo", 7.4e-3)], 20e-3)
    assert port == "spike[2]"
    assert time == pytest.approx(expected, abs=5e-6)


def test_states_are_values_that_pickle(chip: RangingChip) -> None:
    state, _, _ = chip.advance(chip.begin(), 5e-3, [("call", 1e-3), ("echo", 7.4e-3)])
    before = pickle.dumps(state)
    first = chip.advance(state, 20e-3)
    assert pickle.dumps(state) == before
    again = chip.advance(pickle.loads(before), 20e-3)
    assert first[2].events == again[2].events
    for one, other in zip(first[0].neurons, again[0].neurons, strict=True):
        assert np.array_equal(one, other)
    assert chip.next_time(state) == 7.4e-3


def test_into_what_spans_a_run_is_cut_moves_no_bit() -> None:
    # a step of the solver that was cut moved spikes of this die by 16 us
    chip = RangingChip(Silicon(AMI_1500, die=Die(number=1000)))
    inputs = [(p, start + at) for start in (1e-3, 51e-3) for p, at in (("call", 0.0), ("echo", 17.3e-3))]

    def spikes(cuts: list[float]) -> tuple[list[tuple[str, float]], ChipState]:
        state, found = chip.begin(), []
        for k, end in enumerate(cuts):
            given = [e for e in inputs if (cuts[k - 1] if k else 0.0) <= e[1] < end]
            while state.time < end:
                state, _, output = chip.advance(state, end, given)
                given, found = [], found + list(output.events)
        return found, state

    whole, ended = spikes([0.12])
    assert len(whole) > 50
    for cuts in (np.linspace(0.0, 0.12, 121)[1:].tolist(), [0.0183, 0.01842, 0.0501, 0.0693, 0.12]):
        found, state = spikes(cuts)
        assert found == whole
        for one, other in zip(ended.neurons, state.neurons, strict=True):
            assert np.array_equal(one, other)


def test_isolation_holds_the_excitation_off(chip: RangingChip) -> None:
    pair = [("call", 1e-3), ("echo", 7.4e-3)]
    flat = np.array([0.0, 1.0])
    assert _run(chip, pair, 30e-3, v_ex_max=(flat, np.array([5.0, 5.0]))) == []
    assert len(_run(chip, pair, 30e-3, v_ex_max=(flat, np.array([4.301, 4.301])))) == 1


def test_an_event_within_the_pulse_before_is_merged(chip: RangingChip) -> None:
    state, _, _ = chip.advance(chip.begin(), 2e-3, [("call", 1e-3), ("call", 1.005e-3)])
    assert state.merged == 1


def test_a_running_temperature_moves_the_release(chip: RangingChip) -> None:
    def release(temperature: float) -> float:
        line = (np.array([0.0, 1.0]), np.array([temperature, temperature]))
        state, _, _ = chip.advance(chip.begin(), 2e-3, [("call", 1e-3)])
        state, _, _ = chip.advance(state, 3e-3, (), {"temperature": line})
        assert isinstance(state, ChipState)
        return float(state.neurons.base[6, 8])

    assert release(40.0) < release(27.0) < release(20.0)


def test_outside_the_box_it_refuses_or_goes_on_with_the_path(chip: RangingChip) -> None:
    with pytest.raises(ParameterError, match=r"bat\.chip\.temperature: 90 degC, must be -10 to 65 degC"):
        RangingChip(Silicon(AMI_1500_IDEAL, temperature_c=90.0), path="bat.chip", bias_kind="gate")
    low = (np.array([0.0]), np.array([2.0]))
    with pytest.raises(ParameterError, match=r"bat\.ranging_chip\.v_ex_max: 2 V"):
        chip.advance(chip.begin(), 1e-3, (), {"v_ex_max": low})
    hot = (np.array([0.0]), np.array([80.0]))
    with pytest.raises(ParameterError, match=r"bat\.ranging_chip\.temperature: 80 degC"):
        chip.advance(chip.begin(), 1e-3, (), {"temperature": hot})
    slow = rebias(ranging_chip.build(), {"i_inh_tau": (*ranging_chip.I_INH_TAU[:-1], 0.8e-12)})
    with outside_boxes("warn") as left:
        RangingChip(Silicon(AMI_1500_IDEAL), slow, "bat.chip")
    (text,) = left.texts()
    assert text.startswith("bat.chip.neuron[12].i_inh_tau: 8e-13 A, must be 1e-12 to 3e-08 A, where")


def test_an_unknown_event_port_is_named(chip: RangingChip) -> None:
    with pytest.raises(UnknownNameError, match=r"bat\.ranging_chip event port ping"):
        chip.advance(chip.begin(), 1e-3, [("ping", 0.0)])


def test_what_is_too_near_to_call_is_counted() -> None:
    chip = RangingChip(Silicon(AMI_1500_IDEAL), bias_kind="gate")
    was = chip.model.record
    record = replace(was, errors={**was.errors, "margin_rms_V": 0.075})
    unsure = RangingChip(Silicon(AMI_1500_IDEAL), record=record, bias_kind="gate")
    for part, count in ((chip, 0), (unsure, 13)):
        state, _, _ = part.advance(part.begin(), 60e-3, [("call", 1e-3)])
        assert state.undecided == count
