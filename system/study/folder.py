"""A study's folder: its manifest, a file a finished chunk, the table of all samples, the report.

One process at a time writes a study's folder. A chunk is taken from it only where it is of this study and as
it was written; what a killed process left half-made is removed when the study goes on.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import final

from circuits.errors import DataError, ParameterError
from system.files.claim import claimed
from system.files.writing import sweep_hidden
from system.study.manifest import FILE, Study, check_same, describe, read_manifest, study_key, write_manifest
from system.study.table import Table, join, read_table, write_table
from system.study.target import open_target

CHUNKS, SAMPLES, REPORT = "chunks", "samples.nc", "report.html"


@final
class StudyFiles:
    """A folder that this process writes: the store of a study's chunks (`system.study.campaign.Store`).

    key: of its study, units: of its metrics; read: how many chunks were taken from it, redone: why others
    that are there were not.
    """

    def __init__(self, folder: Path, study: Study, key: str, units: tuple[str, ...]) -> None:
        """Nothing is read or written yet."""
        self.folder, self.study, self.key, self.units = folder, study, key, units
        self.read = 0
        self.redone: list[str] = []

    def find(self, dies: range) -> Table | None:
        """A finished chunk, None where its file is not taken."""
        table, note = self._known(dies)
        if table is not None:
            self.read += 1
        elif note:
            self.redone.append(note)
        return table

    def keep(self, dies: range, table: Table) -> None:
        """Keep a finished chunk; `DataError` where it cannot be written."""
        write_table(_file(self, dies), table, self.units, self.key)

    def _known(self, dies: range) -> tuple[Table | None, str | None]:
        """A finished chunk and None, or None and why its file is not taken: empty where there is none."""
        path = _file(self, dies)
        if not path.exists():
            return None, ""
        try:
            table = read_table(path, self.key)
        except DataError as error:
            return None, str(error)
        expected = [(d, c.corner, c.temperature_c, c.trial) for d in dies for c in self.study.conditions]
        found = list(
            zip(
                table.die.tolist(),
                table.corner,
                table.temperature_c.tolist(),
                table.trial.tolist(),
                strict=True,
            )
        )
        if found == expected:
            return table, None
        if found == expected[: len(found)]:
            return None, ""  # the last chunk of a study that is now longer
        return None, f"{path}: has other samples than its name says; measured again"


@contextmanager
def open_folder(
    folder: Path, study: Study, *, resume: bool, command: Sequence[str] = ()
) -> Iterator[StudyFiles]:
    """Begin a study's folder, or go on with it; inside, no other process writes it.

    Raises
    ------
    ParameterError
        The folder has another study or files of none, or this one and `resume` is not given, or none and it
        is, or another process is at work in it.
    DataError
        The folder cannot be written.
    """
    if resume and not (folder / FILE).exists():
        raise ParameterError(f"resume: {folder} has no study to go on with; leave it out")
    document = describe(study, command)
    _make(folder)
    with ExitStack() as stack:
        try:
            stack.enter_context(claimed(folder.resolve()))
        except BlockingIOError:
            raise ParameterError(
                f"output: {folder}, another process is at work in it; wait for its end, or name another"
            ) from None
        if not (folder / FILE).exists():
            _check_free(folder)
        elif resume:
            check_same(folder, study, document)
        else:
            raise ParameterError(f"output: {folder} has a study; add `resume` to go on, or name another")
        for each in (folder, folder / CHUNKS):
            sweep_hidden(each)
        write_manifest(folder, document)
        _make(folder / CHUNKS)
        units = tuple(q.unit for q in open_target(study.subject).quantities)
        yield StudyFiles(folder, study, study_key(document), units)


def _make(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise DataError(f"{folder}: cannot be made, {error.strerror}; name another folder") from None


def _check_free(folder: Path) -> None:
    """Raise `ParameterError` for a folder whose files a new study would replace."""
    taken = [name for name in (FILE, SAMPLES, REPORT) if os.path.lexists(folder / name)]
    chunks = folder / CHUNKS
    if chunks.is_symlink() or (chunks.exists() and (not chunks.is_dir() or any(chunks.iterdir()))):
        taken.append(CHUNKS)
    if taken:
        raise ParameterError(f"output: {folder} has {taken[0]} of no study; name another folder")


def keep_samples(files: StudyFiles, table: Table) -> None:
    """Keep the table of all samples; `DataError` where it cannot be written."""
    write_table(files.folder / SAMPLES, table, files.units, files.key)


def study_table(folder: Path) -> Table:
    """Samples of a study: the final table, or of an unfinished one the chunks that are there.

    Raises `DataError` where there are none, or one cannot be read or is not of this study.
    """
    key = study_key(read_manifest(folder))
    if (folder / SAMPLES).exists():
        return read_table(folder / SAMPLES, key)
    chunks = sorted((folder / CHUNKS).glob("[0-9]*.nc"))
    if not chunks:
        raise DataError(f"{folder}: no samples yet; run the study first")
    return join([read_table(path, key) for path in chunks])


def _file(files: StudyFiles, dies: range) -> Path:
    return files.folder / CHUNKS / f"{dies.start:012d}-{files.study.chunk}.nc"
