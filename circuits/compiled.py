"""Compilation of the hot functions with numba, kept on disk from run to run.

numba compares a cached function with the file that it stands in; but machine code also holds what was called,
from other files, and the numbers that these and it found in their modules. So the cache's stamp here is the
contents of every file whose code ends up in a kernel, followed from what each module has imported, and the
constants of those modules.
"""

from __future__ import annotations

import hashlib
import os
import sys
from collections.abc import Callable, Iterator, Mapping
from functools import lru_cache
from pathlib import Path
from types import FunctionType, ModuleType
from typing import Any, TypeVar, cast

import numba as nb
import numpy as np
from numba.core.dispatcher import Dispatcher
from numba.core.extending import _Intrinsic

from circuits.kernel_cache import keep_kernels

F = TypeVar("F", bound=Callable[..., Any])

_CONSTANTS = (bool, int, float, complex, str, tuple, np.generic, np.ndarray)


def compiled(**options: Any) -> Callable[[F], F]:
    """Compile a function on its first call; `options` are numba's.

    What it calls must be imported into its module before it, which is where imports stand.

    Without reference counting (numba's `_nrt=False`) the small functions are about three times faster, but
    may not allocate arrays: it is off unless `_nrt=True` is given.
    """

    def decorate(function: F) -> F:
        keywords = {"nogil": True, "error_model": "numpy", "_nrt": False, **options}
        dispatcher: Any = nb.njit(**keywords)(function)
        if not os.environ.get("NUMBA_DISABLE_JIT"):
            stamp = source_stamp(function.__module__, function.__code__.co_filename)
            keep_kernels(dispatcher, stamp)
        return cast("F", dispatcher)

    return decorate


@lru_cache(maxsize=1024)
def source_stamp(module: str, file: str) -> bytes:
    """Hash of `file`, where `module` stands, of all files with code that it can call, and their constants."""
    digest = hashlib.sha256()
    for path, names in sorted(_followed(module, file).items()):
        digest.update(Path(path).name.encode() + b"\0" + Path(path).read_bytes())
        for name, value in sorted(names.items()):
            if isinstance(value, _CONSTANTS) and not name.startswith("__"):
                shown = value.tobytes() if isinstance(value, np.ndarray) else repr(value).encode()
                digest.update(name.encode() + b"\0" + shown + b"\0")
    return digest.digest()


def _followed(module: str, file: str) -> dict[str, Mapping[str, Any]]:
    """Names of the module and of those whose functions it calls, by file."""
    found: dict[str, Mapping[str, Any]] = {}
    waiting = [(file, vars(sys.modules[module]))]
    while waiting:
        path, names = waiting.pop()
        if path not in found:
            found[path] = names
            waiting += [(f.__code__.co_filename, f.__globals__) for f in _callable_from(names)]
    return found


def _callable_from(names: Mapping[str, Any]) -> Iterator[FunctionType]:
    """Python functions behind what numba compiled or puts into others, by name or as `module.name`."""
    for value in names.values():
        for each in vars(value).values() if isinstance(value, ModuleType) else (value,):
            if isinstance(each, Dispatcher):
                yield each.py_func
            elif isinstance(each, _Intrinsic):
                yield each._defn  # noqa: SLF001 - no other way
