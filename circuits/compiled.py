"""Compilation of the hot functions with numba, kept on disk from run to run.

numba compares a cached function with the file that it stands in; but machine code also holds what was called,
from other files, and the numbers that these and it found in their modules. So the cache's stamp here is the
contents of every file whose code ends up in a kernel, followed from what each module has imported, and the
constants of those modules.

Nothing that stands in the cache's folder can break it. What cannot be read, or is not what was written, is
compiled again; where nothing can be written nothing is kept. Machine code is taken only with its digest,
since a flipped bit of it would be run.

Processes that miss the same kernel at the same time compile it once: one does, the others wait and load what
it has kept. To wait for each other two functions would have to call each other, which kernels do not.
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
            _keep_kernels(dispatcher, stamp)
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
