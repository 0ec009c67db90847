"""Cards against what their notes write."""

import pytest

from circuits.errors import DataError
from netlists.read.card import Card
from netlists.read.notes.syntax import Syntax, syntax_of
from netlists.read.notes.verify import verify


def cards(*texts: str) -> list[Card]:
    return [Card(text, "a.cir", k) for k, text in enumerate(texts, 1)]


def ngspice() -> Syntax:
    syntax = syntax_of("ngspice")
    assert syntax is not None
    return syntax


@pytest.mark.parametrize(
    ("own", "again"),
    [
        ("r1 a b 1000.0", "r1 a b 1000.0"),
        ("R1  A b 1K", "r1 a b 1000.0"),
        ("b1 a b i=1.00000000001*v(a)", "b1 a b i=1.0*v(a)"),
    ],
)
def test_alike(own: str, again: str) -> None:
    controls = ".options b=2", ".save v(a)"
    verify(cards(own, ".options a=1"), cards(again, *controls), ngspice())
    with pytest.raises(DataError, match="edited"):  # what is passed over is not the line itself
        verify(cards(own.replace(" b ", " other "), ".options a=1"), cards(again, *controls), ngspice())


@pytest.mark.parametrize(
    ("own", "again", "says"),
    [
        (
            ["r1 a b 1000.1"],
            ["r1 a b 1000.0"],
            "a.cir:1: r1: edited, r1 a b 1000.1 is r1 a b 1000.0 by its notes",
        ),
        (["r1 a1 b 1"], ["r1 a01 b 1"], "a.cir:1: r1: edited"),
        (["b1 a b i=v(a)"], ["b1 a b i=v(b)"], "edited"),
        (["r1 a b 1", "r2 a b 1"], ["r1 a b 1"], "a.cir:2: r2 a b 1: added"),
        (["r1 a b 1"], ["r1 a b 1", "r2 a b 1"], "a.cir:1: r2 a b 1: missing behind this line"),
    ],
)
def test_not_alike(own: list[str], again: list[str], says: str) -> None:
    with pytest.raises(DataError, match=says):
        verify(cards(*own), cards(*again), ngspice())


def test_a_long_line_is_held_against_another_at_once() -> None:
    with pytest.raises(DataError, match="edited"):
        verify(cards("r1 a b " + "1" * 500_000 + "_"), cards("r1 a b " + "1" * 500_000 + "#"), ngspice())


def test_what_differs_is_shown_however_long_the_line_is() -> None:
    long = "b1 a b i=" + "1.0*v(a)+" * 50
    with pytest.raises(DataError, match=r"v\(other\) is .*v\(c\) by its notes"):
        verify(cards(long + "v(other)"), cards(long + "v(c)"), ngspice())
