"""The target of a study: a block, a chip or a system that is measured on any die.

A `Subject` says what the target is, in text and numbers only, so that it can be sent to other processes and
written into a manifest. `open_target` makes a `Target` of it, which can be measured. A block is lowered to
its equations once for each temperature, and its equations are then put on every die. A system is run anew on
every die.
"""

from __future__ import annotations

import ast
import hashlib
import math
import sys
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from functools import lru_cache, partial
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from circuits.arrays import F64
from circuits.brief import OPTIONAL
from circuits.circuit import BiasKind
from circuits.errors import CircuitError, DataError, ParameterError, UnknownNameError, unknown_name
from circuits.lowering.kernel import Machine, on_die, to_kernel
from circuits.lowering.on_dies import on_dies
from circuits.lowering.variation import variation_draws, variation_labels, variation_sigma
from circuits.programs import gpu
from circuits.silicon.course import Points
from circuits.silicon.die import NOMINAL, Die
from circuits.silicon.process_file import process_of
from circuits.solver.lanes.places import Place
from circuits.solver.lanes.simulate import fits, simulate_each
from circuits.solver.transient import Result, simulate
from circuits.testbench import Begin
from circuits.units import unit_of_name
from circuits.vectors.vector import WIDTH
from system.codes.find import quietly
from system.options.begin import FREE, BeginChoice
from system.options.begun import begun
from system.options.block import Choice, choose, read_die
from system.options.cards import NGSPICE
from system.options.die.edited import check_drawn, check_known
from system.options.silicon import SiliconChoice
from system.options.target import file_of
from system.options.temperature import COURSE
from system.registry import SYSTEMS, load_system, system_names
from system.study.in_ngspice import Draws, Engine, cards_digest, choice_on_cards, metrics_in_ngspice
from system.study.metrics.metric import MEASURED, OUTSIDE, measurements, metrics_of, runs_testbench
from system.study.plan import seeds_of
from system.study.source import check_source, digest_of
from system.study.specification import Specification, Success, parse_spec
from system.study.table import FAILED, Condition
from system.system import SUCCEEDED
from system.view.film import Film

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_ON_DEVICE = 4096  # dies that a graphics processor takes at once; ours

Option = str | int | float | bool | tuple[float | tuple[float, float], ...] | None


@dataclass(frozen=True, slots=True)
class Subject:
    """What a study measures, as text and numbers.

    Attributes
    ----------
    target : object
        Name of a block, a chip or a system, or a file of the user's (`system.options.target`). In Python also
        an object as it names: a circuit, a testbench, a block; such a study is not kept in a folder.
    metrics : tuple of str
        Names of what is measured.
    params, biases, bias_set, bias_kind, stimuli
        Options of a block, as the command line has them.
    silicon : SiliconChoice
        What all dies share: lot, place on a chip, and which kinds of deviations there are.
    system : mapping of str to Option
        Options of a system's scenario, by name.
    held, begin
        Voltages that are held before a block's runs, and how these begin (`system.options.begin`).
    code : str
        SHA-256 digest of the file that `target` names, which is checked before it is run; empty for a name.
    engine : Engine
        What solves a block's testbench.
    device : Place
        Where runs of a block's testbench go (`circuits.solver.lanes.places`).
    noises : int
        Runs of a system in each of the worlds that a die has for its own (`system.study.plan.seeds_of`); 0
        where a trial's number is the seed of all dies.
    """

    target: Any
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
    code: str = field(default="", metadata=OPTIONAL)
    engine: Engine = field(default="native", metadata=OPTIONAL)
    noises: int = field(default=0, metadata=OPTIONAL)
    device: Place = field(default="cpu", metadata=OPTIONAL)

    @property
    def course(self) -> Points:
        """The course of temperature of a system's runs; empty where there is none."""
        return cast("Points", self.system.get(COURSE, ()))


@dataclass(frozen=True, slots=True)
class Quantity:
    """A number that a study measures: its name, its SI unit, and whether it is 1 or 0 for yes or no."""

    name: str
    unit: str
    yes_no: bool = False

    @property
    def limit_unit(self) -> str:
        """Unit of its limits: its own, else the one that its name ends with; empty for a plain number."""
        return self.unit or unit_of_name(self.name)


@dataclass(frozen=True, slots=True)
class Measurement:
    """One sample of a study.

    Attributes
    ----------
    outcome : str
        Its class in a word; `failed` where it has none.
    values : tuple of float
        Value of each metric in SI units, NaN where undefined.
    reason : str
        Why it failed, or why metrics have no value; empty where there is nothing to say.
    """

    outcome: str
    values: tuple[float, ...]
    reason: str = ""


