"""The file of spikes that a run of a system leaves where it is asked for."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, TypeVar

import numpy as np

from circuits.arrays import F64, I64
from system.spikes.file import SUFFIXES, check_spikes, write_spikes
from system.system import Output, Progress

T = TypeVar("T")
HELP = f"Write {{}} into a {', '.join(SUFFIXES[:-1])} or {SUFFIXES[-1]}."


def spikes_output(
    what: str,
    found: Callable[[T], tuple[Mapping[str, F64], float]],
    no_silicon: Callable[[Any], str] | None = None,
) -> Output[T]:
    """Give the output that writes a system's spikes.

    Parameters
    ----------
    what
        Whose spikes they are, for the help of the option.
    found
        Gives the spike trains (s, by the name of their address) of a trace, and the end of the run, s.
    no_silicon
        What puts the chip whose spikes they are into the loop of a scenario, "" where it is in it; it always
        is unless given.
    """
    return spikes_made_again(what, lambda trace, _: found(trace), no_silicon)


def spikes_made_again(
    what: str,
    found: Callable[[T, Progress], tuple[Mapping[str, F64], float]],
    no_silicon: Callable[[Any], str] | None = None,
) -> Output[T]:
    """Give the output that writes spikes for which a run is made again, since it keeps none by itself.

    found : as of `spikes_output`, and is told the share that is done; the others are its parameters.
    """

    def refuse(scenario: Any) -> str:
        remedy = "" if no_silicon is None else no_silicon(scenario)
        return f"only those of a chip are recorded; {remedy}, or leave it out" if remedy else ""

    return Output(
        help=HELP.format(what),
        check=check_spikes,
        write=lambda path, trace, progress: _write(path, *found(trace, progress)),
        refuse=refuse,
        trains=lambda trace: found(trace, lambda _: None)[0],
    )


def _write(path: str, trains: Mapping[str, F64], stop: float) -> None:
    """Write spikes; those that a run's last step brought after its end move that."""
    write_spikes(path, trains, max([stop, *(float(times.max()) for times in trains.values() if times.size)]))


def trains_of(name: str, count: int, times: F64, addresses: I64) -> dict[str, F64]:
    """Spike trains of the addresses `name[0]` to `name[count - 1]`, s.

    times, addresses : float64[n], s, and int64[n].
    """
    order = np.argsort(addresses, kind="stable")
    edges = np.searchsorted(addresses[order], np.arange(count + 1))
    return {f"{name}[{k}]": times[order][edges[k] : edges[k + 1]] for k in range(count)}
