"""Sizes of a block, which are checked where they are given."""

from dataclasses import dataclass

import pytest

from circuits.blocks.sizes import Sizes
from circuits.errors import ParameterError
from circuits.units import quantity


@dataclass(frozen=True)
class _Own(Sizes):
    capacitance: float = quantity(1e-12, "F")
    ratio: float = quantity(2.0, "")
    cells: int = quantity(3, "", least=2)
    line_capacitance: float = quantity(1e-15, "F", least=0.0)
    pair_width: float = quantity(4.0, "um")
    pair_length: float = quantity(1.0, "um")
    ratios: tuple[float, ...] = quantity((0.0, -1.0), "")


def test_sizes_are_above_zero_and_counts_can_be_built() -> None:
    assert _Own().cells == 3
    with pytest.raises(ParameterError, match=r"^capacitance: 0 F, must be > 0"):
        _Own(capacitance=0.0, cells=0)
    with pytest.raises(ParameterError, match=r"^ratio: nan, must be > 0"):
        _Own(ratio=float("nan"))
    with pytest.raises(ParameterError, match=r"^cells: 65, must be a whole number from 2 to 64"):
        _Own(cells=65)


def test_a_field_says_what_it_allows_at_least() -> None:
    assert _Own(line_capacitance=0.0).line_capacitance == 0.0
    with pytest.raises(ParameterError, match=r"^line_capacitance: -1e-15 F, must be 0 F or more"):
        _Own(line_capacitance=-1e-15)
    with pytest.raises(ParameterError, match=r"^cells: 1, must be a whole number from 2 to 64"):
        _Own(cells=1)


def test_a_part_has_a_width_and_a_length() -> None:
    assert _Own(pair_length=2.0).size("pair") == (4.0, 2.0)