class Target(ABC):
    """Something that can be measured on any die."""

    @property
    @abstractmethod
    def quantities(self) -> tuple[Quantity, ...]:
        """The numbers that are measured, in the order of a measurement's values."""

    @property
    def specifications(self) -> tuple[Specification, ...]:
        """Specifications that samples are judged by unless the user gives others; none for most targets."""
        return ()

    def specified(self, texts: Sequence[str]) -> tuple[Specification, ...]:
        """Read specifications of its quantities, as a user writes them.

        Parameters
        ----------
        texts
            The specifications, as `t_inh_s in 5ms:8ms`.

        Raises
        ------
        ParameterError
            A text has another form, or low is above high.
        UnknownNameError
            There is no such quantity.
        """
        known = {q.name: q.limit_unit for q in self.quantities}
        return tuple(parse_spec(text, known) for text in texts)

    @abstractmethod
    def labels(self) -> tuple[str, ...]:
        """Labels of all standard normal draws behind a die, which a sampling plan needs to know."""

    @abstractmethod
    def draws(self, die: Die) -> F64:
        """Give the standard normal draws of a die, float64[labels]."""

    @abstractmethod
    def measure(self, die: Die, condition: Condition) -> Measurement:
        """Measure one die under a condition; raises whatever the measurement raises."""

    @property
    def filmed(self) -> bool:
        """Whether a run of it has a page (`system.view`); all but a system without a film."""
        return True

    @property
    def together(self) -> int:
        """How many dies it is best to measure at once."""
        return 1

    def measure_each(self, dies: Sequence[Die], conditions: Sequence[Condition]) -> list[Measurement]:
        """Measure dies under conditions, die after die; what fails gives a failed sample.

        A sample depends on its own die and condition alone, to the bit.
        """
        return [measure_safely(self, die, condition) for die in dies for condition in conditions]

    @abstractmethod
    def identity(self) -> str:
        """Give a hash of all that is measured: circuits with sizes and biases, process, stimuli, metrics."""


def measure_safely(target: Target, die: Die, condition: Condition) -> Measurement:
    """Measure one die; where the measurement raises an error, give a failed sample with its text.

    Raises `DataError`, of a file or of a model's record: it would be that of every sample.
    """
    return _safely(target, partial(target.measure, _at_corner(die, condition), condition))


def _at_corner(die: Die, condition: Condition) -> Die:
    return replace(die, corner=condition.corner)  # type: ignore[arg-type]  # was checked


def _safely(target: Target, measure: Callable[[], Measurement]) -> Measurement:
    try:
        return measure()
    except DataError:
        raise
    except Exception as error:  # noqa: BLE001 - a sample that fails is reported as failed
        reason = " ".join(str(error).split()) or type(error).__name__
        if not isinstance(error, CircuitError):
            reason = f"{type(error).__name__}: {reason}"
        return Measurement(FAILED, (math.nan,) * len(target.quantities), reason)


@lru_cache(maxsize=8)
def _opened(text: str) -> Target:
    return _open(_read_subject(text))


@dataclass(frozen=True, slots=True, eq=False)
class _Same:
    """An object that is another's equal where both are one."""

    it: object

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Same) and other.it is self.it

    def __hash__(self) -> int:
        return id(self.it)


@lru_cache(maxsize=8)
def _opened_object(same: _Same, text: str) -> Target:
    return _open(replace(_read_subject(text), target=same.it))


def open_target(subject: Subject) -> Target:
    """Give the target of a subject; each process makes it once and keeps it.

    Raises `UnknownNameError` and `ParameterError` naming the option that is wrong.
    """
    if not isinstance(subject.target, str):
        return _opened_object(_Same(subject.target), _write_subject(replace(subject, target="")))
    return _opened(_write_subject(hashed(subject)))


def hashed(subject: Subject) -> Subject:
    """Give a subject with the digest of the file that its target names; raises `DataError` for none there."""
    return subject if subject.code else replace(subject, code=digest_of(subject.target))


def _write_subject(subject: Subject) -> str:
    """Write a subject as text, which is the same for equal subjects."""
    return repr(asdict(subject))


def _read_subject(text: str) -> Subject:
    """Read a subject from what `_write_subject` wrote."""
    fields = ast.literal_eval(text)
    return Subject(**{**fields, "silicon": SiliconChoice(**fields["silicon"])})


