"""The manifest of a study says what the study measures; here it is written and read.

The manifest is the file `study.json`, which is written before the first sample. When a study is resumed, the
new study is compared with it in everything that decides a sample: the target and the hash of its circuit, the
lot, the sampling plan, the conditions and the chunks. Versions of packages are kept for the reader alone.

A manifest is data and never loads code. A study that was measured with functions of the user's own names
them, and its samples are measured again only for a user who names the same functions.
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
from system.files.document import folder_bytes, from_json
from system.files.writing import write_text_atomic
from system.study.metrics.metric import is_own
from system.study.plan import Plan
from system.study.source import named_source, place_beside
from system.study.table import MOST, Condition
from system.study.target import Subject, hashed, open_target

FILE = "study.json"
FORMAT: Literal[1] = 1
_PACKAGES = ("noctule", "numpy", "scipy", "numba", "xarray")
_REMEDY = "begin the study again in another folder"
_OF_SAMPLES = ("format", "circuit", "subject", "plan", "conditions", "chunk")


@dataclass(frozen=True, slots=True)
class Study:
    """A study: everything that decides its samples.

    Attributes
    ----------
    subject : Subject
        What is measured: a target with its options, and metrics of it.
    plan : Plan
        The dies, and how their deviations are drawn.
    conditions : tuple of Condition
        Corners, temperatures and trials under which every die is measured.
    chunk : int
        How many dies are measured and kept together.

    Raises
    ------
    ParameterError
        There are more samples than a table holds, a chunk has no dies, there is no condition, or the subject
        names one die already.
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
        """Numbers of all dies of the study."""
        return range(self.plan.first, self.plan.first + self.plan.count)

    @property
    def samples(self) -> int:
        """Number of samples of the whole study: its dies times its conditions."""
        return self.plan.count * len(self.conditions)

    def chunks(self) -> list[range]:
        """Numbers of the dies of each chunk, in order; the last chunk may be shorter."""
        return [
            range(start, min(start + self.chunk, self.dies.stop))
            for start in range(self.dies.start, self.dies.stop, self.chunk)
        ]


def check_samples(dies: int, conditions: int) -> None:
    """Raise `ParameterError` where so many dies at so many conditions are more samples than a table holds."""
    if max(dies, 1) * conditions > MOST:
        raise ParameterError(
            f"samples: {dies} dies at {conditions} conditions (corners, temperatures, trials),"
            f" must be at most {MOST} samples; take fewer, or several studies"
        )


class _Manifest(msgspec.Struct, forbid_unknown_fields=True):
    """The document: a study, the hash of its circuit, and how it was asked for.

    format : version of the document.
    circuit : hash of what is measured, of its circuits and process.
    chunk : how many dies are measured and kept together.
    command : words of the command that asked for the study.
    versions : of the packages with which it was begun.
    """

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
    """Give the manifest of a study as a document of JSON's own types, as `read_manifest` reads it back.

    command: words of the command that asked for the study.
    """
    if not isinstance(study.subject.target, str):
        kind = type(study.subject.target).__name__
        raise ParameterError(
            f"target: of type {kind}, which a manifest cannot have; keep no folder, or name a file of it"
        )
    return _plain(
        _Manifest(
            FORMAT,
            open_target(study.subject).identity(),
            hashed(study.subject),
            study.plan,
            study.conditions,
            study.chunk,
            tuple(command),
            {name: version(name) for name in _PACKAGES},
        )
    )


def write_manifest(folder: Path, document: Mapping[str, Any]) -> None:
    """Write a document of `describe` to a study's folder; raises `DataError` where that cannot be written."""
    write_text_atomic(folder / FILE, json.dumps(document, indent=2) + "\n")


def read_manifest(folder: Path) -> dict[str, Any]:
    """Read the manifest of a study's folder; raises `DataError` for a folder without one, or a broken one."""
    return _plain(_read(folder))


