"""The folder of a mission: `mission.json`, which says what it is, a study for each way, and the page.

A mission can be run in parts, on machines that know nothing of each other: each part runs every n-th chunk of
each way into a folder of its own. `merge` puts these together, and what comes out has the bytes of one run.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any, Literal

import msgspec

from circuits.errors import DataError, ParameterError
from system.files.document import folder_bytes, from_json
from system.files.writing import write_text_atomic
from system.study.folder import StudyFiles, keep_samples, open_folder
from system.study.manifest import check_same, describe, read_manifest, study_key
from system.study.mission.found import Found, found_of
from system.study.mission.mission import Asked, Mission, Way, mission_of
from system.study.mission.running import Part
from system.study.table import Table, join

FILE, REPORT = "mission.json", "report.html"
_REMEDY = "begin the mission again in another folder"


class _Document(msgspec.Struct, forbid_unknown_fields=True):
    """What a mission's folder says of it.

    format : version of the document.
    asked : what was asked for.
    part : which part of it was run here.
    command : words of the command that asked for it, without what changes no run.
    """

    format: Literal[1]
    asked: Asked
    part: Part
    command: tuple[str, ...]


def begin(folder: Path, mission: Mission, part: Part, command: Sequence[str], *, resume: bool) -> None:
    """Begin a mission's folder, or go on with it.

    Raises
    ------
    ParameterError
        The folder has a mission and `resume` is not given, or none and it is, or another.
    DataError
        It cannot be written.
    """
    _check_parts(mission, part)
    path = folder / FILE
    if path.exists() and not resume:
        raise ParameterError(f"output: {folder} has a mission; add `resume` to go on, or name another")
    if resume and not path.exists():
        raise ParameterError(f"resume: {folder} has no mission to go on with; leave it out")
    if resume:
        _check_same("resume", folder, _read(folder), (mission, part))
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise DataError(f"{folder}: cannot be made, {error.strerror}; name another folder") from None
    _write(folder, mission, part, command)


def merge(folders: Sequence[Path], output: Path) -> tuple[Mission, tuple[str, ...], tuple[Found, ...]]:
    """Put the parts of a mission together; give it, the words of its command, and what was found.

    Raises
    ------
    ParameterError
        A part is missing, there twice, not finished, of another mission, or made with other versions.
    DataError
        A folder has no mission, or a file is broken.
    """
    if (output / FILE).exists():
        raise ParameterError(f"output: {output} has a mission; name another folder")
    parts = [(folder, _read(folder)) for folder in folders]
    if not parts:
        raise ParameterError("merge: no folder, must be those of all parts of a mission")
    _check_numbers(parts)
    asked, command = parts[0][1].asked, parts[0][1].command
    mission = mission_of(asked)
    for folder, document in parts:
        _check_same("merge", folder, document, (mission, document.part))
        _check_versions(folder, mission)
    by_number = {document.part.number: folder for folder, document in parts}
    sources = [by_number[k] for k in sorted(by_number)]
    tables = [_samples_of(way, sources) for way in mission.ways]
    begin(output, mission, Part(), command, resume=False)
    for way, each in zip(mission.ways, tables, strict=True):
        with open_folder(output / way.name, way.study, resume=False, command=command) as files:
            for dies, table in zip(way.study.chunks(), each, strict=True):
                files.keep(dies, table)
            keep_samples(files, join(each))
    found = [found_of(mission, way, join(each)) for way, each in zip(mission.ways, tables, strict=True)]
    return mission, command, tuple(found)


def _samples_of(way: Way, sources: Sequence[Path]) -> list[Table]:
    """Samples of each chunk of a way, from the part that has it."""
    key = study_key(describe(way.study))
    tables = []
    for k, dies in enumerate(way.study.chunks()):
        folder = sources[k % len(sources)] / way.name
        table = StudyFiles(folder, way.study, key, ()).find(dies)
        if table is None:
            raise ParameterError(
                f"merge: {folder} has no samples of dies {dies.start} to {dies.stop - 1}, its part is not"
                " finished; go on with it by `resume`"
            )
        tables.append(table)
    return tables


def _check_parts(mission: Mission, part: Part) -> None:
    chunks = len(mission.ways[0].study.chunks())
    if not 1 <= part.number <= part.of or part.of > chunks:
        raise ParameterError(
            f"shard: {part.number}/{part.of}, must be 1/n to n/n with n at most {chunks}, the chunks of"
            f" {mission.asked.chunk} dies; take fewer, or a smaller `chunk`"
        )
    if part.of > 1 and mission.asked.until is not None:
        raise ParameterError("shard: with `until`, whose end depends on all dies before; leave one out")


def _check_numbers(parts: Sequence[tuple[Path, _Document]]) -> None:
    """Refuse parts of which one is missing, or there twice."""
    of = parts[0][1].part.of
    seen: dict[int, Path] = {}
    for folder, document in parts:
        part = document.part
        if part.of != of:
            raise ParameterError(
                f"merge: {folder} is {part.number}/{part.of}, the first is of {of}; name parts of one mission"
            )
        if part.number in seen:
            raise ParameterError(
                f"merge: {part.number}/{of} is in {seen[part.number]} and in {folder}, must be there once"
            )
        seen[part.number] = folder
    missing = [str(k) for k in range(1, of + 1) if k not in seen]
    if missing:
        raise ParameterError(f"merge: {', '.join(missing)} of {of} missing; name its folder too")


def _check_versions(folder: Path, mission: Mission) -> None:
    """Refuse a part that was made with other versions than are installed here."""
    for way in mission.ways:
        if not (folder / way.name).is_dir():
            raise ParameterError(
                f"merge: {folder} has no {way.name}, its part is not finished; go on with it"
            )
        theirs, ours = read_manifest(folder / way.name), describe(way.study)
        for name, version in ours["versions"].items():
            if theirs["versions"].get(name) != version:
                raise ParameterError(
                    f"merge: {folder} was run with {name} {theirs['versions'].get(name)}, here is {version};"
                    " run it again, or merge with its versions"
                )
        if theirs["circuit"] != ours["circuit"]:
            raise ParameterError(
                f"merge: {folder} was run with other circuits or models ({theirs['circuit']}, here"
                f" {ours['circuit']}); run it again, or merge with its version"
            )
        check_same(folder / way.name, way.study, ours, "merge", "run it again, or merge with what it was run")


def _check_same(what: str, folder: Path, document: _Document, asked: tuple[Mission, Part]) -> None:
    """Refuse a folder of another mission; more dies are none. What is refused is the first word."""
    mission, part = asked
    old, new = (_plain(asked) for asked in (document.asked, mission.asked))
    old["part"], new["part"] = (f"{p.number}/{p.of}" for p in (document.part, part))
    if new["dies"] >= old["dies"] and part.of == 1:
        old["dies"] = new["dies"]
    for name, now in new.items():
        if old[name] != now:
            raise ParameterError(
                f"{what}: {folder} has {name} {old[name]}, must be {now}; name a folder of the same mission"
            )


def _plain(asked: Asked) -> dict[str, Any]:
    found: dict[str, Any] = json.loads(json.dumps(msgspec.to_builtins(asked)))
    return found


def _write(folder: Path, mission: Mission, part: Part, command: Sequence[str]) -> None:
    document = {"format": 1, "asked": _plain(mission.asked), "part": asdict(part), "command": list(command)}
    write_text_atomic(folder / FILE, json.dumps(document, indent=2) + "\n")


def _read(folder: Path) -> _Document:
    data = folder_bytes(folder, FILE, "mission", _REMEDY)
    return from_json(data, _Document, f"{folder / FILE}: broken", _REMEDY)
