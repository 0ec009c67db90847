"""What holds for every experiment that is a campaign, tried with a small one of it."""

from __future__ import annotations

import json
import pickle
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path
from threading import Event
from typing import Any

import pytest

from system.experiment import Report
from system.study.campaign import Execution, Workers
from system.study.campaign_file import CutLine

Run = Callable[[Execution], Report]


@contextmanager
def two_others() -> Iterator[Workers]:
    """Two workers that take and give what can travel between processes."""

    def work(sent: bytes) -> bytes:
        make, key = pickle.loads(sent)
        return pickle.dumps(make(key))

    with ThreadPoolExecutor(2) as executor:

        def submit(one: Callable[[Any], Any], key: Any) -> Future[Any]:
            found = executor.submit(work, pickle.dumps((one, key)))
            return executor.submit(lambda: pickle.loads(found.result()))

        yield Workers(submit, 4, Event())


def told(report: Report) -> str:
    """Rows and notes of a report, every bit of them."""
    return json.dumps([[row.row() for row in report.rows], report.notes])


def goes_on(few: Run, more: Run, folder: Path) -> Report:
    """Assert what a campaign promises, and give the report of `more`.

    A run that was killed goes on, a file of fewer runs is lengthened, and other workers make the same file,
    all with the same report to the bit. `few` and `more` run the experiment with fewer and more runs.
    """
    whole, killed, shared = (folder / f"{name}.jsonl" for name in ("whole", "killed", "shared"))
    report = more(Execution(whole))
    few(Execution(killed))
    lines = killed.read_bytes()
    assert 1 < lines.count(b"\n") < whole.read_bytes().count(b"\n")
    killed.write_bytes(lines[:-5])  # while its last line was written
    with pytest.warns(CutLine):
        again = more(Execution(killed, resume=True))
    assert told(again) == told(report)
    assert sorted(killed.read_bytes().splitlines()) == sorted(whole.read_bytes().splitlines())
    assert told(more(Execution(shared, workers=two_others))) == told(report)
    assert shared.read_bytes() == whole.read_bytes()
    kept = whole.read_bytes()
    assert told(more(Execution(whole, resume=True))) == told(report)
    assert whole.read_bytes() == kept
    return report
