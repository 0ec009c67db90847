"""What every block offers to the command line and to the registry-wide tests."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from circuits.circuit import Circuit
from circuits.silicon.process import AMI_1500, Process
from circuits.silicon.silicon import Silicon
from circuits.solver.power import supply_power
from circuits.solver.transient import Result
from circuits.testbench import Testbench

Values = Mapping[str, float | None]


@dataclass(frozen=True, slots=True)
class Stimulus:
    """One knob of a block's testbench. `unit` is SI; a stimulus that can be `off` takes None for it."""

    name: str
    unit: str
    default: float | None
    summary: str
    can_be_off: bool = False


DURATION = Stimulus("duration", "s", None, "length of the run", can_be_off=True)  # the testbench's own if off


@dataclass(frozen=True, slots=True)
class ClosedForm:
    """A quantity by an equation of the paper: as printed, and corrected (None where the print holds), SI."""

    equation: int
    name: str
    printed: float
    corrected: float | None


@dataclass(frozen=True, slots=True)
class EquationText:
    """An equation of the paper as printed, as corrected (None where the print holds), and what differs."""

    number: int
    name: str
    printed: str
    corrected: str | None
    difference: str


@dataclass(frozen=True, slots=True)
class Block:
    """A circuit with its parameters, testbench and metrics.

    `params`: frozen dataclass of SI floats. `build(params)` returns the circuit. `testbench(circuit,
    stimuli, v_dd)` takes a value for each of `stimuli` (None is off) and the supply (V). `measures(result)`
    returns SI numbers by name, None where a quantity is not defined in this run; `outcome(result)` one word.
    `bias_sets`: values of biases (A or V) by the name of the set, for blocks that come with several.
    `process`: what its sizes are drawn for.
    """

    name: str
    summary: str
    params: type
    build: Callable[[Any], Circuit]
    stimuli: tuple[Stimulus, ...]
    testbench: Callable[[Circuit, Values, float], Testbench]
    measures: Callable[[Result], dict[str, float | None]]
    outcome: Callable[[Result], str]
    plotted: tuple[str, ...] = ()  # nodes drawn by default, from top to bottom
    closed_forms: Callable[[Circuit, Silicon], tuple[ClosedForm, ...]] | None = None
    equations: tuple[EquationText, ...] = ()
    bias_sets: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    process: Process = AMI_1500

    @property
    def defaults(self) -> dict[str, float | None]:
        """Value of each of the testbench's knobs unless another is given, SI; None is off."""
        return {stimulus.name: stimulus.default for stimulus in self.stimuli}

    def bench(self, circuit: Circuit | None = None, **stimuli: float | None) -> Testbench:
        """The testbench of `circuit`, the block with its default parameters unless given, on its process.

        stimuli: knobs that are not at their default, SI; None is off.
        """
        built = self.build(self.params()) if circuit is None else circuit
        return self.testbench(built, self.defaults | stimuli, self.process.v_dd)

    def measured(self, result: Result) -> dict[str, float | None]:
        """All numbers of a run by name: what the block measures, and the mean power of its sources, W."""
        return {**self.measures(result), "supply_power_W": supply_power(result)}
