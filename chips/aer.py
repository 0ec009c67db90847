"""An address-event (AER) bus of limited bandwidth, and files of address-events.

Events go through an arbiter, one at a time, each for the `service` time; those that wait stand in a FIFO.
An event that finds the FIFO full is dropped and counted. Of events at the same instant the arbiter takes
the lowest address first (fixed priority, ours); so the answer does not depend on the order in which they
are handed in.

    delivered_k = max(t_k, delivered_{k-1}) + service

An event file is little-endian: the 8 bytes `NOCTAER1`, then for each event int64 time in microseconds and
int64 address; times do not decrease. In memory times are float64 seconds.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from circuits.arrays import F64, I64, Bools
from circuits.compiled import compiled
from circuits.errors import DataError, ParameterError

MAGIC = b"NOCTAER1"
_ROW = np.dtype("<i8")
_MICROSECOND = 1e-6  # s
_LATEST = 2**63 * _MICROSECOND  # s

ALIKE = 1024  # events at one instant, of more of which a general sort is faster; ours
IDLE = np.empty(0)  # nothing is on a bus
_compiled = compiled()


@dataclass(frozen=True, slots=True)
class Bus:
    """An arbitrated bus.

    `service` is the time that it takes to transfer an event, s, 0 for an ideal bus; `depth` is how many
    events may wait or be transferred at once.

    Raises `ParameterError` for a service time that is negative or not finite, and for a depth below 1.
    """

    service: float = 100e-9  # ours: 10 million events/s
    depth: int = 512  # ours

    def __post_init__(self) -> None:
        if not (self.service >= 0.0 and np.isfinite(self.service)):
            raise ParameterError(f"bus.service: {self.service:g} s, must be >= 0; 0 is an ideal bus")
        if self.depth < 1:
            raise ParameterError(f"bus.depth: {self.depth}, must be >= 1; the event being sent needs a place")


@dataclass(frozen=True, slots=True)
class Events:
    """Address-events in the order of their times.

    `times` are in s and do not decrease, float64[m]; `addresses` are int64[m]; `dropped` counts the events
    that a bus lost before these.
    """

    times: F64
    addresses: I64
    dropped: int = 0


def send(bus: Bus, times: F64, addresses: I64) -> Events:
    """Send events over an idle bus and return those that it delivers, at the end of their transfers.

    `bus` is the bus; `times`, when the events are sent, s, float64[m] in any order; `addresses`, int64[m].
    """
    return send_on(bus, IDLE, times, addresses)[0]


def send_on(bus: Bus, line: F64, times: F64, addresses: I64) -> tuple[Events, F64]:
    """Send events over a bus that may be busy; return those of them that it delivers, and its new `line`.

    line: when the events that were sent before will be delivered, s, float64[k] rising, `IDLE` for none;
    times, addresses: as in `send`.
    """
    times = np.ascontiguousarray(times, dtype=np.float64)
    addresses = np.ascontiguousarray(addresses, dtype=np.int64)
    if not _in_order(times, addresses):
        order = _order(times, addresses)
        times, addresses = times[order], addresses[order]
    delivered, kept = np.empty(line.size + times.size), np.empty(times.size, dtype=np.bool_)
    delivered[: line.size] = line
    count = _serve(times, bus.service, bus.depth, delivered, kept, line.size)
    found = delivered[line.size : count]
    found = found if found.size == delivered.size else found.copy()  # keeps no more memory than it needs
    last = float(times[-1]) if times.size else -np.inf
    left = delivered[:count][np.searchsorted(delivered[:count], last, side="right") :].copy()
    got = addresses if found.size == times.size else addresses[kept]
    return Events(found, got, times.size - found.size), left


@_compiled
def _in_order(times: F64, addresses: I64) -> bool:
    """Whether events are by time, and by address where times are alike."""
    for k in range(1, times.size):
        if not times[k - 1] < times[k] and not (
            times[k - 1] == times[k] and addresses[k - 1] <= addresses[k]
        ):
            return False
    return True


def _order(times: F64, addresses: I64) -> NDArray[np.intp]:
    """By time, and by address where times are alike; events come almost in order, which a merge sort uses."""
    order = np.argsort(times, kind="stable")
    return order if _break_ties(order, times, addresses) else np.lexsort((addresses, times))


@_compiled
def _break_ties(order: NDArray[np.intp], times: F64, addresses: I64) -> bool:
    """Order by address, in place, what `order` has at one instant; False where that is too much at once."""
    begin = 0
    for k in range(1, order.size):
        if times[order[k]] != times[order[begin]]:
            begin = k
        elif k - begin >= ALIKE:
            return False
        at, mine = k, order[k]
        while at > begin and addresses[order[at - 1]] > addresses[mine]:
            order[at] = order[at - 1]
            at -= 1
        order[at] = mine
    return True


@_compiled
def _serve(times: F64, service: float, depth: int, delivered: F64, kept: Bools, count: int) -> int:
    """Fill `delivered` (float64, of those kept, in order) and `kept` (bool); returns how many there are.

    count: of `delivered`, how many stand in it at its beginning.
    """
    gone, last = 0, delivered[count - 1] if count > 0 else -np.inf
    for k in range(times.size):
        while gone < count and delivered[gone] <= times[k]:
            gone += 1
        kept[k] = count - gone < depth
        if kept[k]:
            last = max(times[k], last) + service
            delivered[count] = last
            count += 1
    return count


def write_events(path: Path, events: Events) -> None:
    """Write `events` to a file at `path`, with times rounded to whole microseconds.

    Raises `ParameterError` for a time that is not finite or does not fit in an int64.
    """
    if events.times.size and not np.abs(events.times).max() < _LATEST:
        raise ParameterError(
            f"events.times: {events.times[np.abs(events.times).argmax()]:g} s, must be within"
            f" +-{_LATEST:.3g} s; write finite times"
        )
    path.write_bytes(MAGIC + rows_of(events.times, events.addresses).tobytes())


def rows_of(times: F64, addresses: I64) -> I64:
    """Return events as the rows of files and streams: microseconds and addresses, int64[m, 2].

    times : s, float64[m]; addresses : int64[m].
    """
    rows = np.empty((times.size, 2), dtype=_ROW)
    rows[:, 0], rows[:, 1] = np.rint(times / _MICROSECOND), addresses
    return rows


def read_events(path: Path) -> Events:
    """Read the event file at `path`; raises `DataError` for one that is none, or whose times decrease."""
    content = path.read_bytes()
    if not content.startswith(MAGIC):
        raise DataError(
            f"{path}: no event file, must begin with {MAGIC.decode()}; write it with write_events"
        )
    body = content[len(MAGIC) :]
    whole, rest = divmod(len(body), 2 * _ROW.itemsize)
    if rest:
        raise DataError(f"{path}: {rest} bytes after event {whole}, must be 16 an event; copy the whole file")
    rows = np.frombuffer(body, dtype=_ROW).reshape(-1, 2)
    back = np.flatnonzero(np.diff(rows[:, 0]) < 0)
    if back.size:
        k = int(back[0]) + 1
        raise DataError(
            f"{path}: event {k} at {rows[k, 0]} us, must not be before the last, at {rows[k - 1, 0]} us;"
            " sort the events"
        )
    return Events(rows[:, 0].astype(np.float64) * _MICROSECOND, rows[:, 1].astype(np.int64))
