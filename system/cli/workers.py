"""`--workers` and `--scheduler`: processes that make the runs of a study or of an experiment's campaign."""

from __future__ import annotations

from contextlib import AbstractContextManager

from circuits.catalogue import loaded
from system.study.campaign import Workers


def on_processes(scheduler: str | None, workers: int | None) -> AbstractContextManager[Workers]:
    """Processes of the Dask cluster at the address `scheduler`, or so many here.

    Raises `ParameterError` for a number that is none, and where no scheduler answers.
    """
    # dask takes a second to import, and most campaigns have no need of it
    cluster: AbstractContextManager[Workers] = loaded("system.study.cluster:on_cluster")(scheduler, workers)
    return cluster
