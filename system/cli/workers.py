"""The options `--workers` and `--scheduler`: processes that make the runs of a study or of a campaign."""

from __future__ import annotations

from contextlib import AbstractContextManager

from circuits.catalogue import loaded
from system.study.campaign import Workers


def on_processes(scheduler: str | None, workers: int | None) -> AbstractContextManager[Workers]:
    """Open the processes of the Dask cluster at the address `scheduler`, or else `workers` processes here.

    Raises `ParameterError` for an impossible number of processes, and where no scheduler answers.
    """
    # dask takes a second to import, and most campaigns have no need of it
    cluster: AbstractContextManager[Workers] = loaded("system.study.cluster:on_cluster")(scheduler, workers)
    return cluster
