"""What numba makes of a kernel, and a cache of its machine code on disk.

numba itself keeps a cached function for as long as the file that it stands in does not change. But machine
code also holds the functions that it calls in other files, and the constants of their modules. So here the
cached code has the stamp of `circuits.compiled`, which is of the contents of all of them.

Nothing in the cache's folder can break a run. What cannot be read, or is not what was written, is compiled
again; where nothing can be written, nothing is kept. Machine code is accepted only with its digest, since a
flipped bit in it would be run.

Processes that need the same kernel at the same time compile it once: one of them does, and the others wait
and load the result. Two functions that call each other could wait for each other for ever; kernels do not.
"""

from __future__ import annotations

import fcntl
import os
import pickle
from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, final

import numba as nb
from numba.core.caching import FunctionCache, IndexDataCacheFile, NullCache
from numba.core.registry import cpu_target
from numba.extending import intrinsic

import circuits.machine_code.structure  # noqa: F401 - registers the types
from circuits.machine_code import linked, machine
from circuits.machine_code.linked import LinkedCompiler
from circuits.seal import sealed, unsealed

# Of code that only other kernels call: Python cannot call it, and numba need not make how it would.
_CALLED_BY_KERNELS = {
    "no_cpython_wrapper": True, "no_cfunc_wrapper": True, "pipeline_class": LinkedCompiler,
}  # fmt: skip


def called_from_python(function: Any, options: Mapping[str, Any], stamp: Callable[[], bytes]) -> Any:
    """Make numba's dispatcher of a function that Python calls, whose code is kept with its stamp."""
    return _kept(_made(function, {**options, "no_cfunc_wrapper": True}), stamp, "")


def called_by_kernels(function: Any, options: Mapping[str, Any], stamp: Callable[[], bytes]) -> Any:
    """Make numba's dispatcher of a function that other kernels call; Python must not call it."""
    return _kept(_made(function, {**options, **_CALLED_BY_KERNELS}), stamp, "-called")


def _made(function: Any, options: dict[str, Any]) -> Any:
    return nb.njit(**options)(function)


def intrinsic_of(function: Any) -> tuple[Any, Any]:
    """Make numba's intrinsic of a function that writes instructions itself; returned with its type."""
    made, context = intrinsic(function), cpu_target.typing_context
    context.refresh()  # what was registered since
    return made, context.resolve_value_type(made)


def _kept(dispatcher: Any, stamp: Callable[[], bytes], suffix: str) -> Any:
    """Keep what numba compiles of a function whose code, with all that it calls, has the stamp."""
    if os.environ.get("NUMBA_DISABLE_JIT"):
        return dispatcher
    try:
        cache = _KernelCache(dispatcher.py_func)
    except RuntimeError:  # no folder may be written
        dispatcher._cache = NullCache()  # noqa: SLF001 - no other way
        return dispatcher
    cache.begin(stamp(), suffix)
    dispatcher._cache = cache  # noqa: SLF001 - no other way
    compiles = dispatcher.compile

    def compile_once(signature: Any) -> Any:
        depth = cache.lock.depth
        try:
            return compiles(signature)
        finally:
            cache.lock.release(depth)

    dispatcher.compile = compile_once
    return dispatcher


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
        text = self._dump(data)
        with self._open_for_write(self._data_path(name)) as file:
            file.write(sealed(text))

    def _load_data(self, name: str) -> Any:
        found = Path(self._data_path(name)).read_bytes()
        return pickle.loads(unsealed(found))  # noqa: S301 - numba's own form, in the user's own cache

    def discard(self) -> None:
        """Forget what is there."""
        with suppress(OSError):
            Path(self._index_path).unlink(missing_ok=True)


@final
class _KernelCache(FunctionCache):
    """A cache that compiles again where it fails."""

    def begin(self, stamp: bytes, suffix: str) -> None:
        """Take the stamp for the cached function's own file, and a suffix for the names of its files."""
        make: Any = _File
        name = f"{self._impl.filename_base}{suffix}"
        self._cache_file: Any = make(self._cache_path, name, stamp)
        if suffix:
            self._impl.rebuild = linked.rebuilt
        else:
            self._impl.reduce, self._impl.rebuild = machine.reduced, machine.rebuilt
        self.lock = _Lock(Path(self._cache_path) / f"{name}.lock")

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Machine code of a signature, None where there is none to be believed: then the lock is held."""
        found = self._believed(sig, target_context)
        if found is None:
            self.lock.take()
            found = self._believed(sig, target_context)  # another process may have compiled it meanwhile
        return found

    def _believed(self, sig: Any, target_context: Any) -> Any:
        try:
            return self._load_overload(sig, target_context)
        except Exception:  # noqa: BLE001 - contents that are none raise anything
            self._cache_file.discard()
            return None

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep machine code, where that is possible."""
        with suppress(Exception):  # a full or read-only disk, or an index that cannot be replaced
            super().save_overload(sig, data)
