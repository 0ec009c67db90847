"""A table of a file is a dataclass: what stands in it, and what is refused with its place."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Literal

import pytest

from circuits.errors import ParameterError
from system.option import check_options, option, required
from system.table import read_table


@dataclass(frozen=True, slots=True)
class Wheel:
    """A part, whose own rule goes beyond limits."""

    radius: float = option(0.1, unit="m", above=0.0)
    width: float = option(0.02, unit="m", above=0.0)

    def __post_init__(self) -> None:
        check_options(self)
        if self.width > self.radius:
            raise ParameterError(f"width: {self.width:g} m, must be at most the radius")


@dataclass(frozen=True, slots=True, kw_only=True)
class Cart:
    """A table with a field of every kind."""

    at: tuple[float, float] = required(unit="m")
    heading: float = option(0.0, name="heading_deg", unit="deg", to_field=math.radians)
    colour: float = option(0.5, unit="", above=0.0, most=1.0, words={"white": 0.85})
    shades: tuple[float, ...] = option((), unit="", most=1.0, words={"white": 0.85}, fewest=1)
    gait: Literal["walk", "trot"] = option("walk")
    name: str = option("cart")
    seats: int | tuple[int, int] = option(1, least=0)
    open: bool = option(default=False)
    load: float | None = option(None, unit="kg", least=0.0)
    front: Wheel | Literal[False] = option(Wheel())
    wheels: tuple[Wheel, ...] = option((), name="wheel")
    path: tuple[tuple[float, float], ...] | None = option(None, unit="m", fewest=2)


def cart(**given: Any) -> Cart:
    """A cart of the keys of a file."""
    return read_table(Cart, {"at": [0, 1], **given})


def test_what_is_left_out_is_the_default() -> None:
    assert cart() == Cart(at=(0.0, 1.0))


@pytest.mark.parametrize(
    ("given", "field", "value"),
    [
        ({"heading_deg": 90}, "heading", pytest.approx(math.pi / 2)),
        ({"colour": "white"}, "colour", 0.85),
        ({"colour": 1}, "colour", 1.0),
        ({"shades": ["white", 0.2]}, "shades", (0.85, 0.2)),
        ({"gait": "trot"}, "gait", "trot"),
        ({"name": "mine"}, "name", "mine"),
        ({"seats": 3}, "seats", 3),
        ({"seats": [3, 4]}, "seats", (3, 4)),
        ({"open": True}, "open", True),
        ({"load": 2}, "load", 2.0),
        ({"front": False}, "front", False),
        ({"front": {"radius": 1}}, "front", Wheel(radius=1.0)),
        ({"wheel": [{}, {"radius": 1}]}, "wheels", (Wheel(), Wheel(radius=1.0))),
        ({"path": [[0, 1], [2, 3]]}, "path", ((0.0, 1.0), (2.0, 3.0))),
        ({"path": [[0, "250mm"], [2, 3]]}, "path", ((0.0, 0.25), (2.0, 3.0))),
    ],
)
def test_a_key_sets_its_field(given: dict[str, Any], field: str, value: Any) -> None:
    assert getattr(cart(**given), field) == value


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ({"heading": 1}, "cart.heading: unknown key; did you mean heading_deg?"),
        ({"xyz": 1}, "cart.xyz: unknown key; known are at, heading_deg, "),
        ({"at": [1]}, "cart.at: [1], must be two numbers"),
        ({"at": [1, True]}, "cart.at[1]: True, must be a number in m; "),
        ({"at": [1, 1e10]}, "cart.at[1]: must be within 1e+09 either way; correct it"),
        ({"at": [1, math.inf]}, "cart.at[1]: inf m, must be finite"),
        ({"colour": "mauve"}, "cart.colour: mauve, must be one of white, or a number"),
        ({"colour": 1.5}, "cart.colour: 1.5, must be > 0 and <= 1"),
        ({"colour": [1]}, "cart.colour: [1], must be a number; "),
        ({"shades": []}, "cart.shades: [], must be a list of at least 1"),
        ({"shades": [0.1, 2]}, "cart.shades[1]: 2, must be <= 1"),
        ({"gait": "run"}, "cart.gait: run, must be walk or trot"),
        ({"name": 1}, "cart.name: 1, must be text"),
        ({"seats": 1.5}, "cart.seats: 1.5, must be a whole number"),
        ({"seats": True}, "cart.seats: True, must be a whole number"),
        ({"seats": -1}, "cart.seats: -1, must be >= 0"),
        ({"seats": [1, 2.5]}, "cart.seats[1]: 2.5, must be a whole number"),
        ({"open": 1}, "cart.open: 1, must be true or false"),
        ({"load": -1}, "cart.load: -1 kg, must be >= 0 and finite"),
        ({"front": True}, "cart.front: True, must be a table of radius, width"),
        ({"front": 0}, "cart.front: 0, must be a table of radius, width"),
        ({"front": {"radius": 0}}, "cart.front.radius: 0 m, must be > 0 and finite"),
        ({"front": {"width": 0.2}}, "cart.front.width: 0.2 m, must be at most the radius"),
        ({"wheel": {"radius": 1}}, "cart.wheel: must be written as [[cart.wheel]], one table each"),
        ({"wheel": [{}, {"radii": 1}]}, "cart.wheel[1].radii: unknown key; did you mean radius?"),
        ({"path": [[0, 1]]}, "cart.path: [[0, 1]], must be a list of at least 2"),
        ({"path": [[0, 1], [2, "a"]]}, 'cart.path[1][1]: "a", must be a length in m; '),
    ],
)
def test_what_is_refused_is_told_with_its_place(given: dict[str, Any], says: str) -> None:
    with pytest.raises(ParameterError) as caught:
        read_table(Cart, {"at": [0, 1], **given}, "cart")
    assert str(caught.value).startswith(says)


def test_a_key_that_must_be_given_is_missed_and_no_table_is_none() -> None:
    with pytest.raises(ParameterError, match=r"^cart.at: missing, must be given$"):
        read_table(Cart, {}, "cart")
    with pytest.raises(ParameterError, match=r"^cart: 3, must be a table of at, heading_deg, "):
        read_table(Cart, 3, "cart")
