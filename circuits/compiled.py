"""Compilation of hot functions with numba, and a cache of their machine code on disk.

numba itself keeps a cached function for as long as the file that it stands in does not change. But machine
code also holds the functions that it calls in other files, and the constants of their modules. So here the
cached code is stamped with the contents of every file whose code ends up in it, found by following what each
module has imported, and with the constants of those modules.

Nothing in the cache's folder can break a run. What cannot be read, or is not what was written, is compiled
again; where nothing can be written, nothing is kept. Machine code is accepted only with its digest, since a
flipped bit in it would be run.

Processes that need the same kernel at the same time compile it once: one of them does, and the others wait
and load the result. Two functions that call each other could wait for each other for ever; kernels do not.
"""

from __future__ import annotations

import fcntl
import hashlib
import os
import pickle
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from functools import lru_cache
from pathlib import Path
from types import FunctionType, ModuleType
from typing import Any, TypeVar, cast, final

import numba as nb
import numpy as np
from numba.core.caching import FunctionCache, IndexDataCacheFile, NullCache
from numba.core.dispatcher import Dispatcher
from numba.core.extending import _Intrinsic

from circuits.seal import sealed, unsealed

F = TypeVar("F", bound=Callable[..., Any])

_CONSTANTS = (bool, int, float, complex, str, tuple, np.generic, np.ndarray)


def compiled(**options: Any) -> Callable[[F], F]:
    """Decorator that compiles a function on its first call; `options` are those of numba's `njit`.

    Whatever the function calls must be imported into its module before it, as imports at the top are.
    Reference counting (numba's `_nrt`) is off unless it is asked for: small functions are about three times
    faster without it, but may not allocate arrays.
    """

    def decorate(function: F) -> F:
        keywords = {"nogil": True, "error_model": "numpy", "_nrt": False, **options}
        dispatcher: Any = nb.njit(**keywords)(function)
        if not os.environ.get("NUMBA_DISABLE_JIT"):
            stamp = source_stamp(function.__module__, function.__code__.co_filename)
            _keep_kernels(dispatcher, stamp)
        return cast("F", dispatcher)

    return decorate


@lru_cache(maxsize=1024)
def source_stamp(module: str, file: str) -> bytes:
    """Hash of a module's file, of all files whose code it can call, and of the constants of those modules."""
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


def _keep_kernels(dispatcher: Any, stamp: bytes) -> None:
    """Keep what numba compiles of a function whose code, with all that it calls, has the stamp."""
    try:
        cache = _KernelCache(dispatcher.py_func)  # type: ignore[no-untyped-call]
    except RuntimeError:  # no folder may be written
        dispatcher._cache = NullCache()  # noqa: SLF001 - no other way
        return
    cache.begin(stamp)
    dispatcher._cache = cache  # noqa: SLF001 - no other way
    compiles = dispatcher.compile

    def compile_once(signature: Any) -> Any:
        depth = cache.lock.depth
        try:
            return compiles(signature)
        finally:
            cache.lock.release(depth)

    dispatcher.compile = compile_once


@final
class _Lock:
    """What one process at a time holds while it compiles a function; the system frees it if the process dies.

    Taken again by the process that has it, it is held deeper. Where no file can be locked nobody waits.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._held: list[int | None] = []

    @property
    def depth(self) -> int:
        """How often it is held."""
        return len(self._held)

    def take(self) -> None:
        """Wait until no other process has it."""
        self._held.append(None)
        if self.depth > 1:
            return
        with suppress(OSError):
            self._path.parent.mkdir(parents=True, exist_ok=True)
            self._held[-1] = file = os.open(self._path, os.O_RDWR | os.O_CREAT, 0o666)
            fcntl.flock(file, fcntl.LOCK_EX)

    def release(self, depth: int) -> None:
        """Hold it no deeper than `depth`."""
        while self.depth > depth:
            file = self._held.pop()
            if file is not None:
                os.close(file)


@final
class _File(IndexDataCacheFile):
    """Data with their digest."""

    def _save_data(self, name: str, data: Any) -> None:
        text = self._dump(data)  # type: ignore[no-untyped-call]
        with self._open_for_write(self._data_path(name)) as file:  # type: ignore[no-untyped-call]
            file.write(sealed(text))

    def _load_data(self, name: str) -> Any:
        found = Path(self._data_path(name)).read_bytes()  # type: ignore[no-untyped-call]
        return pickle.loads(unsealed(found))  # noqa: S301 - numba's own form, in the user's own cache

    def discard(self) -> None:
        """Forget what is there."""
        with suppress(OSError):
            Path(self._index_path).unlink(missing_ok=True)


@final
class _KernelCache(FunctionCache):
    """A cache that compiles again where it fails."""

    def begin(self, stamp: bytes) -> None:
        """Take the stamp for the cached function's own file."""
        make: Any = _File
        self._cache_file: Any = make(self._cache_path, self._impl.filename_base, stamp)
        self.lock = _Lock(Path(self._cache_path) / f"{self._impl.filename_base}.lock")

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Machine code of a signature, None where there is none to be believed: then the lock is held."""
        found = self._believed(sig, target_context)
        if found is None:
            self.lock.take()
            found = self._believed(sig, target_context)  # another process may have compiled it meanwhile
        return found

    def _believed(self, sig: Any, target_context: Any) -> Any:
        try:
            return super().load_overload(sig, target_context)  # type: ignore[no-untyped-call]
        except Exception:  # noqa: BLE001 - contents that are none raise anything
            self._cache_file.discard()
            return None

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep machine code, where that is possible."""
        with suppress(Exception):  # a full or read-only disk, or an index that cannot be replaced
            super().save_overload(sig, data)  # type: ignore[no-untyped-call]
