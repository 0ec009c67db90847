"""One sample of a study again: the same die under the same condition, with its waveforms.

The measurement is repeated and held against what the study kept; for a block the testbench is run besides, in
our solver or in ngspice, and for a system its run is the measurement.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from circuits.die import Die
from circuits.errors import DataError, ParameterError
from circuits.silicon import Silicon
from circuits.solver.transient import Result
from circuits.testbench import Testbench
from system.options import Choice
from system.study.engine import CHUNKS, SAMPLES, dies_of
from system.study.manifest import Study, read_study
from system.study.table import Condition, Table, join, read_table, select
from system.study.target import BlockTarget, Measurement, Target, measure_safely, open_target

Engine = Callable[[Testbench, Silicon], Result]


@dataclass(frozen=True, slots=True)
class Replay:
    """A sample again. `kept`: what the study has, None where it was not measured there."""

    study: Study
    target: Target
    die: Die
    condition: Condition
    kept: Measurement | None
    again: Measurement

    @property
    def identical(self) -> bool:
        """Whether the sample came out as it was kept, to the bit."""
        if self.kept is None:
            return False
        same = np.array_equal(self.kept.values, self.again.values, equal_nan=True)
        return same and (self.kept.outcome, self.kept.reason) == (self.again.outcome, self.again.reason)

    def choice(self) -> Choice:
        """The block on the sample's silicon; raises `ParameterError` for a system."""
        if not isinstance(self.target, BlockTarget):
            raise ParameterError(f"{self.study.subject.target}: a system has no testbench; use a block")
        silicon = replace(
            self.target.choice.silicon, die=self.die, temperature_c=self.condition.temperature_c
        )
        return replace(self.target.choice, silicon=silicon)


def replay(
    folder: Path,
    number: int,
    corner: str | None = None,
    temperature_c: float | None = None,
    trial: int | None = None,
) -> Replay:
    """Measure a die of the study in `folder` again, at its first condition that fits what is given.

    Raises `DataError` where there is no study, `ParameterError` where it has no such sample.
    """
    study = read_study(folder)
    target = open_target(study.subject)
    condition = _condition(study, corner, temperature_c, trial)
    die = replace(die_of(folder, number), corner=condition.corner)  # type: ignore[arg-type]  # was checked
    kept = _kept(folder, number, condition)
    return Replay(study, target, die, condition, kept, measure_safely(target, die, condition))


def die_of(folder: Path, number: int) -> Die:
    """A die of a study, under its plan; raises `ParameterError` for one that it does not have."""
    study = read_study(folder)
    if number not in study.dies:
        last = study.dies.stop - 1
        raise ParameterError(f"--die: {number}, must be {study.dies.start} to {last}, the study's dies")
    (die,) = dies_of(study, open_target(study.subject), range(number, number + 1))
    return die


def study_table(folder: Path) -> Table:
    """Samples of a study: the final table, or of an unfinished one the chunks that are there.

    Raises `DataError` where there are none, or one cannot be read.
    """
    if (folder / SAMPLES).exists():
        return read_table(folder / SAMPLES)
    chunks = sorted((folder / CHUNKS).glob("*.nc"))
    if not chunks:
        raise DataError(f"{folder}: no samples yet; run the study first")
    return join([read_table(path) for path in chunks])


def _condition(study: Study, corner: str | None, temperature_c: float | None, trial: int | None) -> Condition:
    for condition in study.conditions:
        wanted = (
            corner in {None, condition.corner},
            temperature_c is None or math.isclose(temperature_c, condition.temperature_c, abs_tol=1e-9),
            trial in {None, condition.trial},
        )
        if all(wanted):
            return condition
    known = ", ".join(f"{c.corner} {c.temperature_c:g} degC trial {c.trial}" for c in study.conditions)
    raise ParameterError(f"--corner, --temperature, --trial: no such condition; the study has {known}")


def _kept(folder: Path, number: int, condition: Condition) -> Measurement | None:
    table = study_table(folder)
    mask = (table.die == number) & (table.temperature_c == condition.temperature_c)
    mask &= (table.trial == condition.trial) & (np.array(table.corner, dtype=object) == condition.corner)
    found = select(table, mask.astype(np.bool_))
    if not len(found):
        return None
    return Measurement(found.outcome[0], tuple(found.values[0].tolist()), found.reason[0])
