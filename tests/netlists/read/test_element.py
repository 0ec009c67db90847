"""Element cards to devices."""

import pytest

from circuits.circuit import GROUND
from circuits.devices import Capacitor, ControlledSource, Device, Resistor, Transistor
from circuits.errors import DataError
from circuits.silicon.silicon import Deviation
from netlists.read.card import Card
from netlists.read.element import Context, Element, read_element
from netlists.read.expression.scope import Scope
from netlists.read.limits import Limits
from netlists.read.note import Notes
from netlists.read.text.name import circuit_name
from netlists.read.text.section import Model, Section
from tests.refusals import refusals

CARD = Card(".model", "a.cir", 2)


def read(text: str, notes: Notes | None = None, *, is_cdl: bool = False) -> Element:
    section = Section("", CARD, None)
    section.models = {
        "nch": Model("nch", "nmos", {}, CARD),
        "own": Model("own", "nmos", {"level": "8"}, CARD),
        "pch": Model("pch", "pmos", {}, CARD),
        "d1": Model("d1", "d", {}, CARD),
    }
    scope = Scope(Limits(), values={"w0": 3e-6})
    found = Notes() if notes is None else notes
    own = Context(section, scope, lambda n: GROUND if n == "0" else circuit_name(n), found, is_cdl)
    return read_element(Card(text, "a.cir", 9), own)


@pytest.mark.parametrize(
    ("text", "device"),
    [
        ("R1 a 0 10k", Resistor("r1", "a", "0", 1e4)),
        ("r1 a b r={2*w0}", Resistor("r1", "a", "b", 6e-6)),
        ("C1 1 a 1pF", Capacitor("c1", "_1", "a", 1e-12)),
        ("c1 a b 2p m=3", Capacitor("c1", "a", "b", 6e-12)),
        ("r1 a b 6k m=3", Resistor("r1", "a", "b", 2e3)),
        ("g1 a b c 0 1u", ControlledSource("g1", "a", "b", "c", "0", 1e-6)),
        ("b1 a 0 I=2u*(v(x)-v(y))", ControlledSource("b1", "a", "0", "x", "y", 2e-6)),
        ("b1 a 0 i={v(x,y)*1m}", ControlledSource("b1", "a", "0", "x", "y", 1e-3)),
        ("g1 a 0 cur='-v(x)'", ControlledSource("g1", "a", "0", "x", "0", -1.0)),
        ("m1 d g s b nch w=w0 l=1.5u", Transistor("m1", "n", "d", "g", "s", "b", 3e-6, 1.5e-6)),
        ("M1 D G S 0 PCH W={w0} L=1U M=2", Transistor("m1", "p", "d", "g", "s", "0", 3e-6, 1e-6, 2.0)),
    ],
)
def test_device(text: str, device: Device) -> None:
    assert read(text) == Element(device)


@pytest.mark.parametrize(
    ("model", "deviation"), [("nch", Deviation(-0.05, 0.25)), ("pch", Deviation(0.05, 0.25))]
)
def test_delvto_is_signed_and_a_deviation_is_of_the_magnitude(model: str, deviation: Deviation) -> None:
    assert read(f"m1 d g s b {model} w=1u l=1u delvto=-50m mulu0=1.25").deviation == deviation


def test_a_layout_has_no_models() -> None:
    notes = Notes()
    found = read("m1 d g s b pfet_hv w=1u l=1u", notes, is_cdl=True)
    assert found.device == Transistor("m1", "p", "d", "g", "s", "b", 1e-6, 1e-6)
    assert notes.all()[0].what == "polarity of model pfet_hv taken from its first letter"


def test_what_no_device_carries_is_noted() -> None:
    notes = Notes()
    read("m1 d g s b nch w=1u l=1u ad=1p pd=2u", notes)
    read("c1 a b 1p ic=0", notes)
    assert [note.what for note in notes.all()] == [
        "ad of a transistor",
        "pd of a transistor",
        "ic of a capacitor, which a run without uic does not use",
    ]


def test_a_model_with_figures_of_its_own_is_refused_at_its_card() -> None:
    with pytest.raises(
        DataError, match=r"^a\.cir:2: \.model own: parameters level: not honoured; .* `drop=own`$"
    ):
        read("m1 d g s b own w=1u l=1u")


test_refused_with_its_place = refusals(
    DataError,
    read,
    [
        ("1 a b c npn", "1: unknown element; known are A, B, C, D, E, "),
        ("r1 a b", "r1: without a value"),
        ("r1 a", "r1: without"),
        ("r1 a b 1k 2k", "2k is not understood"),
        ("r1 a b 1k m=0", "r1.m: 0, must be > 0; correct it"),
        ("r1 a b x", "r1: x: x: unknown parameter"),
        ("m1 d g s nch w=1u l=1u", "must be 4 nodes and a model"),
        ("m1 d g s b nch l=1u", "m1.w: missing; write W= in metre"),
        ("m1 d g s b nch w=1u", "m1.l: missing"),
        ("m1 d g s b none w=1u l=1u", "model none: unknown"),
        ("m1 d g s b d1 w=1u l=1u", r"type d, must be nmos or pmos; see a\.cir:2"),
        ("m1 d g s b nch w=1u l=1u x=1", "m1.x: unknown parameter"),
        ("m1 d g s b nch w=1u l=1u temp=9", "temp of a transistor: not honoured"),
        ("c1 a b 1p tc2=1u", "tc2 of a capacitor: not honoured"),
        ("g1 a b poly(1) c d 1", "not understood|POLY"),
        ("b1 a 0 v=1", "supported is I= linear in one voltage difference"),
        ("b1 a 0 i=v(x)^2", "b1 .supported is .*: not linear"),
        ("b1 a 0 i=tanh(v(x,y))", "b1 .supported is .*: not linear .*; write M, R, C and G elements for it"),
        ("b1 a 0 i=v(x)>1 ? 1u : 2u", "not linear in one voltage difference"),
        ("b1 a 0 i=v(x)*v(y)", "not linear in one voltage difference"),
        ("g1 a 0 value={exp(v(x))}", "g1 .supported is .*: not linear"),
        ("b1 a 0 i=1u", "not one voltage difference"),
        ("b1 a 0 i=v(x)+1", "not one voltage difference"),
        ("b1 a 0 i=v(x)+v(y)", "must be opposite"),
        ("b1 a 0 i=v(x)+v(y)+v(z)", "not one voltage difference"),
    ],
    start=r"^a\.cir:9: .*",
)
