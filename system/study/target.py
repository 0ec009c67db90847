"""What a study measures: a block, a chip or a system, with its metrics, on any die.

A `Subject` is text and numbers only, so that it goes to other processes and into a manifest; `open_target`
makes of it what can be measured. A block is lowered once a temperature and then put on every die; a system is
run anew on each.
"""

from __future__ import annotations

import ast
import hashlib
import math
import sys
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from functools import lru_cache
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from circuits.arrays import F64
from circuits.brief import OPTIONAL
from circuits.circuit import BiasKind
from circuits.errors import CircuitError, ParameterError, unknown_name
from circuits.lowering.kernel import Machine, on_die, to_kernel
from circuits.lowering.variation import variation_draws, variation_labels
from circuits.silicon.die import NOMINAL, Die
from circuits.solver.transient import Result, simulate
from circuits.testbench import Begin
from system.options.begin import FREE, BeginChoice
from system.options.begun import begun
from system.options.block import choose
from system.options.silicon import SiliconChoice
from system.registry import SYSTEMS, load_system, system_names
from system.study.metric import MEASURED, measurements, metrics_of, runs_testbench
from system.study.specification import Specification, Success
from system.study.table import FAILED, Condition
from system.system import SUCCEEDED

Option = str | int | float | bool | tuple[float, ...] | None


@dataclass(frozen=True, slots=True)
class Subject:
    """Target, its options as on the command line, and the names of the metrics.

    `held`, `begin`: where the runs of a block begin (`system.options.begin`).
    """

    target: str
    metrics: tuple[str, ...]
    params: tuple[str, ...] = ()
    biases: tuple[str, ...] = ()
    bias_set: str | None = None
    bias_kind: BiasKind | None = None
    stimuli: tuple[str, ...] = ()
    silicon: SiliconChoice = field(default_factory=SiliconChoice)
    system: Mapping[str, Option] = field(default_factory=dict)  # level, duration, ... of a system's scenario
    held: tuple[str, ...] = field(default=(), metadata=OPTIONAL)
    begin: Begin = field(default="disturbed", metadata=OPTIONAL)


@dataclass(frozen=True, slots=True)
class Quantity:
    """Name and SI unit of a number that a study measures; yes_no: it is 1 or 0, for yes or no."""

    name: str
    unit: str
    yes_no: bool = False


@dataclass(frozen=True, slots=True)
class Measurement:
    """One sample: a word, a number a metric (NaN where not defined), and why it failed."""

    outcome: str
    values: tuple[float, ...]
    reason: str = ""


class Target(ABC):
    """Something that is measured on dies."""

    @property
    @abstractmethod
    def quantities(self) -> tuple[Quantity, ...]:
        """What is measured, in the order of the values."""

    @property
    def specifications(self) -> tuple[Specification, ...]:
        """What a sample must fulfil where nothing is asked for: nothing, unless the target has its own."""
        return ()

    @abstractmethod
    def labels(self) -> tuple[str, ...]:
        """Labels of all standard normals behind a die, as a sampling plan needs them."""

    @abstractmethod
    def draws(self, die: Die) -> F64:
        """Standard normals of a die, float64[labels]."""

    @abstractmethod
    def measure(self, die: Die, condition: Condition) -> Measurement:
        """Measure one die; raises what the measurement raises."""

    @abstractmethod
    def identity(self) -> str:
        """Hash of what is measured: circuits, sizes, biases, stimuli, process."""


def measure_safely(target: Target, die: Die, condition: Condition) -> Measurement:
    """Measure one die; whatever is raised is that sample's result."""
    try:
        return target.measure(replace(die, corner=condition.corner), condition)  # type: ignore[arg-type]
    except Exception as error:  # noqa: BLE001 - a sample that fails is reported as failed
        reason = " ".join(str(error).split()) or type(error).__name__
        if not isinstance(error, CircuitError):
            reason = f"{type(error).__name__}: {reason}"
        return Measurement(FAILED, (math.nan,) * len(target.quantities), reason)


@lru_cache(maxsize=8)
def _opened(text: str) -> Target:
    return _open(_read_subject(text))


def open_target(subject: Subject) -> Target:
    """The target of a subject, made once a process.

    Raises `UnknownNameError` and `ParameterError` naming the option.
    """
    return _opened(_write_subject(subject))


def _write_subject(subject: Subject) -> str:
    """A subject as text, the same for equal ones."""
    return repr(asdict(subject))


def _read_subject(text: str) -> Subject:
    """What `_write_subject` wrote."""
    fields = ast.literal_eval(text)
    return Subject(**{**fields, "silicon": SiliconChoice(**fields["silicon"])})


def _open(subject: Subject) -> Target:
    if subject.target in SYSTEMS or subject.target in system_names():
        return SystemTarget(subject)
    return BlockTarget(subject)


