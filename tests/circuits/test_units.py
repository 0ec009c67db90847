"""Quantities as text: what is read, what is refused, and the round trip."""

import math
from dataclasses import dataclass, fields

import pytest
from hypothesis import given
from hypothesis import strategies as st

from circuits.errors import ParameterError
from circuits.units import format_quantity, parse_quantity, quantity, unit_of_name

PREFIXES = {
    "a": 1e-18,
    "f": 1e-15,
    "p": 1e-12,
    "n": 1e-9,
    "u": 1e-6,
    "\u00b5": 1e-6,
    "\u03bc": 1e-6,
    "m": 1e-3,
    "k": 1e3,
    "M": 1e6,
    "G": 1e9,
    "T": 1e12,
}
UNITS = [
    "",
    "A",
    "F",
    "Hz",
    "K",
    "Ohm",
    "S",
    "V",
    "V/s",
    "W",
    "deg",
    "degC",
    "lux",
    "m",
    "m/s",
    "rad",
    "s",
    "um",
]


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("600fF", "F", 600e-15),
        ("600f", "F", 600e-15),
        ("1000mF", "F", 1.0),
        ("12ms", "s", 12e-3),
        ("12Ms", "s", 12e6),
        ("1MHz", "Hz", 1e6),
        ("1mHz", "Hz", 1e-3),
        ("3mV", "V", 3e-3),
        ("10\u00b5A", "A", 10e-6),
        ("10\u03bcA", "A", 10e-6),
        ("10uA", "A", 10e-6),
        ("199.9pA", "A", 199.9e-12),
        ("1a", "A", 1e-18),
        ("5V", "V", 5.0),
        ("-.5V", "V", -0.5),
        ("+1e-3V", "V", 1e-3),
        ("1e3mV", "V", 1.0),
        ("10Meg", "Ohm", 10e6),
        ("10MEG", "Ohm", 10e6),
        ("10megHz", "Hz", 10e6),
        ("10MOhm", "Ohm", 10e6),
        ("10kOhm", "Ohm", 10e3),
        ("3m", "m", 3.0),
        ("3mm", "m", 3e-3),
        ("3um", "m", 3e-6),
        ("3u", "m", 3e-6),
        ("8um", "um", 8.0),
        ("180nm", "um", 0.18),
        ("8e-6m", "um", 8.0),
        ("3m/s", "m/s", 3.0),
        ("3mm/s", "m/s", 3e-3),
        ("300K", "K", 300.0),
        ("300mK", "K", 0.3),
        ("-40", "degC", -40.0),
        ("27degC", "degC", 27.0),
        ("40deg", "deg", 40.0),
        ("10m", "", 10e-3),
        ("2k", "", 2000.0),
        ("2Meg", "", 2e6),
        ("0.3", "", 0.3),
        ("0", "V", 0.0),
        ("0.0", "F", 0.0),
        (" 5V ", "V", 5.0),
    ],
)
def test_reads(text: str, unit: str, value: float) -> None:
    assert parse_quantity(text, unit, "name") == value


@pytest.mark.parametrize(
    ("text", "unit", "message"),
    [
        ("600", "F", "a capacitance in F; write the unit too, as in 600fF"),
        ("40", "A", "a current in A; write the unit too, as in 40pA"),
        ("1e-3", "V", "a voltage in V; write the unit too, as in 1mV"),
        ("1e-15", "F", "a capacitance in F; write the unit too, as in 1fF"),
        ("8", "um", "a length in m; write the unit too, as in 8um"),
        ("3", "m/s", "a speed in m/s; write the unit too, as in 3m/s"),
        ("1e3", "V/s", "a quantity in V/s; write the unit too, as in 1kV/s"),
        ("1M", "Hz", "a frequency in Hz; write 1mHz or 1MHz"),
        ("1M", "", "a plain number; write 1m or 1Meg"),
        ("1mhz", "Hz", "a frequency in Hz; write 1mHz or 1MHz"),
        ("10KOhm", "Ohm", "a resistance in Ohm; write 10kOhm"),
        ("12mS", "s", "a time in s; write 12ms or 12Ms"),
        ("5v", "V", "a voltage in V; write 5V"),
        ("1FF", "F", "a capacitance in F; write 1fF"),
        ("0.75A", "V", "a voltage in V; write a number and its unit, such as 0.75V"),
        ("40V", "A", "a current in A; write a number and its unit, such as 40pA"),
        ("12mV", "s", "a time in s; write a number and its unit, such as 12s"),
        ("12min", "s", "a time in s; write a number and its unit, such as 12s"),
        ("abc", "s", "a time in s; write a number and its unit, such as 12s"),
        ("300K", "degC", "a temperature in degC; write the number alone, such as 300"),
        ("27m", "degC", "a temperature in degC; write the number alone, such as 27"),
        ("4V", "", "a plain number; write the number alone, such as 4"),
        ("1e999V", "V", "a voltage in V and finite; write a smaller number"),
        ("600F", "F", "a capacitance in F without a bare F, which is also femto; write 600000mF, or 600fF"),
    ],
)
def test_refuses_with_a_remedy(text: str, unit: str, message: str) -> None:
    with pytest.raises(ParameterError) as caught:
        parse_quantity(text, unit, "name")
    assert str(caught.value) == f'name: "{text}", must be {message}'


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
        (10e6, "Ohm", "10MOhm"),
        (0.9999999, "V", "1V"),
        (999.9999, "V", "1kV"),
        (0.0, "V", "0V"),
        (-5.0, "V", "-5V"),
        (3.0, "m", "3m"),
        (3.0, "F", "3000mF"),
        (0.18, "um", "180nm"),
        (1e-21, "A", "0.001aA"),
        (1e20, "s", "1e+08Ts"),
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
    prefix=st.sampled_from(sorted(PREFIXES)),
)
def test_a_prefix_scales(mantissa: object, prefix: str) -> None:
    # parsing rounds once, the product here twice
    assert parse_quantity(f"{mantissa}{prefix}V", "V", "name") == pytest.approx(
        float(str(mantissa)) * PREFIXES[prefix], rel=1e-15
    )


@pytest.mark.parametrize("unit", [u for u in UNITS if u not in {"", "degC"}])
def test_no_number_alone_where_there_is_a_unit(unit: str) -> None:
    with pytest.raises(ParameterError, match="write the unit too"):
        parse_quantity("1.5", unit, "name")


@given(text=st.text(max_size=12) | st.from_regex(r"[-+0-9.]{1,6}[a-zA-Z]{0,4}", fullmatch=True))
def test_any_text_is_read_or_refused(text: str) -> None:
    try:
        value = parse_quantity(text, "V", "name")
    except ParameterError:
        return
    assert math.isfinite(value)


def test_a_field_states_its_unit() -> None:
    @dataclass(frozen=True, slots=True)
    class Sizes:
        width: float = quantity(1e-6, "m")

    assert [f.metadata["unit"] for f in fields(Sizes)] == ["m"]
    assert Sizes() == Sizes(1e-6)
    assert repr(Sizes()).endswith("Sizes(width=1e-06)")


@pytest.mark.parametrize(
    ("name", "unit"),
    [
        ("t_inh_s", "s"), ("supply_power_W", "W"), ("mean_speed_m_per_s", "m/s"), ("temperature_C", "degC"),
        ("s", ""), ("spikes", ""), ("distance_cm", ""), ("rate_per_s", ""), ("error_rms_deg", "deg"),
    ],
)  # fmt: skip
def test_a_name_ends_with_its_unit(name: str, unit: str) -> None:
    assert unit_of_name(name) == unit
