"""Cards `.measure` as expressions, their values beside ngspice's own, and what is not taken over."""

import re

import pytest

from circuits.measure.measure import measure, read_measures
from circuits.measure.scope import Scope
from circuits.solver.transient import simulate
from netlists.ngspice.deadline import DEADLINE
from netlists.ngspice.library import simulated
from netlists.read.analysis import NoiseSpectrum
from netlists.read.netlist import read_netlist

CARDS = {
    "tran t trig v(a) val=1 rise=1 targ v(b) val=1 fall=2": "cross(v(b), 1.0, fall, 2)"
    " - cross(v(a), 1.0, rise, 1)",
    "tran t when v(b)=0.5 cross=last": "cross(v(b), 0.5, either, last)",
    "tran t when v(a)=v(b) td=1u": "cross(v(a) - v(b), 0, from=1e-06)",
    "tran m avg v(b) from=1m to=2m": "mean(v(b), from=0.001, to=0.002)",
    "tran m pp v(a,b)": "swing(v(a, b))",
    "tran m integ i(v1) to='2*tt'": "integral(i(v1), to=0.006)",
    "tran m find v(b) at=1m": "value(v(b), at=0.001)",
    "tran m find v(b) when v(a)=0.5 rise=2": "value(v(b), at=cross(v(a), 0.5, rise, 2))",
    "tran m deriv v(b) at=1m": "slope(v(b), at=0.001)",
    "tran m max par('v(a)-2*v(b)')": "max(v(a)-2*v(b))",
    "tran m min v(1)": "min(v(_1))",
    "dc m min_at v(x1.net-3)": "min_at(v(x1.net_x2d_3))",
    "ac m max vdb(b)": "max(db(v(b)))",
    "tran d param='m2-m1'": "m2-m1",
    "tran d param='m2*tt - m1/1meg'": "m2*0.003 - m1/1000000.0",
    "tran d param='2*tt+1'": "1.006",
    "tran d param='tt > 1m ? 5 : 7'": "5.0",
    "tran d param=neg": "-2.0",
    "tran d find par('v(a)*neg - 1.5m*v(b,tt)') at=1m": "value(v(a)*(-2.0) - 0.0015*v(b, tt), at=0.001)",
}


def deck(cards: list[str]) -> str:
    """A low-pass of 1 kOhm and 1 nF behind pulses, with these cards."""
    lines = (f".measure {card}" for card in cards)
    body = ["v1 a 0 pulse(0 1 1u 10n 10n 2u 5u)", "r1 a b 1k", "c1 b 0 1n", ".param tt=3m neg=-2", *lines]
    return "\n".join(["low pass", *body, ".tran 5n 15u 0 5n", ".end", ""])


@pytest.mark.parametrize(("card", "text"), CARDS.items())
def test_a_card_is_an_expression(card: str, text: str) -> None:
    (found,) = read_netlist(deck([card])).measures
    analysis, name, *_ = card.split()
    assert (found.analysis, found.text) == (analysis, f"{name} = {text}")
    nodes = frozenset({"a", "b", "tt", "_1", "x1.net_x2d_3"})
    scope = Scope(nodes, frozenset({"v1"}), transfer=analysis == "ac")
    before = ["m1 = 1", "m2 = 2"] if "m1" in text else []
    assert read_measures([*before, found.text], scope)[-1].name == name


@pytest.mark.parametrize(
    ("card", "why"),
    [("tran m err1 v(a) v(b)", "kind err1"), ("noise m max v(a)", "of analysis noise"),
     ("tran m when", "a vector"), ("tran m max q(a)", "vector q"), ("tran m max v(a) goal=3", "option goal"),
     ("tran m find v(a)", "neither at"),
     ("tran m trig v(a) val=1", "targ is missing"), ("tran m-1 max v(a)", "the name m-1"),
     ("tran m max v(a) 3", "3 at its end"), ("tran m trig v(a) rise=1 targ v(b) val=1", "val is missing")],
)  # fmt: skip
def test_a_card_of_another_kind_is_noted(card: str, why: str) -> None:
    found = read_netlist(deck([card]))
    (note,) = (str(note) for note in found.notes if "measure" in note.what)
    assert found.measures == ()
    assert f".measure card that is not taken over, {why}" in note


