"""The file of the user's that a study is of: its hash, its copy, and whether it may be run again.

The manifest has the file's name and the SHA-256 digest of its contents; what is measured anywhere is checked
against that. The study's folder has a copy. That of code is there to be read and is never run: a replay needs
the file to be named. That of a netlist is data, and stands in for a netlist that is gone or has changed.
"""

from __future__ import annotations

from pathlib import Path

from circuits.errors import DataError, ParameterError
from system.files.writing import write_bytes_atomic
from system.options.code import Code, code_of, hash_of
from system.options.target import bench_of, deck_of, driven, files_of, split_place

COPIES = "source"
_SHOWN = 12  # digits of a hash that an error shows; ours


def digest_of(target: str) -> str:
    """Give the digest of the files that a target names; empty where it names none.

    Raises `DataError` for a file that cannot be read.
    """
    return hash_of(b"".join(map(_contents, paths))) if (paths := files_of(target)) else ""


def check_source(target: str, digest: str) -> None:
    """Raise `ParameterError` where the file that a target names is not the one that was hashed."""
    found = digest_of(target)
    if digest and found != digest:
        raise ParameterError(
            f"{target}: its file has the hash {found[:_SHOWN]}, must be {digest[:_SHOWN]}, the one that was"
            " named; give every worker the same file"
        )


def keep_source(folder: Path, target: str) -> None:
    """Copy the files that a target names into a study's folder, code as a `.txt`; nothing without a file."""
    for path in files_of(target):
        copy = _copy(folder, target, path)
        copy.parent.mkdir(exist_ok=True)
        write_bytes_atomic(copy, _contents(path))


def place_beside(folder: Path, at: str | None, target: str, now: str) -> str | None:
    """Give the place on a chip (`at`) of a study whose target is named by `now`, as it is named now.

    Raises `ParameterError` for a chip that is code of another file than the target's.
    """
    chip, instances = split_place(at or "")
    place, own, named = code_of(chip), code_of(target), code_of(now)
    if place is None:
        return at
    if own is None or named is None or place.path != own.path:
        raise ParameterError(
            f"code: {folder} is of a place at {chip}, code that no file loads; study it again"
        )
    return "/".join([str(Code(named.path, place.name)), *instances])


def named_source(
    folder: Path, target: str, digest: str, code: str | None, *, changed: bool = False
) -> tuple[str, str]:
    """Give the target of a study to measure again, and its file's digest now.

    Parameters
    ----------
    folder
        Folder of the study.
    target, digest
        The target as the study names it, and the digest that its file had.
    code
        The code that may run for it, as `my_circuit.py:follower`; None where the user has named none.
    changed
        Whether that file may have other contents than the study's.

    Raises
    ------
    ParameterError
        The study is of code that was not named, or of another, or whose file has changed; or code was named
        for a study of none.
    """
    own = code_of(target)
    if own is None:
        if code is not None:
            raise ParameterError(f"code: {code}, {folder} is of {target}, which is no code; leave it out")
        return _deck(folder, target, digest), digest
    named = None if code is None else code_of(code)
    if code is None or named is None or named.name != own.name:
        given = "" if code is None else f"{code}, but "
        raise ParameterError(
            f"code: {given}{folder} was measured with {target}, code that no file loads; add `code={target}`"
        )
    now = digest_of(code)
    if now != digest and not changed:
        raise ParameterError(
            f"code: {named.path} has the hash {now[:_SHOWN]}, {folder} is of {digest[:_SHOWN]}; name the file"
            f" as it was, kept in {_copy(folder, target, named.path)}, or add `changed`"
        )
    return code, now


def _deck(folder: Path, target: str, digest: str) -> str:
    """A netlist's text as a target, from the copies where a file itself has gone or changed."""
    found, paths = deck_of(target), files_of(target)
    if found is None or (all(path.is_file() for path in paths) and digest_of(target) == digest):
        return target
    name, testbench = bench_of(found)
    deck = _copy(folder, target, found.path)
    whole = str(Code(deck, name)) if name else str(deck)
    return whole if testbench is None else driven(whole, str(_copy(folder, target, testbench)))


def _copy(folder: Path, target: str, path: Path) -> Path:
    return folder / COPIES / (f"{path.name}.txt" if code_of(target) else path.name)


def _contents(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        raise DataError(f"{path}: {error.strerror}; name the file that was measured") from None