def _open(subject: Subject) -> Target:
    if subject.noises or (isinstance(subject.target, str) and subject.target in {*SYSTEMS, *system_names()}):
        return SystemTarget(subject)
    return BlockTarget(subject)


class BlockTarget(Target):
    """A block or a chip with a testbench, whose equations are made at each temperature that is asked for."""

    def __init__(self, subject: Subject) -> None:
        """Read the options of the block, and find its metrics."""
        s = subject
        check_source(s.target, s.code)
        self.choice = choose(
            s.target, s.params, s.biases, s.bias_kind, s.silicon, s.stimuli, s.bias_set,
            BeginChoice(s.held, s.begin),
        )  # fmt: skip
        self.of_file = file_of(s.target) is not None
        self.engine, self.device = s.engine, s.device
        self.metrics = metrics_of(self.choice, s.metrics)
        if s.device == "gpu" and s.engine == NGSPICE:
            raise ParameterError("device: gpu, of the native engine, not of ngspice; leave one out")
        if s.engine == NGSPICE:
            self.metrics = metrics_in_ngspice(self.metrics)
            self.choice = choice_on_cards(self.choice)
        self._machines: dict[float, tuple[Machine, ...]] = {}

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """The numbers that are measured, one for each metric that has a value."""
        return tuple(Quantity(m.name, m.unit, m.yes_no) for m in self.metrics if m.value is not None)

    @property
    def runs_testbench(self) -> bool:
        """Whether some metric is measured in a run of the testbench, to which stimuli apply."""
        return self.engine == NGSPICE or any(runs_testbench(m) for m in self.metrics)

    def labels(self) -> tuple[str, ...]:
        """Labels of the draws of every transistor, and of the process."""
        machine = self._varied()
        if self.engine == NGSPICE:
            return Draws(machine.flat, machine.silicon).labels()
        return variation_labels(machine.flat, machine.silicon)

    def sigma(self) -> F64:
        """Standard deviation of what each draw moves, as `circuits.lowering.variation.variation_sigma`."""
        machine = self._varied()
        return variation_sigma(machine.flat, machine.silicon)

    @property
    def filmed(self) -> bool:
        """Whether it runs on our own devices, whose currents a page shows."""
        return self.engine != NGSPICE

    def draws(self, die: Die) -> F64:
        """Give the draws of a die in the order of the labels, float64[labels]."""
        machine = self._varied()
        if self.engine == NGSPICE:
            return Draws(machine.flat, machine.silicon).of(die)
        return variation_draws(machine.flat, machine.silicon, die)

    def _varied(self) -> Machine:
        """A machine with every device that varies, as all have; the testbench's without metrics."""
        machines = self.machines(self.choice.silicon.temperature_c)
        return machines[0] if machines else to_kernel(self.choice.testbench(), self.choice.silicon)

    def machines(self, temperature_c: float) -> tuple[Machine, ...]:
        """Give the machine of each measurement at a temperature, degC."""
        if temperature_c not in self._machines:
            silicon = replace(self.choice.silicon, temperature_c=temperature_c)
            self._machines[temperature_c] = tuple(
                self._begun(m.prepare(self.choice.circuit, silicon)) for m in measurements(self.metrics)
            )
        return self._machines[temperature_c]

    def nominal_run(self, temperature_c: float) -> Result | None:
        """Run the testbench on the nominal die at a temperature, degC, for what a run tells besides metrics.

        The result is None where no metric is measured in a run of the testbench, where that run fails, and
        for a study in ngspice.
        """
        if not self.runs_testbench or self.engine == NGSPICE:
            return None
        try:
            return simulate(on_die(self.machines(temperature_c)[0], NOMINAL), record=())
        except CircuitError:
            return None

    def _begun(self, machine: Machine) -> Machine:
        """The machine whose runs begin as was chosen, whatever testbench a metric has."""
        return replace(machine, testbench=begun(machine.testbench, self.choice.begin))

    def stimuli(self, die: Die, condition: Condition) -> Mapping[str, float | None]:
        """Give the stimuli under which the testbench shows what the first metric has measured on a die.

        These are the stimuli of the study, but for those by which the metric shows its own measurement.
        """
        first = self.metrics[0]
        if first.shown is None:
            return self.choice.stimuli
        k = measurements(self.metrics).index(first)
        found = first.measure(on_die(self.machines(condition.temperature_c)[k], die))
        return {**self.choice.stimuli, **first.shown(found)}

    def choice_on(self, die: Die, condition: Condition) -> Choice:
        """Give the block on a die under a condition, with the stimuli that show what was measured."""
        silicon = replace(self.choice.silicon, die=die, temperature_c=condition.temperature_c)
        return replace(self.choice, silicon=silicon, stimuli=self.stimuli(die, condition))

    def measure(self, die: Die, condition: Condition) -> Measurement:
        """Measure all metrics on a die; metrics that share a measurement are read from one."""
        machines = zip(measurements(self.metrics), self.machines(condition.temperature_c), strict=True)
        return self._judged({id(m.measure): m.measure(on_die(machine, die)) for m, machine in machines})

    @property
    def together(self) -> int:
        """How many dies it is best to measure at once: some where runs of the testbench go in lanes."""
        runs = [k for k, m in enumerate(measurements(self.metrics)) if m.measure is simulate]
        in_lanes = self.engine != NGSPICE and bool(runs)
        in_lanes = in_lanes and fits(self.machines(self.choice.silicon.temperature_c)[runs[0]])
        if self.device == "gpu":
            self._check_device(in_lanes=in_lanes)
            return _ON_DEVICE
        return 2 * WIDTH if in_lanes else 1

    def _check_device(self, *, in_lanes: bool) -> None:
        """Raise ParameterError where there is no graphics processor, or none of the runs can go there."""
        if not in_lanes:
            name = self.choice.circuit.name
            raise ParameterError(
                f"device: gpu, no run of {name} goes there: its metrics are of other measurements, or it "
                "has an amplifier, a diode or samples; leave it out"
            )
        gpu.cupy()

    def measure_each(self, dies: Sequence[Die], conditions: Sequence[Condition]) -> list[Measurement]:
        """Measure dies under conditions, die after die; runs of the testbench go together in lanes."""
        if self.together == 1:
            return super().measure_each(dies, conditions)
        columns = [self._in_lanes([_at_corner(die, c) for die in dies], c) for c in conditions]
        return [column[k] for k in range(len(dies)) for column in columns]

    def _in_lanes(self, dies: Sequence[Die], condition: Condition) -> list[Measurement]:
        """Measure dies under one condition."""
        shared = list(zip(measurements(self.metrics), self.machines(condition.temperature_c), strict=True))
        run, testbench = next((m, machine) for m, machine in shared if m.measure is simulate)
        try:
            runs = simulate_each(on_dies(testbench, dies), place=self.device)
        except CircuitError:  # of a die, which is told of each by itself
            return [measure_safely(self, die, condition) for die in dies]
        others = [(m, machine) for m, machine in shared if m is not run]

        def measure(die: Die, result: Result | Exception) -> Measurement:
            found = {id(m.measure): m.measure(on_die(machine, die)) for m, machine in others}
            return self._judged({id(simulate): _result(result), **found})

        return [_safely(self, partial(measure, *each)) for each in zip(dies, runs, strict=True)]

    def _judged(self, found: Mapping[int, Any]) -> Measurement:
        """What was found, by the measurement's identity, as values of all metrics."""
        first = measurements(self.metrics)[0]
        values = tuple(float(m.value(found[id(m.measure)])) for m in self.metrics if m.value is not None)
        judged = found[id(first.measure)]
        reasons = (first.reason(judged), *self._missing(found))
        return Measurement(first.outcome(judged), values, "; ".join(filter(None, reasons)))

    def _missing(self, found: Mapping[int, Any]) -> Iterator[str]:
        """Why metrics have no value in what was found, by the measurement's identity."""
        for m in self.metrics:
            why = "" if m.missing is None else m.missing(found[id(m.measure)])
            if why:
                yield f"{m.name}: {why}"

    def identity(self) -> str:
        """Give a hash of circuit, process, place, stimuli and metrics."""
        c = self.choice
        measured = [(m.name, m.measure.__module__, m.measure.__qualname__) for m in self.metrics]
        measured += [(m.name, "measure", m.summary) for m in self.metrics if m.missing is not None]
        begin = () if c.begin == FREE else (c.begin,)
        bench = (c.testbench(),) if self.of_file else ()
        by = () if self.engine == "native" else (self.engine, cards_digest(c.silicon))
        there = () if self.device == "cpu" else (self.device,)
        more = (*begin, *bench, *by, *there)
        return _digest(c.circuit, c.silicon.process, c.silicon.place, c.stimuli, measured, *more)


