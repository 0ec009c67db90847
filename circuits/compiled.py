"""Compilation of hot functions with numba, at their first call.

A kernel is what stands for such a function until then: neither numba nor what is kept of its code is loaded
before, so that what computes nothing waits for neither. Machine code is kept on disk
(`circuits.machine_code.cache`), stamped with the contents of every file whose code ends up in it, found by
following what each module has imported, and with the constants of those modules.
"""

from __future__ import annotations

import hashlib
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import cache, cached_property, lru_cache, update_wrapper
from operator import attrgetter
from pathlib import Path
from types import FunctionType, ModuleType
from typing import Any, TypeVar, cast, final

import numpy as np

from circuits.catalogue import loaded
from circuits.machine_code.packages import note_kernel

F = TypeVar("F", bound=Callable[..., Any])

_WAITING: list[Callable[[], object]] = []  # who waits for the first kernel

_MAKERS = tuple(Path(__file__).with_name(name) for name in ("machine_code", "vectors"))
_CONSTANTS = (bool, int, float, complex, str, tuple, np.generic, np.ndarray)


def compiled(**options: Any) -> Callable[[F], F]:
    """Decorator that compiles a function on its first call; `options` are those of numba's `njit`.

    Reference counting (numba's `_nrt`) is off unless it is asked for: small functions are about three times
    faster without it, but may not allocate arrays.
    """

    def decorate(function: F) -> F:
        keywords = {"nogil": True, "error_model": "numpy", "_nrt": False, **options}
        return cast("F", Kernel(cast("FunctionType", function), keywords))

    return decorate


def instructions(
    function: Callable[..., Any], alone: Callable[..., Any] | str | None = None
) -> Callable[..., Any]:
    """Decorator of a function that writes instructions itself, as numba's intrinsics do.

    What is made is for kernels to call, with the arguments after the typing context; Python cannot. alone:
    what it is of numbers, where a kernel is worked out for one run (`circuits.programs.specialised`): a
    function that is worked out with it, or the name under which the program calls it.
    """
    return cast("Callable[..., Any]", Instructions(cast("FunctionType", function), alone))


@contextmanager
def before_first_kernel(call: Callable[[], object]) -> Iterator[None]:
    """Inside, `call` is called before a kernel is made, once; at once where numba is there already."""
    _WAITING.append(call)
    if "numba" in sys.modules:
        _tell()
    try:
        yield
    finally:
        if call in _WAITING:
            _WAITING.remove(call)


@final
class Kernel:
    """A function that numba compiles when it is called first, and apart from that where kernels call it.

    Code that Python calls takes apart and checks what it is given, which is as long as many a kernel.
    """

    def __init__(self, function: FunctionType, options: Mapping[str, Any]) -> None:
        self.py_func = function
        self._options = options
        note_kernel(function.__module__)
        update_wrapper(self, function)

    # what is called is the dispatcher: a function in between would take as long as the call of a small kernel
    __call__: Any = property(attrgetter("dispatcher"))

    def __reduce__(self) -> str:
        """Pickle it by its name, as functions are."""
        return self.py_func.__qualname__

    @cached_property
    def dispatcher(self) -> Any:
        """What numba makes of it for Python."""
        return self._made("circuits.machine_code.cache:called_from_python")

    @cached_property
    def called(self) -> Any:
        """What numba makes of it for other kernels."""
        return self._made("circuits.machine_code.cache:called_by_kernels")

    @property
    def _numba_type_(self) -> Any:
        """What numba asks of a name in another kernel."""
        return self.called._numba_type_

    def _made(self, place: str) -> Any:
        function = self.py_func

        def stamp() -> bytes:
            return source_stamp(function.__module__, function.__code__.co_filename)

        _tell()
        return loaded(place)(function, self._options, stamp)


@final
class Instructions:
    """A function that writes instructions, which kernels alone can call."""

    def __init__(self, function: FunctionType, alone: Callable[..., Any] | str | None) -> None:
        self.py_func, self.alone = function, alone

    @cached_property
    def _made(self) -> tuple[Any, Any]:
        """What numba makes of it, and that one's type."""
        return cast("tuple[Any, Any]", loaded("circuits.machine_code.cache:intrinsic_of")(self.py_func))

    @property
    def _numba_type_(self) -> Any:
        """What numba asks of a name in a kernel."""
        return self._made[1]


@lru_cache(maxsize=1024)
def source_stamp(module: str, file: str) -> bytes:
    """Hash of a module's file, of all files whose code it can call, and of the constants of those modules.

    How kernels are made is in it too.
    """
    digest = hashlib.sha256(_makers())
    for path, names in sorted(_followed(module, file).items()):
        digest.update(Path(path).name.encode() + b"\0" + Path(path).read_bytes())
        for name, value in sorted(names.items()):
            if isinstance(value, _CONSTANTS) and not name.startswith("__"):
                shown = value.tobytes() if isinstance(value, np.ndarray) else repr(value).encode()
                digest.update(name.encode() + b"\0" + shown + b"\0")
    return digest.digest()


@cache
def _makers() -> bytes:
    """Contents of what makes machine code of kernels."""
    files = (path for folder in _MAKERS for path in sorted(folder.glob("*.py")))
    return b"\0".join(path.read_bytes() for path in files)


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
    """Functions behind what numba compiles or puts into others, by name or as `module.name`."""
    for value in names.values():
        for each in vars(value).values() if isinstance(value, ModuleType) else (value,):
            if isinstance(each, Kernel | Instructions):
                yield each.py_func


def _tell() -> None:
    while _WAITING:
        _WAITING.pop()()
