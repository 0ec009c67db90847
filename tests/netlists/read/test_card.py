"""Words of a card."""

import pytest

from circuits.errors import DataError
from netlists.read.card import Card, arguments, shown


def card(text: str) -> Card:
    return Card(text, "a.cir", 7)


def test_words() -> None:
    words = card("M1 D g,S 0 nch W={2 * w0} l='a b' PULSE(0 5)").words()
    assert words == [
        "m1", "d", "g", "s", "0", "nch", "w", "=", "{2 * w0}", "l", "=", "'a b'", "pulse", "(", "0", "5", ")",
    ]  # fmt: skip


@pytest.mark.parametrize("text", ["r1 a b {1", "r1 a b 1}", "r1 'a", 'r1 "a'])
def test_half_a_bracket_is_refused_with_its_place(text: str) -> None:
    with pytest.raises(DataError, match=r"a\.cir:7: .* without its other half"):
        card(text).words()


def test_the_name_is_the_first_word() -> None:
    assert card("X1(a b) sub").name() == card("X1(a b) sub").words()[0] == "x1"
    assert card(",,").name() == ""


def test_arguments_are_parted() -> None:
    own = card("x1 a b (c) sub p = 1 q={2}")
    found = arguments(own, own.words())
    assert found.positional == ["x1", "a", "b", "c", "sub"]
    assert found.named == {"p": "1", "q": "{2}"}


@pytest.mark.parametrize("text", ["= 1", "r1 a=", "r1 a = = 1", "r1 a=1 a=2"])
def test_a_name_needs_one_value(text: str) -> None:
    own = card(text)
    with pytest.raises(DataError, match=r"a\.cir:7: "):
        arguments(own, own.words())


def test_a_text_is_shown_in_one_short_line() -> None:
    assert shown("a\nb\x1b[0m") == "a\\nb\\x1b[0m"
    assert len(shown("x" * 1000)) == 63
