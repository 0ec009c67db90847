"""The evaluator of expressions."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from netlists.read.expression.arithmetic import Function
from netlists.read.expression.expression import ExpressionError, Functions, linear_of, number_of, parse
from netlists.read.limits import Limits
from tests.refusals import refusals

PARAMETERS = {"a": 2.0, "w0": 3e-6}


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1+2*3", 7.0),
        ("(1+2)*3", 9.0),
        ("2^3^2", 64.0),  # this and the next as ngspice 39 has it
        ("2^-3^2", 0.015625),
        ("(0-2)^3", 8.0),
        ("(0-2)**3 + pow(0-2,3)", 0.0),
        ("-2^2", -4.0),
        ("2**-1", 0.5),
        ("7%4", 3.0),
        ("1-2-3", -4.0),
        ("8/4/2", 1.0),
        ("2*w0", 6e-6),
        ("a>1 ? 10k : 20k", 10e3),
        ("a==2 && !(a<1) || 0", 1.0),
        ("max(1,a)+min(1,a)", 3.0),
        ("sqrt(a*a)", 2.0),
        ("log(exp(1))", 1.0),
        ("pwr(-8,2) + pwr(-2,3)", 72.0),
        ("2*pi", 2.0 * math.pi),
        ("1meg+1m", 1e6 + 1e-3),
        ("0 ? 1/a : 5", 5.0),
        ("{1 + {a}} * 2", 6.0),
        ("arctan(0) + sqr(a) + ternary_fcn(1, 2, 3)", 6.0),
    ],
)
def test_value(text: str, value: float) -> None:
    assert number_of(parse(text), PARAMETERS.get) == pytest.approx(value, rel=1e-15)


def test_functions_of_a_netlist_use_their_arguments_and_each_other() -> None:
    known = {
        "f": Function(("x", "y"), "{x*g(y)}"),
        "g": Function(("x",), "x + a"),
        "pi2": Function((), "2*pi"),
    }
    found = parse("f(1+2, 4) + pi2()", functions=Functions(known))
    assert number_of(found, PARAMETERS.get) == pytest.approx(18.0 + 2.0 * math.pi, rel=1e-15)


def test_functions_that_call_themselves_or_each_other_too_often_are_refused() -> None:
    loop = Functions({"f": Function(("x",), "g(x)"), "g": Function(("x",), "f(x)")})
    with pytest.raises(ExpressionError, match="calls itself"):
        parse("f(1)", functions=loop)
    chain = {f"f{k}": Function(("x",), f"f{k + 1}(x)") for k in range(300)}
    with pytest.raises(ExpressionError, match="more than 32 functions in one another"):
        parse("f0(1)", functions=Functions(chain))
    tower = {f"f{k}": Function(("x",), f"f{k + 1}(x) + f{k + 1}(x)") for k in range(20)}
    with pytest.raises(ExpressionError, match="more than 1000 calls"):
        parse("f0(1)", functions=Functions({**tower, "f20": Function(("x",), "x")}))


test_refused = refusals(
    ExpressionError,
    lambda text: number_of(parse(text), PARAMETERS.get),
    [
        ("", "the end where a value is needed"),
        ("1+", "the end where a value is needed"),
        ("(1", "where \\) is needed"),
        ("1 2", "after a whole expression"),
        ("b", "unknown parameter"),
        ("agauss(1,2,3)", "a function of ngspice alone"),
        ("sqrt(1,2)", "2 arguments, must be 1"),
        ("sqrt(-1)", "outside the function's range"),
        ("1/0", "division by zero"),
        ("9^9^9^9", "outside the function's range"),
        ("1e308*10", "not finite"),
        ("v(x)", "a number is needed"),
        ("__import__('os')", "unknown function|no part of an expression"),
        ("a.real.__class__", "unknown parameter"),
        ("1;2", "no part of an expression"),
    ],
)


@pytest.mark.parametrize("text", ["(" * 100 + "1" + ")" * 100, "2^" * 100 + "1", "1?" * 100 + "1"])
def test_depth_has_a_limit(text: str) -> None:
    with pytest.raises(ExpressionError, match="more than 32"):
        number_of(parse(text), PARAMETERS.get)


def test_length_has_a_limit() -> None:
    with pytest.raises(ExpressionError, match="an expression may have 10"):
        parse("1+1+1+1+1+1", Limits(expression=10))


@pytest.mark.parametrize(
    ("text", "constant", "slopes"),
    [
        ("1u*(v(a)-v(b))", 0.0, {"a": 1e-6, "b": -1e-6}),
        ("v(a,b)/2", 0.0, {"a": 0.5, "b": -0.5}),
        ("-v(net-3)*a", 0.0, {"net-3": -2.0}),
        ("1+v(a)-v(a)", 1.0, {}),
        ("2*(v( x#1 )+1)", 2.0, {"x#1": 2.0}),
    ],
)
def test_linear_in_voltages(text: str, constant: float, slopes: dict[str, float]) -> None:
    found = linear_of(parse(text), PARAMETERS.get)
    assert found.constant == constant
    assert dict(found.slopes) == slopes


@pytest.mark.parametrize("text", ["v(a)*v(b)", "v(a)^2", "exp(v(a))", "1/v(a)", "v(a)>1 ? 1 : 2"])
def test_not_linear(text: str) -> None:
    with pytest.raises(ExpressionError, match="not linear"):
        linear_of(parse(text), PARAMETERS.get)


@given(st.text(alphabet="0123456789.+-*/^()?:<>=!&|,ave \t\x00é'\"", max_size=60))
def test_any_text_gives_a_finite_number_or_an_error(text: str) -> None:
    try:
        value = number_of(parse(text), PARAMETERS.get)
    except ExpressionError as error:
        value, text = 0.0, str(error)
    assert math.isfinite(value)
    assert value != 0.0 or "\n" not in text
