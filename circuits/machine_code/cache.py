"""What numba makes of a kernel, and a cache of its machine code on disk.

numba itself keeps a cached function for as long as the file that it stands in does not change. But machine
code also holds the functions that it calls in other files, and the constants of their modules. So here the
cached code has the stamp of `circuits.compiled`, which is of the contents of all of them.

Code that Python calls is looked for among what came with the package first (`SHIPPED`), where nothing is
written unless `NOCTULE_SHIP_KERNELS` is set: then all code that a run takes is put there, for a wheel.

Nothing in the cache's folder can break a run. What cannot be read, or is not what was written, is compiled
again; where nothing can be written, nothing is kept. Machine code is accepted only with its digest, since a
flipped bit in it would be run.

Processes that need the same kernel at the same time compile it once: one of them does, and the others wait
and load the result. Two functions that call each other could wait for each other for ever; kernels do not.
"""

from __future__ import annotations

import fcntl
import gc
import os
import pickle
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, cast, final

import llvmlite  # type: ignore[import-untyped]
import numba as nb
from numba.core.caching import CompileResultCacheImpl, FunctionCache, IndexDataCacheFile, _CacheLocator
from numba.core.registry import cpu_target
from numba.extending import intrinsic

import circuits.machine_code.structure
import circuits.machine_code.target  # noqa: F401 - chooses the processor
from circuits.machine_code import linked, machine
from circuits.machine_code.linked import LinkedCompiler
from circuits.seal import sealed, unsealed

SHIPPED = Path(__file__).with_name("shipped")
"""Machine code that came with the package, a folder a module."""

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
    dispatcher._cache = cache = _KernelCache(dispatcher.py_func)  # noqa: SLF001 - no other way
    cache.begin(stamp(), suffix)
    compiles = dispatcher.compile

    def compile_once(signature: Any) -> Any:
        depth = cache.lock.depth
        try:
            with _uncollected():
                return compiles(signature)
        finally:
            cache.lock.release(depth)

    dispatcher.compile = compile_once
    return dispatcher


@contextmanager
def _uncollected() -> Iterator[None]:
    """Have Python look for no garbage inside: what numba compiles with is much and lives long."""
    collects = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if collects:
            gc.enable()


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
class _ShippedFile(_File):
    """Data that came with the package, which stay as they are unless they are being made."""

    def save(self, key: Any, data: Any) -> None:
        """Put data there, where a package is being made."""
        Path(self._cache_path).mkdir(parents=True, exist_ok=True)
        super().save(key, data)

    def discard(self) -> None:
        """Nothing."""


@final
class _Nowhere(_CacheLocator):
    """Where code is kept if no folder can be written."""

    def __init__(self, line: int) -> None:
        self._line = line

    def get_cache_path(self) -> str:
        """What can have no files in it."""
        return os.devnull

    def get_source_stamp(self) -> None:
        """Nothing, since the cache has a stamp of its own."""

    def get_disambiguator(self) -> str:
        """What numba names files of code by."""
        return str(self._line)

    @classmethod
    def from_function(cls, py_func: Any, py_file: str) -> _Nowhere:  # noqa: ARG003 - as numba calls it
        """The place of a function's code."""
        return cls(py_func.__code__.co_firstlineno)


@final
class _Kept(CompileResultCacheImpl):
    """Where code is kept, and in what form."""

    def __init__(self, function: Any) -> None:
        try:
            super().__init__(function)
        except RuntimeError:  # no folder may be written
            nowhere: Any = _Nowhere
            self._locator_classes = [nowhere]
            super().__init__(function)


@final
class _KernelCache(FunctionCache):
    """A cache that compiles again where it fails."""

    _impl_class = _Kept

    def begin(self, stamp: bytes, suffix: str) -> None:
        """Take the stamp for the cached function's own file, and a suffix for the names of its files."""
        own, shipped, impl = cast("Any", _File), cast("Any", _ShippedFile), cast("Any", self._impl)
        name = f"{impl.filename_base}{suffix}"
        self._cache_file: Any = own(self._cache_path, name, stamp)
        self._shipped = []
        if suffix:
            impl.rebuild = linked.rebuilt
        else:
            impl.reduce, impl.rebuild = machine.reduced, machine.rebuilt
            self._shipped = [shipped(str(SHIPPED / self._py_func.__module__), name, stamp)]
        self.lock = _Lock(Path(self._cache_path) / f"{name}.lock")

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Machine code of a signature, None where there is none to be believed: then the lock is held."""
        found = self._believed(sig, target_context)
        if found is None:
            self.lock.take()
            found = self._believed(sig, target_context)  # another process may have compiled it meanwhile
        return found

    def _believed(self, sig: Any, target_context: Any) -> Any:
        key = self._index_key(sig, target_context.codegen())
        for file in (*self._shipped, self._cache_file):
            try:
                kept = file.load(key)
                found = None if kept is None else self._impl.rebuild(target_context, kept)
            except Exception:  # noqa: BLE001 - contents that are none raise anything
                file.discard()
                continue
            if found is not None:
                self._ship(key)
                return found
        return None

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep machine code, where that is possible."""
        with suppress(Exception):  # a full or read-only disk, or an index that cannot be replaced
            super().save_overload(sig, data)
            self._ship(self._index_key(sig, data.codegen))

    def _ship(self, key: Any) -> None:
        """Put what is kept among what comes with the package, where that is being made."""
        if os.environ.get("NOCTULE_SHIP_KERNELS"):
            for file in self._shipped:
                if file.load(key) is None:
                    file.save(key, self._cache_file.load(key))

    def _index_key(self, sig: Any, codegen: Any) -> Any:
        """What tells numba's code for one signature and processor from others, with the version of LLVM."""
        return *super()._index_key(sig, codegen), llvmlite.__version__
