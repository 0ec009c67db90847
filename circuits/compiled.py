"""Compilation of the hot functions with numba, kept on disk from run to run.

numba compares a cached function with the file that it stands in; but machine code also holds what was called,
from other files. So the cache's stamp here is the contents of every file whose code ends up in a kernel.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any, TypeVar, cast

import numba as nb

_HERE = Path(__file__).parent
_SOURCES = (
    "compiled.py",
    "die.py",
    "devices/*.py",
    "lowering/factor.py",
    "lowering/kernel.py",
    "noise.py",
    "solver/integrate.py",
    "solver/newton.py",
    "solver/noisy.py",
    "solver/operating_point.py",
    "solver/power.py",
)

F = TypeVar("F", bound=Callable[..., Any])


def compiled(*, callees: Sequence[ModuleType] = (), **options: Any) -> Callable[[F], F]:
    """Compile a function on its first call; `options` are numba's.

    `callees`: modules outside this package, besides its own, whose functions it calls.

    Without reference counting (numba's `_nrt=False`) the small functions are about three times faster, but
    may not allocate arrays: it is off unless `_nrt=True` is given.
    """

    def decorate(function: F) -> F:
        keywords = {"cache": True, "nogil": True, "error_model": "numpy", "_nrt": False, **options}
        dispatcher: Any = nb.njit(**keywords)(function)
        if not os.environ.get("NUMBA_DISABLE_JIT"):
            files = (function.__code__.co_filename, *(str(m.__file__) for m in callees))
            dispatcher._cache._cache_file._source_stamp = source_stamp(files)  # noqa: SLF001 - no other way
        return cast("F", dispatcher)

    return decorate


@cache
def source_stamp(files: tuple[str, ...] = ()) -> bytes:
    """Hash of this package's files whose code is compiled, and of `files`."""
    digest = hashlib.sha256(_own_stamp())
    for path in map(Path, files):
        if path.parent != _HERE and _HERE not in path.parents:
            digest.update(path.name.encode() + b"\0" + path.read_bytes())
    return digest.digest()


@cache
def _own_stamp() -> bytes:
    digest = hashlib.sha256()
    for pattern in _SOURCES:
        for path in sorted(_HERE.glob(pattern)):
            digest.update(path.name.encode() + b"\0" + path.read_bytes())
    return digest.digest()
