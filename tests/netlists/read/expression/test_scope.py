"""Parameters in reach."""

import pytest

from circuits.errors import DataError
from netlists.read.card import Card
from netlists.read.expression.scope import Expressions, Scope
from netlists.read.limits import Limits

CARD = Card(".param", "a.cir", 3)


def define(scope: Scope, **texts: str) -> Scope:
    scope.define({name: (text, CARD) for name, text in texts.items()})
    return scope


def test_a_parameter_may_be_used_before_it_is_defined() -> None:
    scope = define(Scope(Limits()), a="{b*2}", b="'c+1'", c="1k")
    assert scope.values == {"a": 2002.0, "b": 1001.0, "c": 1000.0}


def test_a_long_chain_needs_no_recursion() -> None:
    count = 5000
    texts = {f"p{k}": f"{{p{k + 1}+1}}" for k in range(count)} | {f"p{count}": "0"}
    assert define(Scope(Limits()), **texts).values["p0"] == count


@pytest.mark.parametrize("texts", [{"a": "{a}"}, {"a": "{b}", "b": "{a}"}, {"a": "b", "b": "c", "c": "a+1"}])
def test_a_cycle_is_refused(texts: dict[str, str]) -> None:
    with pytest.raises(DataError, match=r"a\.cir:3: \.param .: defined by itself"):
        define(Scope(Limits()), **texts)


def test_a_section_sees_the_top_level_behind_its_own() -> None:
    top = define(Scope(Limits()), a="1", b="2")
    inner = define(Scope(Limits(), top), a="10")
    assert inner.number(CARD, "x", "{a+b}") == 12.0


def test_a_value_that_was_given_stays() -> None:
    scope = define(Scope(Limits(), values={"w": 5.0}), w="1", l="{w}")
    assert scope.values == {"w": 5.0, "l": 5.0}


def test_all_expressions_together_have_a_limit() -> None:
    texts = {f"p{k}": "1" + "+1" * 50 + f"+{k}" for k in range(20)}
    assert define(Scope(Limits(arithmetic=2100)), **texts).values["p3"] == 54.0
    with pytest.raises(DataError, match=r"\.param p9: .*more than 1000 characters of expressions, the limit"):
        define(Scope(Limits(arithmetic=1000)), **texts)
    cards = Expressions(Limits(arithmetic=1000), cards=60)  # a long netlist may have more
    assert define(Scope(Limits(), expressions=cards), **texts).values["p3"] == 54.0


def test_a_text_that_comes_again_is_not_parsed_again() -> None:
    top = Scope(Limits())
    text = "w*" * 40 + "w"
    for k in range(100):
        scope = Scope(Limits(), top, {"w": 1.0 + k / 1000.0})
        assert scope.number(CARD, "x", text) == pytest.approx((1.0 + k / 1000.0) ** 41, rel=1e-13)
    assert top.expressions is not None
    assert top.expressions.read < 25 * len(text)  # twice, then an eighth each


@pytest.mark.parametrize("word", ["1e999", "{1e308*1e308}", "nan", "inf", "{"])
def test_a_number_is_finite(word: str) -> None:
    with pytest.raises(DataError, match=r"a\.cir:3: r1: "):
        Scope(Limits()).number(CARD, "r1", word)


def test_mil_is_a_length_but_in_expressions_and_parameters() -> None:
    given = {"x": ("1mil", CARD), "q": ("'2*1mil'", CARD)}
    scope = Scope(Limits())
    scope.define(given)
    assert scope.values == {"x": 1e-3, "q": 2e-3}  # as ngspice has it
    assert scope.number(CARD, "r1", "1mil") == 25.4e-6
    assert scope.number(CARD, "r1", "{1mil}") == 1e-3
    assert scope.parameter(CARD, "x1.r", "1mil") == 1e-3
    with pytest.raises(DataError, match="mil in a B source, which ngspice takes in two ways"):
        scope.linear(CARD, "b1", "1mil*v(a)")
