"""Claims: an open file or folder that belongs to one process while that lives, and to nobody after its end.

A claim is the kernel's own lock, so that however a process ends nobody waits for it. Two claims of one
process exclude each other too.
"""

from __future__ import annotations

import fcntl
import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

_OPEN = os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC  # no link is followed and no pipe waited for


def take(descriptor: int) -> bool:
    """Claim what is open, until it is closed; False where its disk knows no locks.

    Raises `BlockingIOError` where somebody else has it.
    """
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise
    except OSError:
        return False
    return True


@contextmanager
def claimed(path: Path) -> Iterator[bool]:
    """Inside, a file or folder is claimed, or False where its disk knows no locks.

    Raises `BlockingIOError` where somebody else has it, and what opening it raises.
    """
    descriptor = os.open(path, _OPEN | (os.O_RDONLY if path.is_dir() else os.O_RDWR))
    try:
        yield take(descriptor)
    finally:
        os.close(descriptor)


@contextmanager
def alone(path: Path) -> Iterator[None]:
    """Wait until no thread of any process is inside with the same path, whose file is there meanwhile.

    Where no file can be made or locked nobody waits.
    """
    descriptor = None
    with suppress(OSError):
        path.parent.mkdir(parents=True, exist_ok=True)
        descriptor = _waited(path)
    try:
        yield
    finally:
        if descriptor is not None:
            with suppress(OSError):
                path.unlink()
            os.close(descriptor)


def _waited(path: Path) -> int:
    """The claimed file of the path, opened; one that its owner has removed meanwhile claims nothing."""
    while True:
        descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW | os.O_CLOEXEC, 0o666)
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX)
            with suppress(FileNotFoundError):
                if os.path.samestat(os.fstat(descriptor), path.stat()):
                    return descriptor
        except BaseException:
            os.close(descriptor)
            raise
        os.close(descriptor)


def sweep(folder: Path, pattern: str) -> None:
    """Remove files and folders that nobody claims any more; `pattern`: of names that only claimed ones have.

    What is of somebody who lives, or on a disk without locks, stays.
    """
    for path in folder.glob(pattern):
        with suppress(OSError), claimed(path) as is_mine:  # a BlockingIOError is an OSError too
            if is_mine and path.is_dir():
                shutil.rmtree(path)
            elif is_mine:
                path.unlink()
