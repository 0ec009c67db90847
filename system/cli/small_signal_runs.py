"""What the analyses about a rest state share: their options, their runs over dies, their files."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Generic, TypeVar

import numpy as np
import xarray as xr

from circuits.arrays import F64
from circuits.circuit import BiasKind
from circuits.errors import ParameterError, SolverError
from circuits.solver.noise.analysis import Noise
from circuits.solver.operating_point import OperatingPoint, operating_point
from circuits.solver.small_signal import Response, frequency_grid
from circuits.units import parse_quantity
from netlists.ngspice.deadline import DEADLINE
from system.cli.analysis_options import AnalysisChoice
from system.cli.output import print_line, working
from system.options.begin import FREE, BeginChoice
from system.options.block import Choice, choose, describe_silicon
from system.options.silicon import SiliconChoice

Answer = TypeVar("Answer", Response, Noise)

NOMINAL_DIE = -1  # in CSV and netCDF, where a number must stand


@dataclass(frozen=True, slots=True)
class Run(Generic[Answer]):
    """One die at one temperature; `answer` is None with a reason where the circuit has no rest state."""

    choice: Choice
    stable: bool
    answer: Answer | None
    reason: str = ""

    @property
    def die(self) -> int:
        """Number of the die, -1 for the nominal one."""
        number = self.choice.silicon.die.number
        return NOMINAL_DIE if number is None else number


@dataclass(frozen=True, slots=True)
class Request:
    """A block with its options, as texts, and what is asked of it."""

    block: str
    params: Sequence[str]
    biases: Sequence[str]
    bias_set: str | None
    bias_kind: BiasKind | None
    silicon: SiliconChoice
    stimuli: Sequence[str]
    analysis: AnalysisChoice
    engine: str = "native"
    begin: BeginChoice = FREE
    deadline_s: float = DEADLINE

    def frequencies(self) -> F64:
        """Grid of the analysis, Hz."""
        return frequency_grid(*self.grid())

    def grid(self) -> tuple[float, float, int]:
        """Lowest and highest frequency (Hz), and how many a decade."""
        a = self.analysis
        low = parse_quantity(a.low or "1Hz", "Hz", "--from")
        high = parse_quantity(a.high or "1MHz", "Hz", "--to")
        return low, high, 20 if a.points is None else a.points

    def silicons(self) -> list[SiliconChoice]:
        """Every temperature with every die."""
        a, one = self.analysis, self.silicon
        if a.dies is not None and one.die is not None:
            raise ParameterError(f"--die: {one.die} beside --dies {a.dies}, must be one of the two")
        if a.temperatures is not None and one.temperature != "27":
            text = f"--temperature: {one.temperature} beside --temperatures {a.temperatures}"
            raise ParameterError(f"{text}, must be one of the two")
        temperatures = [one.temperature] if a.temperatures is None else a.temperatures.split(",")
        dies = [one.die] if a.dies is None else read_dies(a.dies)
        pairs = itertools.product(temperatures, dies)
        return [replace(one, temperature=t.strip(), die=d) for t, d in pairs]

    def chosen(self, silicon: SiliconChoice) -> Choice:
        """The block on one of them."""
        return choose(
            self.block, self.params, self.biases, self.bias_kind, silicon, self.stimuli, self.bias_set,
            self.begin,
        )  # fmt: skip


def read_dies(text: str) -> list[int]:
    """Numbers of the dies in `1000-1019`, both ends included."""
    first, _, last = text.partition("-")
    if not (first.isdigit() and last.isdigit() and int(first) <= int(last) < int(first) + 100_000):
        raise ParameterError(f"--dies: {text}, must be FIRST-LAST, rising; write as 1000-1019")
    return list(range(int(first), int(last) + 1))


def runs_of(request: Request, solve: Callable[[OperatingPoint, Choice], Answer]) -> list[Run[Answer]]:
    """Solve on all silicon; raises the first reason where none has an answer."""
    runs: list[Run[Answer]] = []
    errors: list[SolverError] = []
    with working(f"analysing {request.block} (the first run compiles its kernels)"):
        for silicon in request.silicons():
            choice = request.chosen(silicon)
            try:
                point = operating_point(choice.testbench(), choice.silicon)
                runs.append(Run(choice, point.stable, solve(point, choice)))
            except SolverError as error:
                errors.append(error)
                runs.append(Run(choice, stable=False, answer=None, reason=str(error)))
    if len(errors) == len(runs):
        raise errors[0]
    return runs


def head_of(request: Request, runs: Sequence[Run[Any]]) -> dict[str, Any]:
    """Return what all runs share, by the names that JSON has."""
    return {
        "block": runs[0].choice.block.name,
        "analysis": request.analysis.analysis,
        "stimuli": runs[0].choice.stimuli,
        "failed": sum(run.answer is None for run in runs),
    }


def place_of(run: Run[Any]) -> dict[str, Any]:
    """Return where a run stands and how it went, by the names that JSON has."""
    return {**describe_silicon(run.choice.silicon), "stable": run.stable, "reason": run.reason or None}


def label_of(run: Run[Any]) -> str:
    """Temperature and die in words."""
    return f"{run.choice.silicon.temperature_c:g} °C, {run.choice.silicon.die}"


def cell_of(text: str) -> str:
    """Return a CSV cell."""
    return f'"{text}"' if "," in text else text


def row_of(run: Run[Any], frequency: float, numbers: Sequence[float] | F64) -> str:
    """Return a CSV line: temperature, die, frequency, numbers."""
    texts = ["" if np.isnan(x) else f"{x:.12g}" for x in numbers]
    return ",".join([f"{run.choice.silicon.temperature_c:g}", str(run.die), f"{frequency:.12g}", *texts])


def dataset_of(runs: Sequence[Run[Any]], parts: Mapping[str, tuple[tuple[str, ...], Any, str]]) -> xr.Dataset:
    """Runs, the temperatures outside and the dies inside, as labelled arrays."""
    temperatures = list(dict.fromkeys(run.choice.silicon.temperature_c for run in runs))
    dies = list(dict.fromkeys(run.die for run in runs))
    grid = (len(temperatures), len(dies))
    data = xr.Dataset(
        {
            name: (("temperature", "die", *dims), np.reshape(values, (*grid, *np.shape(values)[1:])))
            for name, (dims, values, _) in parts.items()
        },
        {"temperature": temperatures, "die": dies},
    )
    data["stable"] = (("temperature", "die"), np.reshape([run.stable for run in runs], grid))
    for name, (_, _, unit) in parts.items():
        data[name].attrs["units"] = unit
    first = runs[0].choice
    return data.assign_attrs(block=first.block.name, lot=first.silicon.die.lot, nominal_die=NOMINAL_DIE)


def print_failures(runs: Sequence[Run[Any]]) -> None:
    """Say why runs have no answer."""
    for run in runs:
        if run.answer is None:
            print_line(f"{label_of(run)}: {run.reason}")
