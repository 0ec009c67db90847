"""Cards to sections."""

from circuits.errors import DataError
from netlists.read.expression.arithmetic import Function
from netlists.read.limits import Limits
from netlists.read.note import Notes
from netlists.read.text.lines import read_text
from netlists.read.text.section import Deck, read_deck
from tests.refusals import refusals


def read(text: str) -> Deck:
    notes = Notes()
    return read_deck("t", read_text("t\n" + text, None, Limits(), notes).cards, notes)


def test_sections_stand_in_one_another() -> None:
    deck = read(
        ".SUBCKT a p q PARAMS: w=1u\nr1 p q 1\n.subckt b x\nr1 x 0 1\n.ends b\n.ends\n"
        ".model n nmos (vto=1)\nr2 a 0 1"
    )
    a = deck.top.children["a"]
    assert (a.ports, a.defaults) == (("p", "q"), {"w": "1u"})
    assert a.find_section("b") is a.children["b"]
    assert a.children["b"].find_section("a") is a
    assert deck.top.find_section("b") is None
    model = a.children["b"].find_model("n")
    assert model is not None
    assert (model.type, model.parameters) == ("nmos", {"vto": "1"})
    assert [card.text for card in deck.top.elements] == ["r2 a 0 1"]


def test_parameters_globals_and_controls() -> None:
    deck = read(".param a=1 b={a+1}\n.global vdd vss vdd\n.tran 1u 1m")
    assert {name: text for name, (text, _) in deck.top.parameters.items()} == {"a": "1", "b": "{a+1}"}
    assert list(deck.global_nodes) == ["vdd", "vss"]
    assert [card.text for card in deck.controls] == [".tran 1u 1m"]


def test_a_parameter_given_again_counts_last_and_needs_no_braces() -> None:
    deck = read(
        ".param a = 1 + 2 b='3 * a', c={max(a, b)}\n.param a=4\n.param f(x, y) = {x*y}\n.func g(x) x+1"
    )
    assert {n: text for n, (text, _) in deck.top.parameters.items()} == {
        "a": "4",
        "b": "'3 * a'",
        "c": "{max(a, b)}",
    }
    assert deck.functions == {"f": Function(("x", "y"), "{x*y}"), "g": Function(("x",), "x+1")}


def test_an_end_of_another_name_is_noted() -> None:
    notes = Notes()
    read_deck("t", read_text("t\n.subckt a p\n.ends b", None, Limits(), notes).cards, notes)
    assert [note.what for note in notes.all()] == [".ends b closes a"]


test_refused = refusals(
    DataError,
    read,
    [
        (".subckt a p", "netlist:2: .subckt a: not closed"),
        (".ends", "netlist:2: .ends without .subckt"),
        (".subckt", "no name"),
        (".subckt a p\n.ends\n.subckt A q\n.ends", "netlist:4: .subckt a: duplicate name, also at netlist:2"),
        (".subckt a p p\n.ends", "port p given twice"),
        (".param a", "must be name=value"),
        (".param a=", "a=: no value"),
        (".func f(x)", "must be NAME"),
        (".func f(x) {x}\n.func f(x) {2*x}", "given twice, and not alike"),
        (".subckt a p\n.if (1)\n.param x=1\n.endif\n.ends", "netlist:4: .param: under .if in a sub-circuit"),
        (".model n", "no name or no type"),
        (".model n nmos\n.model n pmos", "duplicate name, also at netlist:2"),
        (".if (1)", ".if without .endif"),
        (".endif", ".endif without .if"),
        (".if (1)\n" * 17, "netlist:18: .if: deeper than 16, the limit"),
        (".if", "no condition"),
        ("\n".join(f".subckt s{k} a" for k in range(17)), "deeper than 16 sub-circuits, the limit"),
    ],
)
