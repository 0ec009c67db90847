"""Waits end with the work or with Ctrl-C, and with nothing that another library's wait does."""

from __future__ import annotations

import os
import signal
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import nullcontext
from threading import Event, Timer
from typing import Any

import pytest

from system.study.campaign import Campaign, Execution, Workers
from system.study.engine import run_study
from system.study.waiting import interrupts, outcome_of
from tests.system.study.test_engine import run, same, study


class Busy(Future[Any]):
    """As distributed's on a loaded machine: a wait that a deadline cuts short ends in an error of its own."""

    def result(self, timeout: float | None = None) -> Any:
        if timeout is not None and not self.done():
            raise UnboundLocalError("cannot access local variable 'result'")
        return super().result()


def later(function: Any, *arguments: Any) -> Busy:
    found = Busy()
    Timer(0.5, lambda: found.set_result(function(*arguments))).start()
    return found


def test_no_wait_is_cut_short_by_a_deadline() -> None:
    workers = Workers(later, 1, Event())
    campaign = Campaign("ours", lambda number: 2 * number, int, int)
    assert list(Execution(workers=lambda: nullcontext(workers)).results(campaign, [1, 2])) == [2, 4]
    table = run_study(study(4, 2), workers=workers).table
    assert same(table, run(study(4, 2)).table)


def test_what_work_raises_comes_out() -> None:
    with ThreadPoolExecutor(1) as executor, pytest.raises(ZeroDivisionError):
        outcome_of(executor.submit(lambda: 1 / 0), Event())


def test_an_interrupt_ends_a_wait_that_would_not_end() -> None:
    for_ever: Future[None] = Future()
    with interrupts() as asked, pytest.raises(KeyboardInterrupt):
        Timer(0.1, os.kill, (os.getpid(), signal.SIGINT)).start()
        outcome_of(for_ever, asked)
