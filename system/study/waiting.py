"""Waiting for work that was handed out to threads of this process, or to processes of another library.

Whoever waits asks the work to tell when it is done, and meanwhile looks every fifth of a second whether the
user has asked for an interruption. Ctrl-C is therefore never lost in the wait of another library.
"""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any, Protocol, TypeVar

T_co = TypeVar("T_co", covariant=True)
T = TypeVar("T")

_PATIENCE = 0.2  # s, after which a wait looks whether it was interrupted; ours


class Work(Protocol[T_co]):
    """What was handed out: a future of `concurrent.futures`, of distributed, or what works like one."""

    def add_done_callback(self, fn: Callable[[Any], object], /) -> object:
        """Call `fn` with the work when it is done, from any thread; at once where it is."""

    def result(self) -> T_co:
        """What came of it, once it is done; raises what it raised."""


def outcome_of(work: Work[T], asked: threading.Event) -> T:
    """Wait for work and give its result; raises `KeyboardInterrupt` soon after `asked` was set."""
    done = threading.Event()
    work.add_done_callback(lambda _: done.set())
    while not done.wait(_PATIENCE):
        check(asked)
    found = work.result()
    check(asked)
    return found


def check(asked: threading.Event) -> None:
    """Raise `KeyboardInterrupt` where an interruption was asked for."""
    if asked.is_set():
        raise KeyboardInterrupt


@contextmanager
def interrupts() -> Iterator[threading.Event]:
    """Inside, Ctrl-C sets an event, so that it is not lost where a library takes the exception for its own.

    A second one interrupts at once. Other threads than the main one cannot catch signals, and get none.
    """
    asked = threading.Event()
    if threading.current_thread() is not threading.main_thread():
        yield asked
        return

    def note(number: int, frame: FrameType | None) -> None:
        signal.signal(signal.SIGINT, before)
        asked.set()

    before = signal.getsignal(signal.SIGINT)
    signal.signal(signal.SIGINT, note)
    try:
        yield asked
    finally:
        signal.signal(signal.SIGINT, before)
