"""What a person at a terminal is told of kernels that a command compiles.

Kernels are compiled by the first run that needs them, and kept (`circuits.compiled`). Until they are there a
command seems to stand still.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, final

from numba.core.event import Listener, install_listener

from system.notice import say


@contextmanager
def compilation_told() -> Iterator[None]:
    """Inside, the first kernel that is compiled is told in a line; in the end, how long all of them took."""
    told = _Teller()
    try:
        with install_listener("numba:compile", told):
            yield
    finally:
        told.end()


@final
class _Teller(Listener):
    """A listener of numba's compilations; what a function calls is compiled while it is."""

    def __init__(self) -> None:
        self._depth, self._count = 0, 0
        self._began, self._seconds = 0.0, 0.0

    def on_start(self, event: Any) -> None:
        """Begin a function."""
        if not self._count:
            package = ".".join(event.data["dispatcher"].py_func.__module__.split(".")[:2])
            say(f"compiling the kernels of {package} and what they need, once: half a minute or more")
        if not self._depth:
            self._began = time.perf_counter()
        self._depth += 1
        self._count += 1

    def on_end(self, event: Any) -> None:
        """End a function."""
        self._depth -= 1
        if not self._depth:
            self._seconds += time.perf_counter() - self._began

    def end(self) -> None:
        """Tell how long it took, if anything was compiled."""
        if self._count:
            say(f"compiled {self._count} kernels in {self._seconds:.0f} s; later runs find them")