@pytest.mark.usefixtures("ngspice_library")
def test_values_are_those_of_ngspice() -> None:
    cards = [
        "tran t1 trig v(a) val=0.5 rise=1 targ v(b) val=0.5 fall=2", "tran t2 when v(b)=0.25 cross=last",
        "tran t3 when v(a)=v(b) fall=1 td=2u", "tran m1 avg v(b) from=2u to=12u",
        "tran m2 rms v(b) from=2u to=12u",
        "tran m3 pp v(b) from=2u to=12u", "tran m4 find v(b) at=3u", "tran m5 find v(b) when v(a)=0.5 fall=2",
        "tran m6 integ v(b) from=2u to=12u", "tran m7 max v(b)", "tran p param='t2-2*t1'",
    ]  # fmt: skip
    netlist = read_netlist(deck(cards))
    with simulated(deck(cards), DEADLINE) as library:
        said = "\n".join(library.output)
    theirs = {m[1]: float(m[2]) for m in re.finditer(r"^(\w+)\s+=\s+(\S+)", said, re.MULTILINE)}
    ours = measure(simulate(netlist.testbench), *(each.text for each in netlist.measures))
    for name, found in ours.items():
        # ngspice prints seven digits, and joins points 5 ns apart by straight lines
        assert found.value == pytest.approx(theirs[name], rel=2e-3, abs=3e-9), name


INSIDE = """two parts
.subckt part a b
r1 a m 1k
vx m n 0
l1 n b 1m
v2 k 0 1
r2 k b 1k
.ends
v1 b 0 2
x1 b a part
"""
NAMES = {  # what ngspice calls them, where the part is called beside another device, and where it is all
    "v(a)": ("a", "b"),
    "v(b)": ("b", "a"),
    "v(x1.m)": ("x1.m", "m"),
    "i(v1)": ("v1", "v1"),
    "i(v.x1.vx)": ("x1.vx", "vx"),
    "i(l.x1.l1)": ("x1.l1", "l1"),
    "i(v.x1.v2)": ("x1_x2e_v2", "x1_x2e_v2"),
}


@pytest.mark.parametrize(("name", "paths"), NAMES.items())
@pytest.mark.parametrize("is_all", [False, True])
def test_names_of_a_run_are_paths_of_the_circuit(name: str, paths: tuple[str, str], is_all: bool) -> None:
    more = "" if is_all else "r9 a 0 1k\n"
    found = read_netlist(
        f"{INSIDE}{more}.tran 1n 10n\n.meas tran t max {name}\n.meas tran u max par('2*{name}')\n"
    )
    path = paths[is_all]
    assert [m.text for m in found.measures] == [
        f"t = max({name[0]}({path}))",
        f"u = max(2*{name[0]}({path}))",
    ]
    measure(simulate(found.testbench), *(m.text for m in found.measures))


def test_the_nodes_of_noise_are_paths_of_the_circuit() -> None:
    found = read_netlist(f"{INSIDE}.noise v(a,x1.m) v1 dec 2 1 10\n.noise v(b) v1 dec 2 1 10\n")
    ends = [(a.output, a.reference) for a in found.analyses if isinstance(a, NoiseSpectrum)]
    assert ends == [("b", "m"), ("a", "0")]


def test_what_is_before_the_start_of_a_transient_is_not_measured() -> None:
    cards = [
        "tran a max v(b)",
        "tran b avg v(b) from=1u to=9u",
        "tran c avg v(b) from=8u",
        "tran d when v(b)=0.5 rise=1",
        "tran e trig at=1u targ v(b) val=0.5 td=2u",
        "ac f max vm(b)",
    ]
    text = deck(cards).replace(".tran 5n 15u 0 5n", ".tran 5n 15u 7u 5n")
    assert [m.text for m in read_netlist(text).measures] == [
        "a = max(v(b), from=7e-06)",
        "b = mean(v(b), from=7e-06, to=9e-06)",
        "c = mean(v(b), from=8e-06)",
        "d = cross(v(b), 0.5, rise, 1, from=7e-06)",
        "e = cross(v(b), 0.5, from=7e-06) - 1e-06",
        "f = max(mag(v(b)))",
    ]
