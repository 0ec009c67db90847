"""The contract of a block: what every named circuit offers to the command line, studies and tests."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from inspect import signature
from typing import Any

from circuits.blocks.summary import SUMMARIES
from circuits.circuit import Circuit
from circuits.silicon.process import AMI_1500, Process
from circuits.silicon.silicon import Silicon
from circuits.solver.power import supply_power
from circuits.solver.transient import Result
from circuits.testbench import Testbench

Values = Mapping[str, float | None]
_POWER = "supply_power_W"


@dataclass(frozen=True, slots=True)
class Stimulus:
    """A knob of a block's testbench.

    name: name of the knob. unit: its SI unit; empty for a plain number. default: its value unless another is
    given, in SI units. summary: a line about what it does. can_be_off: whether it may be switched off; None
    is its value then.
    """

    name: str
    unit: str
    default: float | None
    summary: str
    can_be_off: bool = False


DURATION = Stimulus("duration", "s", None, "length of the run", can_be_off=True)  # the testbench's own if off


def lasting(seconds: float, summary: str = "length of the run") -> Stimulus:
    """The knob `duration` of a testbench, whose runs last so many seconds unless it is turned."""
    return Stimulus("duration", "s", seconds, summary)


@dataclass(frozen=True, slots=True)
class ClosedForm:
    """A quantity that an equation of a paper gives.

    equation: number of the equation in the paper. name: name of the quantity, which ends with its unit.
    printed: its value by the equation as printed, in SI units. corrected: its value by the equation as
    corrected, in SI units; None where the print holds.
    """

    equation: int
    name: str
    printed: float
    corrected: float | None


@dataclass(frozen=True, slots=True)
class EquationText:
    """Text of an equation of a paper, as printed and as corrected, and what differs.

    corrected: None where the print holds.
    """

    number: int
    name: str
    printed: str
    corrected: str | None
    difference: str


@dataclass(frozen=True, slots=True)
class Block:
    """A circuit with its sizes, its testbench, and what is measured of a run.

    name, summary
        What the command line calls it, and a line about it.
    build
        `build(params)` returns the circuit. The default of `params` is of a frozen dataclass of its sizes, SI
        floats unless a field's unit says otherwise.
    stimuli
        The knobs of its testbench.
    testbench
        `testbench(circuit, stimuli, v_dd)` takes a value for each knob (None is off) and the supply, V.
    measures
        `measures(result)` returns numbers of a run by name, SI; None where one is not defined in this run.
    outcome
        `outcome(result)` returns what happened in a run, in a word.
    plotted
        Nodes that a picture shows by default, from top to bottom.
    closed_forms, equations
        What equations of a paper say of the circuit on a silicon, and their texts.
    bias_sets
        Values of biases (A or V) by name, for each of several named sets.
    process
        The process that its sizes are drawn for.
    testbench_of
        `testbench_of(params)` returns the testbench for sizes (SI) on which its sources depend; None where
        they do not.
    """

    name: str
    summary: str
    build: Callable[..., Circuit]
    stimuli: tuple[Stimulus, ...]
    testbench: Callable[[Circuit, Values, float], Testbench]
    measures: Callable[[Result], dict[str, float | None]]
    outcome: Callable[[Result], str]
    plotted: tuple[str, ...] = ()  # nodes drawn by default, from top to bottom
    closed_forms: Callable[[Circuit, Silicon], tuple[ClosedForm, ...]] | None = None
    equations: tuple[EquationText, ...] = ()
    bias_sets: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    process: Process = AMI_1500
    testbench_of: Callable[[Any], Callable[[Circuit, Values, float], Testbench]] | None = None

    def sized(self, params: Any) -> Block:
        """The block whose testbench is that for the sizes `params`, where it depends on them."""
        return self if self.testbench_of is None else replace(self, testbench=self.testbench_of(params))

    @property
    def sizes(self) -> Any:
        """Its sizes unless others are given: the default of what `build` takes.

        Raises `TypeError` where `build` has no default.
        """
        sizes, *_ = signature(self.build).parameters.values()
        if sizes.default is sizes.empty:
            raise TypeError(f"{self.name}.build: {sizes.name} has no default; give it the block's sizes")
        return sizes.default

    @property
    def params(self) -> type:
        """The dataclass of its sizes; raises `TypeError` as `sizes`."""
        return type(self.sizes)

    @property
    def defaults(self) -> dict[str, float | None]:
        """The default of each knob of the testbench, SI; None is off."""
        return {stimulus.name: stimulus.default for stimulus in self.stimuli}

    def bench(self, circuit: Circuit | None = None, **stimuli: float | None) -> Testbench:
        """The testbench of a circuit of this block, on the supply of the block's process.

        Parameters
        ----------
        circuit
            Circuit of the block; that of its default sizes unless given.
        stimuli
            Values of the knobs that differ from their defaults, in SI units; None is off.
        """
        built = self.build() if circuit is None else circuit
        return self.testbench(built, self.defaults | stimuli, self.process.v_dd)

    def measured(self, result: Result) -> dict[str, float | None]:
        """All numbers of the run `result` by name, in SI units.

        They are what the block measures, and `supply_power_W`, the mean power of its sources.
        """
        return {**self.measures(result), _POWER: supply_power(result)}

    def number(self, result: Result, name: str) -> float | None:
        """One number of a run, SI; None where it is not defined in this run.

        Parameters
        ----------
        result
            The run.
        name
            Name of the number, as `measured` has it; power is worked out only where it is asked for.
        """
        return supply_power(result) if name == _POWER else self.measures(result)[name]


def catalogued(
    name: str, build: Callable[..., Circuit], stimuli: tuple[Stimulus, ...],
    testbench: Callable[[Circuit, Values, float], Testbench],
    measures: Callable[[Result], dict[str, float | None]], outcome: Callable[[Result], str],
    plotted: tuple[str, ...], process: Process = AMI_1500,
) -> Block:  # fmt: skip
    """A block of the catalogue, whose summary is in `circuits.blocks.summary`; all else is a `Block`'s."""
    summary = SUMMARIES[name]
    return Block(name, summary, build, stimuli, testbench, measures, outcome, plotted, process=process)
