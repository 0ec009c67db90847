"""Quantities as text: what is read, what is refused, and the round trip."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from circuits.errors import ParameterError
from circuits.units import format_quantity, parse_quantity

SUFFIXES = {
    "f": 1e-15,
    "p": 1e-12,
    "n": 1e-9,
    "u": 1e-6,
    "m": 1e-3,
    "k": 1e3,
    "meg": 1e6,
    "g": 1e9,
    "t": 1e12,
}
UNITS = ["", "A", "F", "Hz", "K", "Ohm", "S", "V", "V/s", "W", "deg", "degC", "m", "m/s", "rad", "s"]


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("600fF", "F", 600e-15),
        ("600f", "F", 600e-15),
        ("1FF", "F", 1e-15),
        ("12ms", "s", 12e-3),
        ("12Ms", "s", 12e-3),
        ("199.9pA", "A", 199.9e-12),
        ("5V", "V", 5.0),
        ("-.5V", "V", -0.5),
        ("1.8", "V", 1.8),
        ("+1e-3", "V", 1e-3),
        ("1e3mV", "V", 1.0),
        ("10MEG", "Ohm", 10e6),
        ("10megHz", "Hz", 10e6),
        ("10M", "Ohm", 10e-3),
        ("10kOhm", "Ohm", 10e3),
        ("3mm", "m", 3e-3),
        ("3um", "m", 3e-6),
        ("3", "m", 3.0),
        ("3m/s", "m/s", 3.0),
        ("3mm/s", "m/s", 3e-3),
        ("300", "K", 300.0),
        ("300mK", "K", 0.3),
        ("-40", "degC", -40.0),
        ("27degC", "degC", 27.0),
        ("10m", "", 10e-3),
        (" 5V ", "V", 5.0),
    ],
)
def test_reads(text: str, unit: str, value: float) -> None:
    assert parse_quantity(text, unit, "name") == value


@pytest.mark.parametrize(
    ("text", "unit", "message"),
    [
        ("12mV", "s", 'name: "12mV", must be a time in s; write 12ms'),
        ("12mS", "s", 'name: "12mS", must be a time in s; write 12ms'),
        ("5v", "V", 'name: "5v", must be a voltage in V; write 5V'),
        ("12\u00b5s", "s", 'name: "12\u00b5s", must be a time in s; write 12us'),
        ("300K", "degC", 'name: "300K", must be a temperature in degC; write a plain number, in degC'),
        ("27m", "degC", 'name: "27m", must be a temperature in degC; write a plain number, in degC'),
        (
            "12min",
            "s",
            'name: "12min", must be a time in s; write a number with its suffix and unit, such as 12ms',
        ),
        (
            "abc",
            "s",
            'name: "abc", must be a time in s; write a number with its suffix and unit, such as 12ms',
        ),
        ("4V", "", 'name: "4V", must be a plain number; write the number alone'),
        ("1e999", "V", 'name: "1e999", must be a voltage in V and finite; write a smaller number'),
    ],
)
def test_refuses_with_a_remedy(text: str, unit: str, message: str) -> None:
    with pytest.raises(ParameterError) as caught:
        parse_quantity(text, unit, "name")
    assert str(caught.value) == message


@pytest.mark.parametrize(
    ("text", "unit", "prefix", "remedy"),
    [
        ("600F", "F", "femto", "600 for 600 F, or 600fF"),
        ("3m", "m", "milli", "3 for 3 m, or 3mm"),
        ("300K", "K", "kilo", "300 for 300 K, or 300kK"),
    ],
)
def test_refuses_a_suffix_that_is_also_the_unit(text: str, unit: str, prefix: str, remedy: str) -> None:
    with pytest.raises(ParameterError) as caught:
        parse_quantity(text, unit, "name")
    assert str(caught.value).endswith(f"without a bare {unit}, which is also {prefix}; write {remedy}")


@pytest.mark.parametrize(
    "text", ["", "nan", "inf", "-inf", "1 ms", "1,5V", "1mil", "1xV", "1VV", "0x10", "1e", "1_0", "\u0661V"]
)
def test_refuses(text: str) -> None:
    with pytest.raises(ParameterError):
        parse_quantity(text, "V", "name")


@pytest.mark.parametrize(
    ("value", "unit", "text"),
    [
        (12e-3, "s", "12ms"),
        (600e-15, "F", "600fF"),
        (10e6, "Ohm", "10megOhm"),
        (0.9999999, "V", "1V"),
        (999.9999, "V", "1kV"),
        (0.0, "V", "0V"),
        (-5.0, "V", "-5V"),
        (3.0, "m", "3000mm"),
        (1e-18, "A", "0.001fA"),
        (1e20, "s", "1e+08ts"),
        (0.7, "", "0.7"),
        (27.0, "degC", "27degC"),
        (float("nan"), "s", "nan s"),
        (float("-inf"), "", "-inf"),
    ],
)
def test_writes(value: float, unit: str, text: str) -> None:
    assert format_quantity(value, unit) == text


@given(
    value=st.floats(allow_nan=False, allow_infinity=False, max_value=1e300, min_value=-1e300),
    unit=st.sampled_from(UNITS),
)
def test_what_is_written_is_read_back(value: float, unit: str) -> None:
    # six significant digits are off by half a unit of the sixth; the absolute part is the smallest float
    assert parse_quantity(format_quantity(value, unit), unit, "name") == pytest.approx(
        value, rel=5.1e-6, abs=5e-324
    )


@given(
    mantissa=st.decimals(min_value=-1000, max_value=1000, places=3),
    suffix=st.sampled_from(sorted(SUFFIXES)),
    upper=st.booleans(),
)
def test_a_suffix_scales_whatever_its_case(mantissa: object, suffix: str, upper: bool) -> None:
    text = f"{mantissa}{suffix.upper() if upper else suffix}V"
    # parsing rounds once, the product here twice
    assert parse_quantity(text, "V", "name") == pytest.approx(
        float(str(mantissa)) * SUFFIXES[suffix], rel=1e-15
    )


@given(text=st.text(max_size=12) | st.from_regex(r"[-+0-9.]{1,6}[a-zA-Z]{0,4}", fullmatch=True))
def test_any_text_is_read_or_refused(text: str) -> None:
    try:
        value = parse_quantity(text, "V", "name")
    except ParameterError:
        return
    assert math.isfinite(value)
