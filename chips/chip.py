"""A chip that runs as a behavioural model: as one circuit it has no testbench of its own."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from circuits.circuit import Circuit


@dataclass(frozen=True, slots=True)
class Chip:
    """What the command line knows of a chip without a testbench.

    name: on the command line; summary: a line of what it is; circuits: builds the circuits that all its
    devices stand in; remedy: what to do where a testbench was asked for, as the end of an error's line.
    """

    name: str
    summary: str
    circuits: Callable[[], tuple[Circuit, ...]]
    remedy: str
