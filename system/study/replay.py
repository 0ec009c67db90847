"""One sample of a study again: the same die under the same condition, with its waveforms.

The measurement is repeated and held against what the study kept; for a block the testbench is run besides, in
our solver or in ngspice, and for a system its run is the measurement.
"""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from circuits.errors import DataError, ParameterError
from circuits.silicon.die import Die
from system.options.block import Choice
from system.options.code import code_of
from system.options.target import split_place
from system.study.engine import dies_of
from system.study.folder import study_table
from system.study.manifest import Study, read_dies, read_study
from system.study.table import Condition, select
from system.study.target import BlockTarget, Measurement, Target, open_target


@dataclass(frozen=True, slots=True)
class Replay:
    """A sample of a study that was measured again.

    Attributes
    ----------
    study : Study
        Study that the sample is of, as its folder has it.
    target : Target
        What was measured.
    die : Die
        Die that was measured.
    condition : Condition
        Where it was measured.
    kept : Measurement or None
        What the study has; None where it has nothing to be believed.
    again : Measurement
        What was measured now.
    note : str
        Why there is nothing to be believed; empty otherwise.
    changed : bool
        Whether the user's file that the study is of has changed since.
    """

    study: Study
    target: Target
    die: Die
    condition: Condition
    kept: Measurement | None
    again: Measurement
    note: str = ""
    changed: bool = False

    @property
    def identical(self) -> bool:
        """Whether the sample is the one that was kept, to the bit."""
        if self.kept is None:
            return False
        same = np.array_equal(self.kept.values, self.again.values, equal_nan=True)
        return same and (self.kept.outcome, self.kept.reason) == (self.again.outcome, self.again.reason)

    def choice(self) -> Choice:
        """The block on the sample's silicon; raises `ParameterError` for a system."""
        if not isinstance(self.target, BlockTarget):
            raise ParameterError(f"{self.study.subject.target}: a system has no testbench; use a block")
        return self.target.choice_on(self.die, self.condition)


def replay(
    folder: Path,
    number: int,
    corner: str | None = None,
    temperature_c: float | None = None,
    trial: int | None = None,
    own: Collection[str] = (),
    code: str | None = None,
    *,
    changed: bool = False,
) -> Replay:
    """Measure a die of a study again, at the study's first condition that fits what is given.

    Parameters
    ----------
    folder
        Folder of the study.
    number
        Number of the die.
    corner
        Corner of the condition; any unless given.
    temperature_c
        Temperature of the condition, degC; any unless given.
    trial
        Trial of the condition; any unless given.
    own
        Functions of the user's (`MODULE:FUNCTION`) that the study may have been measured with.
    code, changed
        Code of the user's that it may be of, and whether its file may have changed
        (`system.study.manifest.read_study`).

    Raises
    ------
    DataError
        There is no study.
    ParameterError
        It has no such sample, or was measured with another function.
    """
    study = read_study(folder, own, code, changed=changed)
    target = open_target(study.subject)
    condition = _condition(study, corner, temperature_c, trial)
    die = replace(_die_in(study, number), corner=condition.corner)  # type: ignore[arg-type]  # was checked
    kept, note = _kept(folder, number, condition)
    (again,) = target.measure_each([die], [condition])
    other = study.subject.code != read_dies(folder).subject.code
    return Replay(study, target, die, condition, kept, again, note, other)


def die_of(folder: Path, number: int) -> Die:
    """Give a die of a study by its number, under the study's plan.

    `folder` is the study's, `number` the number of the die. Raises `ParameterError` for one that the study
    does not have.
    """
    study = read_dies(folder)
    names = (study.subject.target, split_place(study.subject.silicon.at or "")[0])
    if study.plan.method != "random" and any(map(code_of, names)):
        raise ParameterError(
            f"study: {folder} draws its dies by labels of code that no file loads; use replay,"
            " which takes the code's name"
        )
    return _die_in(study, number)


def _die_in(study: Study, number: int) -> Die:
    if number not in study.dies:
        last = study.dies.stop - 1
        raise ParameterError(f"die: {number}, must be {study.dies.start} to {last}, the study's dies")
    (die,) = dies_of(study, range(number, number + 1))
    return die


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
    raise ParameterError(f"corner, temperature and trial: no such condition; the study has {known}")


def _kept(folder: Path, number: int, condition: Condition) -> tuple[Measurement | None, str]:
    """What a study has of a sample, or None and why not."""
    try:
        table = study_table(folder)
    except DataError as error:
        return None, str(error)
    mask = (table.die == number) & (table.temperature_c == condition.temperature_c)
    mask &= (table.trial == condition.trial) & (np.array(table.corner, dtype=object) == condition.corner)
    found = select(table, mask.astype(np.bool_))
    if not len(found):
        return None, "the study has not measured this sample yet"
    return Measurement(found.outcome[0], tuple(found.values[0].tolist()), found.reason[0]), ""
