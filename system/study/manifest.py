"""A study's manifest: what was asked for, in a form that a resumed study can be held against.

`study.json` lies in the study's folder from its first moment. A resume compares everything that decides a
sample: the target with its circuit's hash, lot, plan, conditions, chunks. Versions are kept for the record.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

from circuits.brief import stated
from circuits.errors import DataError, ParameterError
from system.files import write_text_atomic
from system.silicon_choice import SiliconChoice
from system.study.plan import Plan
from system.study.table import Condition
from system.study.target import Subject, open_target

FILE = "study.json"
FORMAT = 1
_PACKAGES = ("noctule", "numpy", "scipy", "numba", "xarray")


@dataclass(frozen=True, slots=True)
class Study:
    """Everything that decides the samples. `chunk`: dies that are measured and kept together."""

    subject: Subject
    plan: Plan
    conditions: tuple[Condition, ...]
    chunk: int

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


def describe(study: Study) -> dict[str, Any]:
    """The manifest's document, as it is read back."""
    document = {
        "format": FORMAT,
        "circuit": open_target(study.subject).identity(),
        "subject": {k: v for k, v in asdict(study.subject).items() if k in stated(study.subject)},
        "plan": asdict(study.plan),
        "conditions": [asdict(c) for c in study.conditions],
        "chunk": study.chunk,
    }
    plain: dict[str, Any] = json.loads(json.dumps(document))
    return plain


def write_manifest(folder: Path, study: Study, command: Sequence[str]) -> None:
    """Write the manifest; `DataError` where the folder cannot be written."""
    document = {
        **describe(study),
        "command": list(command),
        "versions": {name: version(name) for name in _PACKAGES},
    }
    write_text_atomic(folder / FILE, json.dumps(document, indent=2) + "\n")


def read_manifest(folder: Path) -> dict[str, Any]:
    """Read a manifest; raises `DataError` for a folder that has none, or a broken one."""
    path = folder / FILE
    try:
        document = json.loads(path.read_text(encoding="utf-8"))
    except OSError:
        raise DataError(f"{folder}: no study, there is no {FILE}; name a study's folder") from None
    except ValueError as error:
        raise DataError(f"{path}: broken, {error}; begin the study again in another folder") from None
    if not isinstance(document, dict) or document.get("format") != FORMAT:
        raise DataError(f"{path}: no manifest of format {FORMAT}; use the version that wrote it")
    return document


def read_study(folder: Path) -> Study:
    """The study of a folder."""
    document = read_manifest(folder)
    try:
        subject = document["subject"]
        made = {**subject, "silicon": SiliconChoice(**subject["silicon"])}
        lists = {k: tuple(v) for k, v in made.items() if isinstance(v, list)}
        return Study(
            Subject(**{**made, **lists}),
            Plan(**document["plan"]),
            tuple(Condition(**c) for c in document["conditions"]),
            int(document["chunk"]),
        )
    except (KeyError, TypeError) as error:
        raise DataError(f"{folder / FILE}: broken, {error}; begin the study again elsewhere") from None


def check_same(folder: Path, study: Study) -> None:
    """Raise `ParameterError` naming what differs between a folder's study and this one.

    More dies of a plan that can be extended are no difference.
    """
    old, new = read_manifest(folder), describe(study)
    if study.plan.extensible and new["plan"]["count"] >= old["plan"]["count"]:
        new["plan"]["count"] = old["plan"]["count"]
    for name, before, now in _differences(old, new):
        raise ParameterError(f"--resume: {folder} has {name} {before}, asked for {now}; begin another study")


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