def read_study(
    folder: Path, own: Collection[str] = (), code: str | None = None, *, changed: bool = False
) -> Study:
    """Read the study in `folder`.

    Raises `DataError` for a folder without a study, and `ParameterError` naming a function that the study
    needs and `own` does not have, or the code that it is of where `code` is not that.

    Parameters
    ----------
    own
        The user's functions (`MODULE:FUNCTION`) that may be loaded for it.
    code
        The user's code that it is of, as `my_circuit.py:follower`, which may be run for it.
    changed
        Whether the file of that code may have changed since.
    """
    study = _read(folder).study()
    subject = study.subject
    target, digest = named_source(folder, subject.target, subject.code, code, changed=changed)
    silicon = replace(subject.silicon, at=place_beside(folder, subject.silicon.at, subject.target, target))
    study = replace(study, subject=replace(subject, target=target, code=digest, silicon=silicon))
    for name in filter(is_own, study.subject.metrics):
        if name not in own:
            raise ParameterError(
                f"metric: {folder} was measured with {name}, code that no file loads; add `metric={name}`"
            )
    return study


def read_dies(folder: Path) -> Study:
    """Read the study of a folder for its dies alone: without the user's own metrics, which decide no die."""
    study = _read(folder).study()
    registered = tuple(name for name in study.subject.metrics if not is_own(name))
    return replace(study, subject=replace(study.subject, metrics=registered))


def study_key(document: Mapping[str, Any]) -> str:
    """Give the key of a manifest's study, a SHA-256 digest, which every table of the study carries.

    A study that is lengthened keeps its key, if its plan can be extended.
    """
    kept = {name: document[name] for name in _OF_SAMPLES}
    if Plan(**document["plan"]).extensible:
        kept["plan"] = {**document["plan"], "count": None}
    return hashlib.sha256(json.dumps(kept, sort_keys=True).encode()).hexdigest()


def check_same(
    folder: Path, study: Study, document: Mapping[str, Any], what: str = "resume",
    remedy: str = "begin another study",
) -> None:  # fmt: skip
    """Raise `ParameterError` naming the first difference between a folder's study and another.

    document: the manifest of the other study; what, remedy: first word and end of the refusal. More dies are
    no difference, if its plan can be extended.
    """
    old, new = read_manifest(folder), {name: document[name] for name in _OF_SAMPLES}
    if study.plan.extensible and study.plan.count >= old["plan"]["count"]:
        new["plan"] = old["plan"] | {k: v for k, v in new["plan"].items() if k != "count"}
    for name, before, now in _differences(old, new):
        raise ParameterError(f"{what}: {folder} has {name} {before}, asked for {now}; {remedy}")


def _read(folder: Path) -> _Manifest:
    path = folder / FILE
    data = folder_bytes(folder, FILE, "study", _REMEDY)
    found = from_json(data, _Manifest, f"{path}: broken", _REMEDY)
    # a dataclass takes fields that it does not know, and drops them
    for name, _, _ in _differences(_plain(found), from_json(data, dict, str(path), _REMEDY)):
        raise DataError(f"{path}: broken: {name}: no study has that; {_REMEDY}")
    if not isinstance(found.subject.target, str):
        raise DataError(f"{path}: broken: subject.target: must be text; {_REMEDY}")
    try:
        found.study()
    except ParameterError as error:
        raise DataError(f"{path}: broken: {error}") from None
    return found


_EDITS = ("heal", "only", "deviate")  # of the silicon


def _plain(manifest: _Manifest) -> dict[str, Any]:
    """Without options of the subject that say nothing: studies from before they were there stay the same."""
    plain: dict[str, Any] = json.loads(json.dumps(msgspec.to_builtins(manifest)))
    plain["subject"] = {name: plain["subject"][name] for name in stated(manifest.subject)}
    silicon = plain["subject"]["silicon"]
    plain["subject"]["silicon"] = {n: v for n, v in silicon.items() if n not in _EDITS or v}
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
