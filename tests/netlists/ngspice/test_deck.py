"""A user's deck in ngspice as it stands."""

from pathlib import Path

import pytest

from circuits.errors import DataError, SimulatorError
from netlists.ngspice.deck import deck_text, run_deck
from tests.written import written

DECK = """a diode and a load
.include parts.inc
v1 in 0 2
x1 in out load
.print dc v(out)
.tran 1u 100u
.control
shell touch ran
dc v1 0 2 1
.endc
.end
"""
PARTS = ".subckt load a b\nd1 a b d\nr1 b 0 1k\n.ends\n.model d d (is=1e-14)\n"


@pytest.fixture
def deck(tmp_path: Path) -> Path:
    (tmp_path / "parts.inc").write_text(PARTS)
    return written(tmp_path / "deck.cir", DECK)


def test_it_has_one_analysis_and_its_commands_are_never_run(deck: Path) -> None:
    text = deck_text(deck, "dc")
    assert text.splitlines()[-2:] == [".dc v1 0 2 1", ".end"]
    assert ".tran" not in text
    found = run_deck(deck, "dc")
    assert (found.axis_name, found.axis.tolist()) == ("v-sweep", [0.0, 1.0, 2.0])
    # 2 V less a junction's: I = (2 - V) / 1k with V = 0.02585 ln(I / 1e-14)
    assert found.values["out"][-1] == pytest.approx(1.33, abs=0.01)
    assert not (deck.parent / "ran").exists()
    assert not Path("ran").exists()


def test_its_operating_point_and_transient(deck: Path) -> None:
    assert run_deck(deck, "op").values["out"][0] == pytest.approx(1.33, abs=0.01)
    assert run_deck(deck, "tran").axis[-1] == pytest.approx(100e-6)


def test_what_it_does_not_ask_for_is_refused(deck: Path) -> None:
    deck.write_text(DECK.replace(".tran 1u 100u", ".ac dec 1 1 10"))
    with pytest.raises(DataError, match=r"^deck.cir: no \.tran card, it asks for \.ac, \.dc"):
        run_deck(deck, "tran")
    deck.write_text(DECK.replace("x1 in out load", "n1 in out load"))
    with pytest.raises(SimulatorError, match=r"^deck.cir: ngspice: "):
        run_deck(deck, "op")
