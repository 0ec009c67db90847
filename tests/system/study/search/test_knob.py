"""What a search moves: values that can be written down, options that replace those of their name."""

from __future__ import annotations

from system.study.search.knob import Knob, knobs_of, moved_subject, options_of
from system.study.target import BlockTarget, Subject


def test_a_knob_moves_in_its_own_way_and_can_be_written_down() -> None:
    current, voltage = Knob("bias", "i", "A", 2e-9), Knob("bias", "v", "V", 2.5)
    array = Knob("bias", "a", "A", (1e-9, 2e-9))
    assert current.at(1.0, 3.0, 0.1) == 6e-9
    assert current.at(-0.5, 3.0, 0.1) == 1.155e-9
    assert current.at(0.0, 3.0, 0.1) == 2e-9
    assert voltage.at(-0.25, 3.0, 0.1) == 2.475
    assert array.at(1.0, 3.0, 0.1) == (3e-9, 6e-9)
    assert array.text((3e-9, 6e-9)) == "a=3nA,6nA"
    assert (current.change_text(3e-9), voltage.change_text(2.475)) == ("x 1.500", "-25 mV")


def test_what_moved_replaces_the_options_of_its_name() -> None:
    start = Subject("rebound-neuron", ("best_delay",), biases=("i-rtau=300pA", "i_cmp=400nA"))
    knobs = knobs_of(BlockTarget(start).choice, ["i-rtau"], ["membrane-capacitance"])
    assert knobs[0].value == 300e-12
    moved = moved_subject(start, knobs, (450e-12, 700e-15))
    assert options_of(moved) == [
        ("param", "membrane_capacitance=700fF"), ("bias", "i_cmp=400nA"), ("bias", "i_rtau=450pA"),
    ]  # fmt: skip
    assert moved_subject(start, knobs, tuple(k.value for k in knobs)) == start


def test_without_a_wish_every_current_moves_and_no_size() -> None:
    choice = BlockTarget(Subject("rebound-neuron", ("best_delay",))).choice
    knobs = knobs_of(choice, (), ())
    assert {k.name for k in knobs} == {b.name for b in choice.circuit.biases if b.kind != "voltage"}
    assert all(k.option == "bias" for k in knobs)
