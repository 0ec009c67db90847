"""A netlist is something to run: with its own sources, or a sub-circuit of it alone."""

from pathlib import Path

import pytest

from circuits.circuit import Circuit
from circuits.errors import UnknownNameError
from circuits.testbench import Testbench
from netlists.read.bench import read_bench
from tests.written import written

DECK = """a low-pass
.subckt lowpass in out
r1 in out 1meg
c1 out 0 1p
.ends
x1 a b lowpass
va a 0 pwl(0 0 1u 0 1.1u 1)
.tran 1n 20u
.end
"""


@pytest.fixture
def deck(tmp_path: Path) -> Path:
    return written(tmp_path / "deck.cir", DECK)


def test_a_deck_has_its_sources_and_its_end(deck: Path) -> None:
    found = read_bench(deck)
    assert isinstance(found, Testbench)
    assert [s.name for s in found.sources] == ["va"]
    assert found.stop == 20e-6


def test_a_subcircuit_has_its_ports(deck: Path) -> None:
    found = read_bench(deck, "LowPass")
    assert isinstance(found, Circuit)
    assert [p.name for p in found.ports] == ["in", "out"]
    with pytest.raises(UnknownNameError, match="subcircuit highpass: unknown; known are lowpass"):
        read_bench(deck, "highpass")
