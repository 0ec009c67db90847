"""Cards that ngspice has and a circuit of ours has not: named and kept, or refused."""

import pytest

from circuits.errors import DataError
from netlists.read import Imported, read_netlist
from tests.refusals import refusals

DECK = """t
.model q npn (bf=100)
.model sw sw
.model m nmos (level=1 vto=0.7)
.param x={agauss(1, 0.1, 3)}
v1 in 0 5
vm in c 0
q1 c b 0 q
r1 in b 1meg
r2 in b {1k*x}
r3 in b r={1k*v(b)}
k1 l1 l2 0.5
b1 d 0 i=1m*v(d)^2
e1 f 0 poly(1) d 0 0 2
m1 d b 0 0 m w=1u l=1u
s1 d f d 0 sw
.ic v(f)=1
.options scale=2
.step r1 1 2 1
.control
alter r1=2
.endc
"""


def kept(text: str) -> Imported:
    return read_netlist(text, foreign="kept")


def test_each_card_is_in_the_circuit_or_kept_as_text_with_its_reason() -> None:
    found = kept(DECK)
    assert [d.name for d in found.circuit.devices] == ["r1"]
    reasons = {f.text.split()[0]: f.reason for f in found.foreign}
    assert set(reasons) == {
        "alter", ".param", ".options", ".step", ".ic", "q1", "r2", "r3", "k1", "b1", "e1", "m1", "s1"
    }  # fmt: skip
    assert (
        reasons["q1"] == "q1: a bipolar transistor, which the native solver has not; run the deck in ngspice"
    )
    assert "parameter with a value in ngspice alone" in reasons["r2"]
    assert "parameters level, vto: not honoured" in reasons["m1"]
    assert [f.place for f in found.foreign if f.text.startswith("k1")] == ["netlist:12"]


def test_such_cards_are_refused_unless_they_are_to_be_kept() -> None:
    with pytest.raises(DataError, match=r"^netlist:5: .param x: .* a function of ngspice alone"):
        read_netlist(DECK.partition(".control")[0])
    with pytest.raises(
        DataError, match=r"^netlist:3: q1: a bipolar transistor, which the native solver has not"
    ):
        read_netlist("t\n.model q npn\nq1 c b 0 q\nr1 c 0 1")
    assert kept("t\nr1 a 0 1").foreign == ()


def test_a_deck_of_commands_alone_is_an_empty_circuit() -> None:
    assert kept("t\n.control\necho 1\n.endc\n").circuit.devices == ()


def test_a_model_in_bins_is_known_by_the_name_that_they_share() -> None:
    text = "t\n.model n.7 nmos (level=54)\n.model n.8 nmos (level=54)\nm1 d g 0 0 n w=1u l=1u\nr1 d 0 1\n"
    found = kept(text)
    assert [f.text for f in found.foreign] == ["m1 d g 0 0 n w=1u l=1u"]
    dropped = read_netlist(text, drop=[".model"])
    assert [d.name for d in dropped.circuit.devices] == ["m1", "r1"]


test_what_ngspice_cannot_have_either_is_refused = refusals(
    DataError,
    kept,
    [
        ("t\nq1 c b 0 q", "netlist:2: q1: model q: unknown; add its .model card of type npn or pnp"),
        ("t\n.model q d\nq1 c b 0 q", "netlist:3: q1: model q: type d, must be npn or pnp"),
        ("t\nd1 a 0", "netlist:2: d1: 2 words, a diode has more"),
        ("t\n, ,\nr1 a 0 1", "netlist:2: "),
        ("t\nhello world", "netlist:2: hello: 1 words, a voltage source that a current controls has more"),
        ("t\na1 [a b] c gate", "netlist:2: a1: model gate: unknown"),
        ("t\nm1 d g s none", "netlist:2: m1: 4 words, must be 4 nodes and a model"),
        ("t\nx1 a none", "sub-circuit none is not there"),
        ("t\nr1 a 0 1\n.ib v(a)", "netlist:3: .ib: unknown card"),
        ("t\nr1 a 0 {b}", "b: unknown parameter"),
    ],
)
