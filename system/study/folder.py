"""The folder of a study holds its manifest, a file for each finished chunk, and the final table.

Only one process at a time writes into the folder. A chunk is read back only if it belongs to this study and
is as it was written. When a study goes on, what a killed process left half-written is removed first. The
report of a finished study (`system.study.report`) goes to the same folder.
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
from system.study.source import keep_source
from system.study.table import Table, join, read_table, write_table
from system.study.target import open_target

CHUNKS, SAMPLES, REPORT = "chunks", "samples.nc", "report.html"


@final
class StudyFiles:
    """A study's folder while this process writes it: a `system.study.campaign.Store` of its chunks.

    folder, study : the folder, and the study that it holds.
    key : the study's key (`system.study.manifest.study_key`), which every table in the folder carries.
    units : SI units of the metrics, in their order.
    read : how many chunks were taken from the folder.
    redone : for each chunk that is there but was not taken, the reason.
    """

    def __init__(self, folder: Path, study: Study, key: str, units: tuple[str, ...]) -> None:
        """Nothing is read or written yet."""
        self.folder, self.study, self.key, self.units = folder, study, key, units
        self.read = 0
        self.redone: list[str] = []

    def find(self, dies: range) -> Table | None:
        """Give the samples of a chunk from its file, or None where there is no file that can be taken."""
        table, note = self._known(dies)
        if table is not None:
            self.read += 1
        elif note:
            self.redone.append(note)
        return table

    def keep(self, dies: range, table: Table) -> None:
        """Write a finished chunk to its file; raises `DataError` where that cannot be written."""
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
        keep_source(folder, study.subject.target)
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
    """Write the table of all samples to the folder; raises `DataError` where it cannot be written."""
    write_table(files.folder / SAMPLES, table, files.units, files.key)


def study_table(folder: Path | str) -> Table:
    """Read the samples of the study in `folder`: its final table, or all chunks that it has so far.

    The final table of a study that was lengthened since, and has not ended, has fewer than the chunks have.
    Raises `DataError` where there are no samples, or a file cannot be read or belongs to another study.
    """
    folder = Path(folder)
    manifest = read_manifest(folder)
    key, whole = study_key(manifest), manifest["plan"]["count"] * len(manifest["conditions"])
    final = read_table(folder / SAMPLES, key) if (folder / SAMPLES).exists() else None
    if final is not None and len(final) >= whole:
        return final
    chunks = sorted((folder / CHUNKS).glob("[0-9]*.nc"))
    if final is None and not chunks:
        raise DataError(f"{folder}: no samples yet; run the study first")
    if final is not None and not chunks:
        return final
    found = join([read_table(path, key) for path in chunks])
    return found if final is None or len(found) > len(final) else final


def _file(files: StudyFiles, dies: range) -> Path:
    return files.folder / CHUNKS / f"{dies.start:012d}-{files.study.chunk}.nc"
