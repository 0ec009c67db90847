"""Units of measures: derived, named, read and written."""

import pytest

from circuits.errors import ParameterError
from circuits.measure.unit import AMPERE, PLAIN, SECOND, VOLT, read_number, unit_named, value_text


def test_units_have_their_names() -> None:
    found = [
        VOLT * AMPERE,
        VOLT * AMPERE * SECOND,
        AMPERE * SECOND,
        VOLT / AMPERE,
        PLAIN / SECOND,
        VOLT / SECOND,
    ]
    assert [str(unit) for unit in found] == ["W", "J", "C", "Ohm", "Hz", "V/s"]
    assert [str(VOLT**2), str(PLAIN / VOLT), str(PLAIN)] == ["V^2", "1/V", ""]
    assert (VOLT**2).root() == VOLT
    assert VOLT.root() is None
    assert unit_named("S") == AMPERE / VOLT


@pytest.mark.parametrize(
    ("text", "value", "unit"),
    [("0.9", 0.9, ""), ("900mV", 0.9, "V"), ("1.2ms", 1.2e-3, "s"), ("10k", 1e4, ""), ("3Meg", 3e6, ""),
     ("5uS", 5e-6, "S"), ("2MHz", 2e6, "Hz"), ("1e-3s", 1e-3, "s"), ("600fF", 6e-13, "F"), ("-0", 0.0, "")],
)  # fmt: skip
def test_numbers_are_read_with_their_units(text: str, value: float, unit: str) -> None:
    found, read = read_number(text)
    assert (found, str(read)) == (pytest.approx(value), unit)


@pytest.mark.parametrize("text", ["2M", "3x", "1F", "1mm"])
def test_other_texts_are_refused(text: str) -> None:
    with pytest.raises(ParameterError):
        read_number(text)


def test_values_are_written_for_a_reader() -> None:
    assert value_text(1.2e-3, SECOND) == "1.2ms"
    assert value_text(2e9, "V/s") == "2e+09 V/s"
    assert value_text(0.25, "") == "0.25"
