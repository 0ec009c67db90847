"""Whole netlists written by hand."""

from pathlib import Path

import numpy as np
import pytest

from circuits.circuit import GROUND
from circuits.devices.source import Pulse
from circuits.errors import DataError, UnknownNameError
from circuits.lowering.flatten import flatten
from circuits.lowering.kernel import to_kernel
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Deviation, Silicon
from circuits.solver.operating_point import operating_point
from netlists.read import Limits, Note, read_netlist

INVERTERS = """Two inverters
* of a hand-written deck
.param wn=3u
+ wp={2*wn}
.SUBCKT INV in out vdd params: w=3u
mn out in 0 0 NCH W={w} L=1.5U ; the n device
mp out in vdd vdd PCH W=wp L=1.5u DELVTO=-10m
.ENDS
.MODEL nch NMOS (LEVEL=8 VTH0=0.6
+ TOX=30n)
.MODEL pch PMOS LEVEL=8
Vdd vdd 0 5
Vin 1 0 DC 0 PULSE(0 5 1u 10n 10n 5u 20u)
X1 1 net-3 vdd inv
X2 net-3 out vdd inv w=wn
Cl out 0 10fF
.tran 10n 50u
.end
"""


def test_a_deck_becomes_a_circuit_that_runs() -> None:
    found = read_netlist(INVERTERS, drop=["nch", "pch"])
    machine = to_kernel(found.testbench, Silicon(AMI_1500_IDEAL))
    voltages = operating_point(machine).voltages()
    assert voltages["net_x2d_3"] == pytest.approx(5.0, abs=1e-3)  # leakage alone moves it
    assert voltages["out"] == pytest.approx(0.0, abs=1e-3)
    assert flatten(found.circuit).count == 5  # ground, 1, net-3, out, vdd


def test_everything_else_is_told() -> None:
    found = read_netlist(INVERTERS, drop=["NCH,pch"])
    assert found.testbench.title == "Two inverters"
    assert found.testbench.stop == 50e-6
    pulse = found.testbench.sources[1].waveform
    assert isinstance(pulse, Pulse)
    np.testing.assert_allclose(pulse.starts, (1e-6, 21e-6, 41e-6), rtol=1e-12)
    # a more negative threshold of a pFET is a larger magnitude
    assert found.deviations == {"x1.mp": Deviation(0.01, 0.0), "x2.mp": Deviation(0.01, 0.0)}
    assert found.names == {"_1": "1", "net_x2d_3": "net-3"}
    assert found.notes == ()
    assert found.dropped == (
        Note(".model nch: parameters level, vth0, tox", "netlist:9"),
        Note(".model pch: parameters level", "netlist:11"),
    )
    assert (found.dialect, found.temperature_c, found.silicon) == ("spice", None, None)


def test_structured_comments_without_their_header_are_comments() -> None:
    found = read_netlist("t\n*% port a\nr1 a 0 1\n")
    assert len(found.circuit.devices) == 1
    assert "structured comment" in found.notes[0].what


def test_cdl_has_no_title_line() -> None:
    text = ".SUBCKT inv a y\nm1 y a 0 0 nm W=1u L=1u\n.ENDS\n.model nm nmos\n"
    assert read_netlist(text, dialect="cdl").circuit.name == "inv"
    with pytest.raises(DataError, match=r"without \.subckt"):
        read_netlist(text)


def test_an_unknown_dialect() -> None:
    with pytest.raises(UnknownNameError, match="dialect verilog: unknown"):
        read_netlist("t\nr1 a 0 1\n", dialect="verilog")


def test_spectre_without_notes_is_not_read() -> None:
    with pytest.raises(DataError, match="netlist:2: spectre without our notes"):
        read_netlist("// t\nsimulator lang=spectre\nr1 (a 0) resistor r=1\n")


def test_a_million_lines_meet_the_limit_at_once(tmp_path: Path) -> None:
    path = tmp_path / "large.cir"
    path.write_text("t\n" + "r1 a 0 1\n" * 1_000_000)
    with pytest.raises(DataError, match=r"large\.cir:400000: more than 400000 lines, the limit"):
        read_netlist(path)


def test_unused_ports_and_ground() -> None:
    found = read_netlist("t\n.subckt s a b\nr1 a gnd 1\n.ends\nx1 c d s\nr1 c 0 1\n")
    assert found.circuit.instances[0].connections == {"a": "c", "b": "d"}
    assert found.circuit.instances[0].circuit.devices[0].terminals() == ("a", GROUND)