def _result(run: Result | Exception) -> Result:
    if isinstance(run, Exception):
        raise run
    return run


class SystemTarget(Target):
    """A system that is run on the silicon of each die; its metrics are numbers of a run's summary."""

    def __init__(self, subject: Subject) -> None:
        """Load the system; raises `UnknownNameError` for a metric that is not a number of its summary."""
        check_source(subject.target, subject.code)
        self._system = load_system(subject.target)
        law = {"law": subject.silicon.law} if "law" in self._system.settings else {}
        made: dict[str, str] = {}
        if subject.silicon.process is not None:
            made = self._made_in(subject.target, subject.silicon.process)
        check_known(read_die(subject.silicon), self._system.circuits())
        self._options, self._noises = {**law, **made, **subject.system}, subject.noises
        self._names = tuple(name.replace("-", "_") for name in subject.metrics)
        for name in self._names:
            if name not in self._system.metrics:
                raise unknown_name("metric", name, self._system.metrics)

    def _made_in(self, name: str, process: str) -> dict[str, str]:
        """The option of another process; raises `ParameterError` where the system has none, or it is none."""
        if "process" not in self._system.settings:
            raise ParameterError(f"process: {name} runs on models of its own process; leave it out")
        process_of(process)
        return {"process": process}

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """The numbers of a run's summary that are measured; their names carry their units."""
        return tuple(Quantity(name, "", name in self._system.yes_no) for name in self._names)

    @property
    def specifications(self) -> tuple[Specification, ...]:
        """The system's own definition of success, if success is among the metrics."""
        return (Success(self._system.success),) if SUCCEEDED in self._names else ()

    def labels(self) -> tuple[str, ...]:
        """Raise `ParameterError`: a system draws its dies by itself, so that no plan can."""
        raise ParameterError("plan: a system takes every die's own draws; use random")

    def draws(self, die: Die) -> F64:
        """Raise `ParameterError`, since the draws behind a system's die are not known."""
        raise ParameterError("contributions: not for a system; study its chips")

    def run(self, die: Die, condition: Condition, *, shown: bool = False) -> Any:
        """Run the system on a die; the condition's trial says which seeds noise and worlds have.

        shown: whether it is to be drawn, so that it keeps what no metric needs, as a flight's way.
        """
        seeds = self.seeds(die, condition.trial)
        with quietly():
            trace = self._system.run(self.scenario(die, condition, seeds, shown=shown))
        try:
            check_drawn(die)
        except UnknownNameError as error:  # which would be that of every sample
            raise DataError(str(error)) from None
        return trace

    def scenario(
        self, die: Die, condition: Condition, seeds: Mapping[str, int], *, shown: bool = False
    ) -> Any:
        """Give the scenario of a run on a die; seeds: by the names of its fields; shown: as `run`."""
        known = self._system.settings
        options = {one.field for one in known.values()} | set(known)
        asked = {k: v for k, v in self._options.items() if not shown or k in options}
        silicon = {"die": die, "temperature_c": condition.temperature_c}
        on_die = {name: value for name, value in silicon.items() if name in known}
        return self._system.scenario(**asked, **on_die, **seeds)

    def seeds(self, die: Die, trial: int) -> dict[str, int]:
        """Seeds of a trial's run on a die, by the names of a scenario's fields."""
        if not self._noises:
            return {"seed": trial}
        seed, noise_seed = seeds_of(die.number or 0, trial, self._noises)
        return {"seed": seed} | ({} if noise_seed is None else {"noise_seed": noise_seed})

    @property
    def filmed(self) -> bool:
        """Whether the system has a film."""
        return self._system.film is not None

    def film(self, trace: Any) -> Film:
        """Return the film of a run, of which the trace is given."""
        return self._system.filmed(trace)

    def draw(self, trace: Any, figure: Figure) -> None:
        """Draw a run, of which the trace is given, into a figure."""
        self._system.draw(trace, figure)

    def measure(self, die: Die, condition: Condition) -> Measurement:
        """Run the system on a die, and take the metrics from the summary of that run.

        The sample's class says whether the run has left the validity box of one of its chips.
        """
        trace = self.run(die, condition)
        summary = self._system.summarise(trace)
        values = (summary[name] for name in self._names)
        outcome = OUTSIDE if self._system.account(trace).outside else MEASURED
        return Measurement(outcome, tuple(math.nan if v is None else float(v) for v in values))

    def identity(self) -> str:
        """Give a hash of the system's circuits, of its options and of the metrics."""
        return _digest(self._system.circuits(), sorted(self._options.items()), self._names)


def _digest(*parts: object) -> str:
    with np.printoptions(threshold=sys.maxsize, floatmode="unique"):
        return hashlib.sha256(repr(parts).encode()).hexdigest()[:16]
