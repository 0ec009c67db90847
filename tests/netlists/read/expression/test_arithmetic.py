"""Functions of parameters' values, and sums of node voltages."""

import pytest

from netlists.read.expression.arithmetic import (
    FUNCTIONS,
    OPERATORS,
    ExpressionError,
    Linear,
    applied,
    choice,
    constant,
    joined,
    parameter,
    signed,
    voltage,
)


def nothing(name: str) -> float | None:
    """Look up where there are no parameters."""
    return None


def test_a_parameter_is_looked_up_when_the_value_is_asked_for() -> None:
    twice = joined(parameter("w"), [(OPERATORS["+"][1], parameter("w"))])
    assert twice({"w": 2.0}.get) == 4.0
    assert twice({"w": 3.0}.get) == 6.0
    assert parameter("pi")(nothing) == pytest.approx(3.14159265358979)
    assert parameter("pi")({"pi": 3.0}.get) == 3.0
    with pytest.raises(ExpressionError, match="w: unknown parameter"):
        twice(nothing)


def test_voltages_add_and_cancel() -> None:
    difference = voltage(" a , b ")(nothing)
    assert difference == Linear(0.0, {"a": 1.0, "b": -1.0})
    plus = OPERATORS["+"][1]
    assert plus(difference, voltage("b")(nothing)) == Linear(0.0, {"a": 1.0})
    assert OPERATORS["*"][1](2.0, difference) == Linear(0.0, {"a": 2.0, "b": -2.0})
    assert signed(constant(difference), ["-"])(nothing) == Linear(-0.0, {"a": -1.0, "b": 1.0})


def test_a_sum_of_many_voltages_is_refused_before_it_costs_time() -> None:
    operands = [(OPERATORS["+"][1], voltage(f"n{k}")) for k in range(2000)]
    with pytest.raises(ExpressionError, match="more than 64 node voltages in a sum"):
        joined(constant(0.0), operands)(nothing)


def test_a_choice_needs_a_number_to_choose_by() -> None:
    assert choice(constant(1.0), constant(2.0), constant(3.0))(nothing) == 2.0
    assert choice(constant(0.0), constant(2.0), voltage("a"))(nothing) == Linear(0.0, {"a": 1.0})
    with pytest.raises(ExpressionError, match="not linear"):
        choice(voltage("a"), constant(2.0), constant(3.0))(nothing)


@pytest.mark.parametrize("name", sorted(FUNCTIONS))
def test_a_function_outside_its_range_says_so_or_has_a_value(name: str) -> None:
    count, function = FUNCTIONS[name]
    try:
        value = applied(name, function, [constant(-1e300)] * count)(nothing)
    except ExpressionError as error:
        assert str(error).startswith(f"{name}(-1e+300")  # noqa: PT017 - both are allowed
    else:
        assert isinstance(value, float)
