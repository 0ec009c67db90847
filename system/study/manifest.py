"""A study's manifest: what was asked for, in a form that a resumed study can be held against.

`study.json` lies in the study's folder from its first moment. A resume compares everything that decides a
sample: the target with its circuit's hash, lot, plan, conditions, chunks. Versions are kept for the record.
What is read is data and never code: a study that was measured with the user's own functions names them, and
is given out to whoever names them too.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from importlib.metadata import version
from pathlib import Path
from typing import Any, Literal

import msgspec

from circuits.brief import stated
from circuits.errors import DataError, ParameterError
from system.files.document import document_bytes, from_json
from system.files.writing import write_text_atomic
from system.study.metric import is_own
from system.study.plan import Plan
from system.study.table import MOST, Condition
from system.study.target import Subject, open_target

FILE = "study.json"
FORMAT: Literal[1] = 1
_PACKAGES = ("noctule", "numpy", "scipy", "numba", "xarray")
_REMEDY = "begin the study again in another folder"
_OF_SAMPLES = ("format", "circuit", "subject", "plan", "conditions", "chunk")


@dataclass(frozen=True, slots=True)
class Study:
    """Everything that decides the samples. `chunk`: dies that are measured and kept together.

    Raises `ParameterError` for more samples than a table holds, a chunk of none, and a subject that is one
    die already.
    """

    subject: Subject
    plan: Plan
    conditions: tuple[Condition, ...]
    chunk: int

    def __post_init__(self) -> None:
        """Check the counts."""
        silicon = self.subject.silicon
        if silicon.die is not None or silicon.study is not None:
            raise ParameterError(
                "subject.silicon: names a die, must leave it to the plan; set neither die nor study"
            )
        if self.chunk < 1:
            raise ParameterError(f"chunk: {self.chunk}, must be at least 1")
        if not self.conditions:
            raise ParameterError("conditions: none, must be at least one; give a temperature and a corner")
        check_samples(self.plan.count, len(self.conditions))

    @property
    def dies(self) -> range:
        """Numbers of the dies."""
        return range(self.plan.first, self.plan.first + self.plan.count)

    @property
    def samples(self) -> int:
        """How many samples a whole study has."""
        return self.plan.count * len(self.conditions)

    def chunks(self) -> list[range]:
        """Dies of each chunk, in order."""
        return [
            range(start, min(start + self.chunk, self.dies.stop))
            for start in range(self.dies.start, self.dies.stop, self.chunk)
        ]


def check_samples(dies: int, conditions: int) -> None:
    """Raise `ParameterError` for more samples than a table holds."""
    if max(dies, 1) * conditions > MOST:
        raise ParameterError(
            f"samples: {dies} dies at {conditions} conditions (corners, temperatures, trials),"
            f" must be at most {MOST} samples; take fewer, or several studies"
        )


class _Manifest(msgspec.Struct, forbid_unknown_fields=True):
    """The document: a study, the hash of its circuit, and how it was asked for."""

    format: Literal[1]
    circuit: str
    subject: Subject
    plan: Plan
    conditions: tuple[Condition, ...]
    chunk: int
    command: tuple[str, ...] = ()
    versions: dict[str, str] = {}

    def study(self) -> Study:
        """Raises `ParameterError` where no study has such numbers."""
        return Study(self.subject, self.plan, self.conditions, self.chunk)


def describe(study: Study, command: Sequence[str] = ()) -> dict[str, Any]:
    """The manifest's document, as it is read back."""
    return _plain(
        _Manifest(
            FORMAT,
            open_target(study.subject).identity(),
            study.subject,
            study.plan,
            study.conditions,
            study.chunk,
            tuple(command),
            {name: version(name) for name in _PACKAGES},
        )
    )


def write_manifest(folder: Path, document: Mapping[str, Any]) -> None:
    """Write what `describe` gave; `DataError` where the folder cannot be written."""
    write_text_atomic(folder / FILE, json.dumps(document, indent=2) + "\n")


def read_manifest(folder: Path) -> dict[str, Any]:
    """Read a manifest; raises `DataError` for a folder that has none, or a broken one."""
    return _plain(_read(folder))


def read_study(folder: Path, own: Collection[str] = ()) -> Study:
    """The study of a folder.

    own: functions of the user's that it may have been measured with (`MODULE:FUNCTION`). Raises `DataError`
    for a folder that has no study, `ParameterError` naming a function that is not among them.
    """
    study = _read(folder).study()
    for name in filter(is_own, study.subject.metrics):
        if name not in own:
            raise ParameterError(
                f"metric: {folder} was measured with {name}, code that no file loads; add `metric={name}`"
            )
    return study


def read_dies(folder: Path) -> Study:
    """The study of a folder for its dies alone: without functions of the user's, which decide none."""
    study = _read(folder).study()
    registered = tuple(name for name in study.subject.metrics if not is_own(name))
    return replace(study, subject=replace(study.subject, metrics=registered))


def study_key(document: Mapping[str, Any]) -> str:
    """Key of a manifest's study, which its tables carry; more dies of a plan that can be extended keep it."""
    kept = {name: document[name] for name in _OF_SAMPLES}
    if Plan(**document["plan"]).extensible:
        kept["plan"] = {**document["plan"], "count": None}
    return hashlib.sha256(json.dumps(kept, sort_keys=True).encode()).hexdigest()


def check_same(folder: Path, study: Study, document: Mapping[str, Any]) -> None:
    """Raise `ParameterError` naming what differs between a folder's study and this one with its `document`.

    More dies of a plan that can be extended are no difference.
    """
    old, new = read_manifest(folder), {name: document[name] for name in _OF_SAMPLES}
    if study.plan.extensible and study.plan.count >= old["plan"]["count"]:
        new["plan"] = old["plan"] | {k: v for k, v in new["plan"].items() if k != "count"}
    for name, before, now in _differences(old, new):
        raise ParameterError(f"resume: {folder} has {name} {before}, asked for {now}; begin another study")


def _read(folder: Path) -> _Manifest:
    path = folder / FILE
    try:
        data = document_bytes(path, _REMEDY)
    except (FileNotFoundError, NotADirectoryError):
        raise DataError(f"{folder}: no study, there is no {FILE}; name a study's folder") from None
    found = from_json(data, _Manifest, f"{path}: broken", _REMEDY)
    # a dataclass takes fields that it does not know, and drops them
    for name, _, _ in _differences(_plain(found), from_json(data, dict, str(path), _REMEDY)):
        raise DataError(f"{path}: broken: {name}: no study has that; {_REMEDY}")
    try:
        found.study()
    except ParameterError as error:
        raise DataError(f"{path}: broken: {error}") from None
    return found


def _plain(manifest: _Manifest) -> dict[str, Any]:
    """Without options of the subject that say nothing: studies from before they were there stay the same."""
    plain: dict[str, Any] = json.loads(json.dumps(msgspec.to_builtins(manifest)))
    plain["subject"] = {name: plain["subject"][name] for name in stated(manifest.subject)}
    return plain


def _differences(
    old: Mapping[str, Any], new: Mapping[str, Any], prefix: str = ""
) -> list[tuple[str, Any, Any]]:
    found: list[tuple[str, Any, Any]] = []
    for key, now in new.items():
        before = old.get(key)
        if isinstance(now, dict) and isinstance(before, dict):
            found += _differences(before, now, f"{prefix}{key}.")
        elif before != now:
            found.append((prefix + key, before, now))
    return found
