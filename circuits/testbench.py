"""A testbench: a circuit, the sources that drive its ports, and how a run of it begins and ends.

Bias ports that no source drives are set from the circuit's own biases, at the temperature of the run.
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
    """A circuit with its stimuli.

    title
        Name of the testbench in errors, pictures and netlists.
    circuit
        The circuit that is driven.
    sources
        What drives its ports; the node of a source is a port, or an element of one such as `spike[3]`.
    stop
        Length of a run, s; infinite for a run that ends otherwise.
    watch
        Where spikes are looked for: ports, or inner nodes by their paths. A spike rises through half the
        supply of the circuit, or through the port's own threshold.
    start
        Voltages (V) by node path near which the operating point is looked for. They are a guess, as SPICE's
        `.nodeset`.
    initial
        Voltages (V) by node path that are held at time 0 and let go then, as SPICE's `.ic`. All other nodes
        are at rest with them.
    begin
        Where a run begins. `disturbed` is the operating point, and a little beside it where that is not
        stable, so that an oscillator starts. `at_rest` is the operating point whether stable or not. `uic` is
        no operating point: every capacitance begins with the voltage that `initial` or its own `ic` says,
        else with 0 V.

    Raises `ParameterError` unless `stop` is above zero, `begin` is known and all voltages are finite, and for
    a part that is no circuit, source or voltage.
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
