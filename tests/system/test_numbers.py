"""Numbers of a model are finite and above 0, unless it says otherwise of one."""

from __future__ import annotations

import math
from dataclasses import dataclass

import pytest

from circuits.errors import ParameterError
from system.numbers import check_numbers


@dataclass(frozen=True, slots=True)
class Kite:
    """Numbers, and a word beside them."""

    span: float = 2.0
    drag: float = 0.0
    lean: float = -0.1
    lines: int = 2
    colour: str = "red"


def checked(**changes: float) -> Kite:
    """A kite whose drag may be 0 and whose lean may be negative."""
    kite = Kite(**changes)  # type: ignore[arg-type]
    check_numbers("kite", kite, from_zero=("drag",), signed=("lean",))
    return kite


def test_numbers_in_range_pass() -> None:
    assert checked() == Kite()


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"span": 0.0}, "kite.span: 0, must be > 0 and finite; see its default"),
        ({"span": math.nan}, "kite.span: nan, must be > 0 and finite; see its default"),
        ({"drag": -1.0}, "kite.drag: -1, must be >= 0 and finite; see its default"),
        ({"drag": math.inf}, "kite.drag: inf, must be >= 0 and finite; see its default"),
        ({"lean": math.inf}, "kite.lean: inf, must be finite; see its default"),
        ({"lines": 0}, "kite.lines: 0, must be > 0 and finite; see its default"),
    ],
)
def test_a_number_out_of_range_is_named_with_its_rule(changes: dict[str, float], says: str) -> None:
    with pytest.raises(ParameterError) as caught:
        checked(**changes)
    assert str(caught.value) == says
