"""A study on a Dask cluster of processes: the same samples, whatever happens to a worker."""

from __future__ import annotations

import os
import signal
import threading
import time

import numpy as np
import pytest
from distributed import LocalCluster

from circuits.errors import ParameterError
from system.study.cluster import on_cluster
from system.study.engine import on_threads, run_study
from tests.system.study.test_engine import same, study


def test_a_scheduler_that_does_not_answer_is_told_in_a_line(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("system.study.cluster.TIMEOUT", "1s")
    with (
        pytest.raises(ParameterError, match=r"--scheduler: tcp://127\.0\.0\.1:9, no answer"),
        on_cluster("tcp://127.0.0.1:9"),
    ):
        pass
    with pytest.raises(ParameterError, match="--workers: 0, must be at least 1"), on_cluster(None, 0):
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
        with on_cluster(cluster.scheduler_address) as (submit, ahead):
            thread.start()
            found = run_study(wanted, submit=submit, ahead=ahead).table
            thread.join()
    with on_threads(1) as (submit, ahead):
        expected = run_study(study(count=8, chunk=2), submit=submit, ahead=ahead).table
    assert same(found, expected)
    assert np.isfinite(found.values).sum() == 6
