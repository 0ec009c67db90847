"""What a kernel that is worked out takes and becomes: see `circuits.programs.specialised`."""

from __future__ import annotations

import ast
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple


@dataclass(frozen=True, slots=True)
class Argument:
    """A number that is not known beforehand."""

    name: str


@dataclass(frozen=True, slots=True)
class Memory:
    """An array that a run has for itself.

    Attributes
    ----------
    name : str
        Its name in the program.
    shape : tuple of int
        Its shape.
    whole : bool
        Whether its elements are whole numbers.
    held : mapping
        Elements, by their place in the flat array, that are numbers of another name.
    """

    name: str
    shape: tuple[int, ...]
    whole: bool = False
    held: Mapping[int, ast.expr] = field(default_factory=dict)

    @property
    def size(self) -> int:
        """How many elements it has."""
        return math.prod(self.shape)


@dataclass(frozen=True, slots=True)
class Shared:
    """An array that all runs share.

    Attributes
    ----------
    name : str
        Its name in the program.
    shape : tuple of int
        Its shape; what is not known of it is -1, and must not be asked.
    whole : bool
        Whether its elements are whole numbers.
    place : mapping or None
        Of the elements behind the first index, by their place in the flat array, where each is kept, or what
        number it is of another name; None where all are kept in their order.
    """

    name: str
    shape: tuple[int, ...]
    whole: bool = False
    place: Mapping[int, int | ast.expr] | None = None

    @property
    def size(self) -> int:
        """How many elements it has."""
        return math.prod(self.shape)


class Program(NamedTuple):
    """What is left of a kernel.

    body: statements. variables: names of all numbers that it makes. memory: arrays of its own. arguments:
    names of numbers that it is given. shared: arrays that it is given. tables: known numbers among which it
    chooses. functions: what it calls.
    """

    body: list[ast.stmt]
    variables: list[str]
    memory: list[Memory]
    arguments: list[str]
    shared: list[Shared]
    tables: dict[str, tuple[float, ...]]
    functions: list[Function]


class Function(NamedTuple):
    """A function that a program calls with numbers.

    given: names of what it gives, which are among its variables or arguments, or numbers.
    """

    name: str
    program: Program
    given: list[ast.expr]


def python_text(program: Program) -> str:
    """The statements of a program as Python has them."""
    return ast.unparse(ast.fix_missing_locations(ast.Module(program.body, [])))