def test_cards_without_notes_have_a_limit_and_comments_do_not_count() -> None:
    deck = "t\n" + "* a comment\n" * 30 + "r1 a 0 1\nr2 a 0 1\n"
    assert len(read_netlist(deck, limits=Limits(cards=2)).circuit.devices) == 2
    with pytest.raises(DataError, match="netlist:34: more than 2 cards, the limit"):
        read_netlist(deck + "r3 a 0 1\n", limits=Limits(cards=2))


TRANSISTOR = "t\nm1 a a 0 0 n w=1u l=1u\n"


@pytest.mark.parametrize(
    ("deck", "says", "drop"),
    [
        (
            TRANSISTOR + ".model n nmos (level=1\n+ vto=1 kp=2 a=1 b=2 c=3 d=4)\n",
            "netlist:3: .model n: parameters level, vto, kp, a, b, c and 1 more: not honoured; ",
            ("n", ".model"),
        ),
        (
            "t\n.subckt s a\n" + TRANSISTOR[2:] + ".model n nmos kp=1\n.ends\nx1 a s\n",
            "netlist:4: .model n: ",
            ("N",),
        ),
        (
            TRANSISTOR + ".model n nmos\n.step n(kp) 1 2 3\n",
            "netlist:4: .step of a device or a model: not honoured; ",
            (".step",),
        ),
        (
            TRANSISTOR + ".model n nmos\n.options reltol=1 scale=1u\n",
            "netlist:4: option scale: not",
            ("scale",),
        ),
        (
            "t\nm1 a a 0 0 n w=1u l=1u dtemp=9\n.model n nmos\n",
            "netlist:2: dtemp of a transistor: ",
            ("dtemp",),
        ),
        ("t\nr1 a 0 1 tc1=1m\n", "netlist:2: tc1 of a resistor: not honoured; a value holds", ("TC1",)),
        ("t\nr1 a 0 1\n.control\nalter r1=2\n.endc\n", "netlist:4: alter: not honoured; ", ("alter",)),
    ],
)
def test_what_would_change_the_circuit_goes_only_by_name(deck: str, says: str, drop: tuple[str, ...]) -> None:
    with pytest.raises(DataError) as refused:
        read_netlist(deck)
    assert str(refused.value).startswith(says)
    with pytest.raises(DataError):
        read_netlist(deck, drop=["something", "else"])
    for name in drop:
        (gone,) = read_netlist(deck, drop=["x", name]).dropped
        assert says.startswith(f"{gone.place}: {gone.what}"[:20])


def test_a_model_that_nothing_uses_and_analyses_that_change_nothing_are_noted() -> None:
    found = read_netlist("t\nr1 a 0 1\n.model d d (is=1e-14)\n.tf v(a) v1\n.print tran v(a)\n.options acct\n")
    assert {n.what for n in found.notes} == {
        "model d, not used",
        ".tf analysis",
        ".print card",
        "option acct",
    }
    assert found.dropped == ()


@pytest.mark.parametrize("text", ["deck.cir", "../a/deck.sp", "t", ""])
def test_a_text_of_one_line_is_no_netlist(text: str) -> None:
    with pytest.raises(
        DataError, match=r"^netlist:1: .*; of a file give its Path, read_netlist\(Path\(...\)\)$"
    ):
        read_netlist(text)


def test_parameters_take_other_values_and_what_follows_them_follows() -> None:
    text = (
        "t\n.param r=1k c={2*r} q='3'\nv1 a 0 1\nr1 a 0 {r}\nr2 a 0 {c}\n.step param s list 5 6\nr3 a 0 {s}\n"
    )
    found = read_netlist(text)
    assert found.parameters == {"r": 1e3, "q": 3.0, "s": 5.0}
    assert [d.resistance for d in found.circuit.devices] == [1e3, 2e3, 5.0]
    other = read_netlist(text, parameters={"r": 3e3, "s": 6.0})
    assert [d.resistance for d in other.circuit.devices] == [3e3, 6e3, 6.0]
    with pytest.raises(DataError, match=r"^netlist:6: \.step param r3: nothing uses it; write \{r3\} in"):
        read_netlist(text.replace("param s list", "param r3 list").replace("{s}", "1"))
