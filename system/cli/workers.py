"""The options `--workers` and `--scheduler`: processes that make the runs of a study or of a campaign."""

from __future__ import annotations

from contextlib import AbstractContextManager

from circuits.catalogue import loaded
from circuits.errors import ParameterError
from system.study.campaign import Workers
from system.study.engine import on_threads


def on_processes(scheduler: str | None, workers: int | None) -> AbstractContextManager[Workers]:
    """Open the processes of the Dask cluster at the address `scheduler`, or else `workers` processes here.

    Raises `ParameterError` for an impossible number of processes, and where no scheduler answers.
    """
    # dask takes a second to import, and most campaigns have no need of it
    cluster: AbstractContextManager[Workers] = loaded("system.study.cluster:on_cluster")(scheduler, workers)
    return cluster


def workers_of(
    threads: int | None, workers: int | None, scheduler: str | None
) -> AbstractContextManager[Workers]:
    """Open threads, all cores unless given, or a Dask cluster where one is asked for.

    Raises `ParameterError` for threads beside a cluster, and as `on_processes` does.
    """
    if scheduler is None and workers is None:
        return on_threads(threads)
    if threads is not None:
        raise ParameterError("--threads: not with --workers or --scheduler; leave one out")
    return on_processes(scheduler, workers)
