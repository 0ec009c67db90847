"""Options, runs over dies and files that the analyses about a rest state share."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Generic, TypeVar

import numpy as np

from circuits.arrays import F64
from circuits.catalogue import later
from circuits.errors import ParameterError, SolverError
from circuits.solver.noise.analysis import Noise
from circuits.solver.operating_point import OperatingPoint, operating_point
from circuits.solver.small_signal import Response, frequency_grid
from circuits.units import parse_quantity
from system.cli.block_choice import choose_block
from system.cli.output import print_line, working
from system.cli.simulate_verb import Simulate
from system.options.block import Choice, describe_silicon
from system.options.silicon import SiliconChoice

if TYPE_CHECKING:
    import xarray as xr
else:
    xr = later("xarray")


Answer = TypeVar("Answer", Response, Noise)

NOMINAL_DIE = -1  # in CSV and netCDF, where a number must stand


@dataclass(frozen=True, slots=True)
class Run(Generic[Answer]):
    """Analysis of one die at one temperature.

    Attributes
    ----------
    choice : block on its silicon.
    stable : whether the rest state is stable.
    answer : response or noise; None where the circuit has no rest state.
    reason : why there is no answer; empty where there is one.
    """

    choice: Choice
    stable: bool
    answer: Answer | None
    reason: str = ""

    @property
    def die(self) -> int:
        """The number of the die, -1 for the nominal one."""
        number = self.choice.silicon.die.number
        return NOMINAL_DIE if number is None else number


def grid_of(asked: Simulate) -> tuple[float, float, int]:
    """Give the lowest and the highest frequency, Hz, and the number of frequencies in a decade."""
    low = parse_quantity(asked.low or "1Hz", "Hz", "--from")
    high = parse_quantity(asked.high or "1MHz", "Hz", "--to")
    return low, high, 20 if asked.points is None else asked.points


def frequencies_of(asked: Simulate) -> F64:
    """Give the frequencies of the analysis, Hz, float64[F]."""
    return frequency_grid(*grid_of(asked))


def _silicons_of(asked: Simulate) -> list[SiliconChoice]:
    """Every temperature with every die."""
    one = asked.silicon
    if asked.dies is not None and one.die is not None:
        raise ParameterError(f"--die: {one.die} beside --dies {asked.dies}, must be one of the two")
    if asked.temperatures is not None and one.temperature is not None:
        text = f"--temperature: {one.temperature} beside --temperatures {asked.temperatures}"
        raise ParameterError(f"{text}, must be one of the two")
    several = None if asked.temperatures is None else asked.temperatures.split(",")
    temperatures = [one.temperature] if several is None else [text.strip() for text in several]
    dies = [one.die] if asked.dies is None else read_dies(asked.dies)
    pairs = itertools.product(temperatures, dies)
    return [replace(one, temperature=t, die=d) for t, d in pairs]


def read_dies(text: str) -> list[int]:
    """Read the numbers of dies from a text as `1000-1019`, both ends included.

    Raises `ParameterError` for a text of another form.
    """
    first, _, last = text.partition("-")
    if not (first.isdigit() and last.isdigit() and int(first) <= int(last) < int(first) + 100_000):
        raise ParameterError(f"--dies: {text}, must be FIRST-LAST, rising; write as 1000-1019")
    return list(range(int(first), int(last) + 1))


def runs_of(asked: Simulate, solve: Callable[[OperatingPoint, Choice], Answer]) -> list[Run[Answer]]:
    """Analyse the block on every die at every temperature that is asked for.

    solve: analyses the block about its operating point. Raises the first `SolverError` where no die has an
    answer.
    """
    runs: list[Run[Answer]] = []
    errors: list[SolverError] = []
    with working(f"analysing {asked.block}"):
        for silicon in _silicons_of(asked):
            choice = choose_block(asked.block, asked.values, silicon, asked.stimulus, asked.begin)
            try:
                point = operating_point(choice.testbench(), choice.silicon)
                runs.append(Run(choice, point.stable, solve(point, choice)))
            except SolverError as error:
                errors.append(error)
                runs.append(Run(choice, stable=False, answer=None, reason=str(error)))
    if len(errors) == len(runs):
        raise errors[0]
    return runs


def head_of(asked: Simulate, runs: Sequence[Run[Any]]) -> dict[str, Any]:
    """Give what all runs share, by the names that JSON has."""
    return {
        "block": runs[0].choice.block.name,
        "analysis": asked.analysis,
        "stimuli": runs[0].choice.stimuli,
        "failed": sum(run.answer is None for run in runs),
    }


def place_of(run: Run[Any]) -> dict[str, Any]:
    """Give the silicon of a run and how it went, by the names that JSON has."""
    return {**describe_silicon(run.choice.silicon), "stable": run.stable, "reason": run.reason or None}


def label_of(run: Run[Any]) -> str:
    """Give the temperature and the die of a run in words."""
    return f"{run.choice.silicon.temperature_c:g} °C, {run.choice.silicon.die}"


def cell_of(text: str) -> str:
    """Give a text as a CSV cell, quoted where it has a comma."""
    return f'"{text}"' if "," in text else text


def row_of(run: Run[Any], frequency: float, numbers: Sequence[float] | F64) -> str:
    """Give a CSV line: temperature, degC, die, frequency, Hz, and the numbers.

    A number that is NaN is an empty cell.
    """
    texts = ["" if np.isnan(x) else f"{x:.12g}" for x in numbers]
    return ",".join([f"{run.choice.silicon.temperature_c:g}", str(run.die), f"{frequency:.12g}", *texts])


def dataset_of(runs: Sequence[Run[Any]], parts: Mapping[str, tuple[tuple[str, ...], Any, str]]) -> xr.Dataset:
    """Give runs as labelled arrays over temperature and die.

    parts: dimensions, values and unit of each array, by its name; values have a first axis over the runs,
    whose dies vary fastest.
    """
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
    """Print why runs have no answer, a line for each of them."""
    for run in runs:
        if run.answer is None:
            print_line(f"{label_of(run)}: {run.reason}")