class BlockTarget(Target):
    """A block or chip, lowered at each temperature that is asked for."""

    def __init__(self, subject: Subject) -> None:
        """Read the options and find the metrics."""
        s = subject
        self.choice = choose(
            s.target, s.params, s.biases, s.bias_kind, s.silicon, s.stimuli, s.bias_set,
            BeginChoice(s.held, s.begin),
        )  # fmt: skip
        self.metrics = metrics_of(self.choice, s.metrics)
        self._machines: dict[float, tuple[Machine, ...]] = {}

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """What is measured."""
        return tuple(Quantity(m.name, m.unit, m.yes_no) for m in self.metrics if m.value is not None)

    @property
    def runs_testbench(self) -> bool:
        """Whether a metric is read from a run of the testbench, so that stimuli reach it."""
        return any(runs_testbench(m) for m in self.metrics)

    def labels(self) -> tuple[str, ...]:
        """Of every transistor, and of the process."""
        machine = self._varied()
        return variation_labels(machine.flat, machine.silicon)

    def draws(self, die: Die) -> F64:
        """In the order of the labels."""
        machine = self._varied()
        return variation_draws(machine.flat, machine.silicon, die)

    def _varied(self) -> Machine:
        """A machine with every device that varies, as all have; the testbench's without metrics."""
        machines = self.machines(self.choice.silicon.temperature_c)
        return machines[0] if machines else to_kernel(self.choice.testbench(), self.choice.silicon)

    def machines(self, temperature_c: float) -> tuple[Machine, ...]:
        """A machine for each measurement, at a temperature."""
        if temperature_c not in self._machines:
            silicon = replace(self.choice.silicon, temperature_c=temperature_c)
            self._machines[temperature_c] = tuple(
                self._begun(m.prepare(self.choice.circuit, silicon)) for m in measurements(self.metrics)
            )
        return self._machines[temperature_c]

    def nominal_run(self, temperature_c: float) -> Result | None:
        """The testbench on the nominal die, for what a run tells of its own accord.

        None where no metric is of such a run, or it fails.
        """
        if not self.runs_testbench:
            return None
        try:
            return simulate(on_die(self.machines(temperature_c)[0], NOMINAL), record=())
        except CircuitError:
            return None

    def _begun(self, machine: Machine) -> Machine:
        """The machine whose runs begin as was chosen, whatever testbench a metric has."""
        return replace(machine, testbench=begun(machine.testbench, self.choice.begin))

    def stimuli(self, die: Die, condition: Condition) -> Mapping[str, float | None]:
        """What the testbench applies to show what the first metric saw of a die.

        The study's own where that ran the testbench; else what stands for the measurement's own runs, or the
        testbench's defaults where nothing does.
        """
        first = self.metrics[0]
        if first.shown is None:
            return self.choice.stimuli
        k = measurements(self.metrics).index(first)
        found = first.measure(on_die(self.machines(condition.temperature_c)[k], die))
        return {**self.choice.stimuli, **first.shown(found)}

    def measure(self, die: Die, condition: Condition) -> Measurement:
        """Put every machine on the die and measure it once."""
        shared = measurements(self.metrics)
        machines = self.machines(condition.temperature_c)
        found = {
            id(m.measure): m.measure(on_die(machine, die))
            for m, machine in zip(shared, machines, strict=True)
        }
        values = tuple(float(m.value(found[id(m.measure)])) for m in self.metrics if m.value is not None)
        judged = found[id(shared[0].measure)]
        return Measurement(shared[0].outcome(judged), values, shared[0].reason(judged))

    def identity(self) -> str:
        """Hash of circuit, process, stimuli, and of what is measured."""
        c = self.choice
        measured = [(m.name, m.measure.__module__, m.measure.__qualname__) for m in self.metrics]
        begin = () if c.begin == FREE else (c.begin,)
        return _digest(c.circuit, c.silicon.process, c.silicon.place, c.stimuli, measured, *begin)


class SystemTarget(Target):
    """A system, run on the die's silicon; its metrics are the numbers of its summary."""

    def __init__(self, subject: Subject) -> None:
        """Read the options; raises `UnknownNameError` for a metric that the system does not sum up."""
        self._system = load_system(subject.target)
        self._options = dict(subject.system)
        self._names = tuple(name.replace("-", "_") for name in subject.metrics)
        for name in self._names:
            if name not in self._system.metrics:
                raise unknown_name("metric", name, self._system.metrics)

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """Numbers of the summary, whose names carry their units."""
        return tuple(Quantity(name, "", name in self._system.yes_no) for name in self._names)

    @property
    def specifications(self) -> tuple[Specification, ...]:
        """The system's own definition of success, where that is measured."""
        return (Success(self._system.success),) if SUCCEEDED in self._names else ()

    def labels(self) -> tuple[str, ...]:
        """A system's draws are not listed: it takes its dies as they are."""
        raise ParameterError("plan: a system takes every die's own draws; use random")

    def draws(self, die: Die) -> F64:
        """As `labels`."""
        raise ParameterError("contributions: not for a system; study its chips")

    def run(self, die: Die, condition: Condition) -> Any:
        """Run the system; `trial` is the seed of noise and worlds."""
        known = self._system.settings
        silicon = {"die": die, "temperature_c": condition.temperature_c}
        on_die = {name: value for name, value in silicon.items() if name in known}
        return self._system.run(self._system.scenario(**self._options, **on_die, seed=condition.trial))

    def draw(self, trace: Any, figure: Figure) -> None:
        """Fill a figure with a run."""
        self._system.draw(trace, figure)

    def measure(self, die: Die, condition: Condition) -> Measurement:
        """Sum a run up."""
        summary = self._system.summarise(self.run(die, condition))
        values = (summary[name] for name in self._names)
        return Measurement(MEASURED, tuple(math.nan if v is None else float(v) for v in values))

    def identity(self) -> str:
        """Hash of the system's circuits, of its options and of what is measured."""
        return _digest(self._system.circuits(), sorted(self._options.items()), self._names)


def _digest(*parts: object) -> str:
    with np.printoptions(threshold=sys.maxsize, floatmode="unique"):
        return hashlib.sha256(repr(parts).encode()).hexdigest()[:16]
