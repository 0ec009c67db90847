"""Workers of a campaign on a Dask cluster, whose processes are on other machines or on this one.

The chunks of a study are runs of a campaign too. A run whose process dies is made again by another process.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from typing import Any

import dask
from distributed import Client, KilledWorker, LocalCluster

from circuits.errors import ParameterError, SolverError
from system.files.writing import temporary_folder
from system.notice import warn_in_a_line
from system.study.campaign import AHEAD, MOST_WORKERS, Key, Result, Workers
from system.study.waiting import Work, interrupts

RETRIES = 3  # of a run whose worker died
NO_PAGES: dict[str, list[str]] = {
    f"distributed.{server}.http.routes": [] for server in ("scheduler", "worker")
}
TIMEOUT = "10s"  # of a scheduler that does not answer


@contextmanager
def on_cluster(address: str | None, workers: int | None = None) -> Iterator[Workers]:
    """Give workers that make runs on a Dask cluster.

    Parameters
    ----------
    address
        Address of the cluster's scheduler, as `tcp://host:8786`; None for a cluster of processes that is
        started here and ends with the campaign.
    workers
        Number of processes of that local cluster, one a core unless given.

    Raises
    ------
    ParameterError
        No scheduler answers at the address, the cluster has no workers, or their number is not from 1 to
        `MOST_WORKERS`.
    SolverError
        A process was killed each time at one run, as where memory is too small for it.
    """
    with interrupts() as asked, _clients(address, workers) as (client, count):

        def submit(one: Callable[[Key], Result], key: Key) -> Work[Result]:
            run: Work[Result] = client.submit(one, key, pure=False, retries=RETRIES)
            return run

        yield Workers(submit, AHEAD * count, asked)


@contextmanager
def _clients(address: str | None, workers: int | None) -> Iterator[tuple[Any, int]]:
    """A client of a cluster, and the number of its workers."""
    if workers is not None and not 1 <= workers <= MOST_WORKERS:
        raise ParameterError(f"workers: {workers}, must be at least 1 and at most {MOST_WORKERS}")
    with _local(workers) if address is None else nullcontext(address) as cluster, _client(cluster) as client:
        count = len(client.scheduler_info()["workers"])
        if count == 0:
            raise ParameterError(f"scheduler: {address} has no workers; start some (dask worker {address})")
        if address is None:  # they write on this command's stderr
            client.run(warn_in_a_line)
        try:
            yield client, count
        except KilledWorker:
            raise SolverError(
                "workers: a process was killed each time at one piece of work; if that needs more memory,"
                " take fewer workers or smaller chunks"
            ) from None


@contextmanager
def _local(workers: int | None) -> Iterator[Any]:
    """Processes here, with a folder for what they put aside that goes with them, and no page for browsers."""
    with (
        temporary_folder() as scratch,
        dask.config.set({**NO_PAGES, "temporary-directory": str(scratch)}),
        LocalCluster(
            n_workers=workers, threads_per_worker=1, processes=True, silence_logs=50,
            dashboard_address=None, scheduler_kwargs={"dashboard_address": "127.0.0.1:0"},
        ) as cluster,
    ):  # fmt: skip
        yield cluster


def _client(cluster: Any) -> Any:
    try:
        return Client(cluster, timeout=TIMEOUT, set_as_default=False)
    except (OSError, ValueError) as error:
        reason = " ".join(str(error).split())[:100]
        raise ParameterError(f"scheduler: {cluster}, no answer ({reason}); start it first") from None
