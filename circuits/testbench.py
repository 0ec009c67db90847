"""Testbench: a circuit, what drives its ports, and for how long.

Bias ports that nothing drives are set from the circuit's biases at the temperature of the run.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import ClassVar

from circuits.circuit import Circuit
from circuits.devices.source import Source
from circuits.errors import ParameterError


@dataclass(frozen=True, slots=True)
class Testbench:
    """`sources` drive ports of `circuit` (their `node` is a port, or an element as in `spike[3]`).

    `stop` in s, inf for a run without an end of its own. `watch`: event ports whose upward half-supply
    crossings are spikes. `start`: initial voltages by node path that replace the operating point's guess.

    Raises `ParameterError` unless stop > 0.
    """

    __test__: ClassVar[bool] = False  # the name alone would make pytest collect it

    title: str
    circuit: Circuit
    sources: tuple[Source, ...]
    stop: float
    watch: tuple[str, ...] = ()
    start: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if not self.stop > 0.0:
            raise ParameterError(f"{self.title}.stop: {self.stop:g} s, must be > 0; give the end of the run")
