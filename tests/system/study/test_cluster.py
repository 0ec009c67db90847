"""A study on a Dask cluster of processes: the same samples, whatever happens to a worker."""

from __future__ import annotations

import contextlib
import http.client
import os
import signal
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import dask
import numpy as np
import psutil
import pytest
from distributed import LocalCluster

from circuits.errors import ParameterError, SolverError
from system.study.cluster import on_cluster
from system.study.engine import on_threads, run_study
from tests.system.study.test_engine import same, study


def test_a_scheduler_that_does_not_answer_is_told_in_a_line(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("system.study.cluster.TIMEOUT", "1s")
    with (
        pytest.raises(ParameterError, match=r"scheduler: tcp://127\.0\.0\.1:9, no answer"),
        on_cluster("tcp://127.0.0.1:9"),
    ):
        pass
    with pytest.raises(ParameterError, match="workers: 0, must be at least 1"), on_cluster(None, 0):
        pass


def test_a_killed_worker_loses_nothing() -> None:
    wanted = study(metric="slow_sum", count=8, chunk=2)
    with LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None, silence_logs=50
    ) as cluster:
        victims = [worker.pid for worker in cluster.workers.values()]

        def kill() -> None:
            time.sleep(1.0)
            os.kill(victims[0], signal.SIGKILL)

        thread = threading.Thread(target=kill)
        with on_cluster(cluster.scheduler_address) as workers:
            thread.start()
            found = run_study(wanted, workers=workers).table
            thread.join()
    with on_threads(1) as workers:
        expected = run_study(study(count=8, chunk=2), workers=workers).table
    assert same(found, expected)
    assert np.isfinite(found.values).sum() == 6


@pytest.fixture
def temporary(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """The system's folder of temporary files, for this process and its workers."""
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.setattr("tempfile.tempdir", None)
    yield tmp_path
    monkeypatch.undo()


def test_a_cluster_leaves_nothing_and_serves_no_page(temporary: Path) -> None:
    (temporary / f".noctule-{os.getuid()}-of-a-killed-run").mkdir()
    wanted = study(count=4, chunk=2)
    with on_cluster(None, 1) as workers:
        found = list(temporary.iterdir())
        assert len(found) == 1, found
        (scratch,) = found
        assert scratch.name.startswith(".noctule-")
        run_study(wanted, workers=workers)
        assert [p for p in listened() if answers(p)] == []
        assert list(temporary.iterdir()) == [scratch]
    assert list(temporary.iterdir()) == []


def listened() -> list[int]:
    """Ports that this process and its children listen at."""
    family = [psutil.Process(), *psutil.Process().children(recursive=True)]
    return [c.laddr.port for p in family for c in p.net_connections("tcp") if c.status == psutil.CONN_LISTEN]


def answers(port: int) -> bool:
    """Whether a browser gets a page there."""
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=2.0)
    pages = ("/", "/status", "/health", "/info/main/workers.html", "/json/counts.json", "/metrics")
    found = []
    for page in pages:
        with contextlib.suppress(OSError, http.client.HTTPException):
            connection.request("GET", page)
            response = connection.getresponse()
            response.read()
            found.append(response.status < 400)
        connection.close()
    return any(found)


def test_a_worker_that_is_killed_each_time_is_told_in_a_line() -> None:
    wanted = study(metric="deadly", count=2, chunk=2)
    with (
        dask.config.set({"distributed.scheduler.allowed-failures": 0}),  # a worker takes seconds to start
        pytest.raises(SolverError, match=r"workers: a process was killed each time"),
        on_cluster(None, 1) as workers,
    ):
        run_study(wanted, workers=workers)
