"""A testbench as a file of Python is that testbench again."""

from __future__ import annotations

import pytest

from circuits.registry import load_block
from circuits.testbench import Testbench
from netlists.read import read_netlist
from netlists.write.python import format_python

DECK = """two dividers "and" a sine
.subckt half a b params: r=1k
r1 a b {r}
r2 b 0 {r}
.ends
v1 in 0 dc 2 sin(1 1 1k)
d1 out 0 dd
.model dd d
i1 0 out pulse(0 1u 0 1u 1u 1m 2m)
x1 in mid half
x2 mid out half r=2k
c1 out 0 1n ic=0.5
.ic v(out)=0.25
.nodeset v(x1.b)=0
.tran 1u 1m uic
"""


def made_of(text: str) -> Testbench:
    names: dict[str, object] = {}
    exec(compile(text, "made.py", "exec"), names)  # noqa: S102 - our own text
    bench = names["testbench"]()  # type: ignore[operator]
    assert isinstance(bench, Testbench)
    return bench


def test_a_deck_comes_back() -> None:
    bench = read_netlist(DECK.replace(".nodeset v(x1.b)=0\n", "")).testbench
    text = format_python(bench, "deck")
    again = made_of(text)
    assert again.circuit == bench.circuit
    assert (again.stop, again.begin, again.initial) == (1e-3, "uic", {"out": 0.25})
    assert repr(again.sources[1]) == repr(bench.sources[1])
    assert (again.sources[0].waveform.value == bench.sources[0].waveform.value).all()  # type: ignore[union-attr]
    assert text.count("def half") == 2
    assert format_python(bench, "deck") == text


@pytest.mark.parametrize("name", ["rebound-neuron", "winner-take-all"])
def test_a_block_comes_back_with_its_biases_and_arrays(name: str) -> None:
    block = load_block(name)
    bench = block.testbench(block.build(), block.defaults, block.process.v_dd)
    again = made_of(format_python(bench, f"{name}'s"))
    assert again.circuit == bench.circuit
    assert again.sources == bench.sources
    assert (again.watch, again.begin) == (bench.watch, bench.begin)


def test_nothing_is_imported_that_is_not_used() -> None:
    text = format_python(read_netlist("t\nr1 a 0 1\nv1 a 0 1\n").testbench, "t")
    assert "Capacitor" not in text
    assert "numpy" not in text
