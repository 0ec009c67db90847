"""Testbench: a circuit, what drives its ports, and for how long.

Bias ports that nothing drives are set from the circuit's biases at the temperature of the run.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import isfinite
from typing import ClassVar, Literal, get_args

from circuits.brief import OPTIONAL, brief
from circuits.checks import require_real, require_type
from circuits.circuit import Circuit
from circuits.devices.source import Source
from circuits.errors import ParameterError

Begin = Literal["disturbed", "at_rest", "uic"]
BEGINNINGS: tuple[Begin, ...] = get_args(Begin)


@dataclass(frozen=True, slots=True, repr=False)
class Testbench:
    """`sources` drive ports of `circuit` (their `node` is a port, or an element as in `spike[3]`).

    `stop` in s, inf for a run without an end of its own. `watch`: event ports whose upward crossings of half
    the supply that their circuit is wired to, or of the port's own threshold, are spikes. Where a run begins:

    start
        Voltages (V) by node path near which the operating point is looked for: a guess, SPICE's `.nodeset`.
    initial
        Voltages (V) by node path that hold at time 0 and are let go then, SPICE's `.ic`; the nodes that are
        not named are at rest with them.
    begin
        `disturbed`: from the operating point, and where that is not stable a little beside it, so that an
        oscillator starts. `at_rest`: from the operating point, stable or not. `uic`: without one; every
        capacitance begins with what `initial` or its own `ic` says, else with 0 V across it.

    Raises `ParameterError` unless stop > 0, `begin` is known and the voltages are finite, and for what is no
    circuit, source or voltage.
    """

    __test__: ClassVar[bool] = False  # the name alone would make pytest collect it

    title: str
    circuit: Circuit
    sources: tuple[Source, ...]
    stop: float
    watch: tuple[str, ...] = ()
    start: Mapping[str, float] = field(default_factory=dict)
    initial: Mapping[str, float] = field(default_factory=dict, metadata=OPTIONAL)
    begin: Begin = field(default="disturbed", metadata=OPTIONAL)

    def __repr__(self) -> str:
        return brief(self)

    def __post_init__(self) -> None:
        require_type(f"{self.title}.circuit", self.circuit, Circuit, "a circuit")
        for source in self.sources:
            require_type(f"{self.title}.sources", source, Source, "a source")
        require_real(f"{self.title}.stop", self.stop, "s")
        for node, voltage in (*self.start.items(), *self.initial.items()):
            require_real(f"{self.title}: {node}", voltage, "V")
        if not self.stop > 0.0:
            raise ParameterError(f"{self.title}.stop: {self.stop:g} s, must be > 0; give the end of the run")
        if self.begin not in BEGINNINGS:
            known = ", ".join(BEGINNINGS)
            raise ParameterError(f"{self.title}.begin: {self.begin}, must be one of {known}")
        for node, voltage in self.initial.items():
            if not isfinite(voltage):
                raise ParameterError(f"{self.title}.initial: {node} at {voltage:g} V, must be finite")
