"""One client of a server: its way in, its way out, and what became of all that it sent."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol, final

import numpy as np

from circuits.arrays import I64
from system.stream.form import Form
from system.stream.inlet import Inlet, Takes
from system.stream.record import Code, no_counts

_EVERY = 100_000  # us of the chip's time between two tellings of counts; ours
_NONE = np.empty((0, 2), dtype=np.int64)


class Outlet(Protocol):
    """The way out of a client."""

    @property
    def full(self) -> bool:
        """Whether nothing more has room."""

    def put(self, rows: I64, tail: Sequence[tuple[int, int]]) -> int:
        """Send events (int64[m, 2]), and control records behind them; returns how many events had no room."""


@final
class Session:
    """One client.

    Parameters
    ----------
    name
        What lines call it.
    form
        Its format.
    takes
        Whether each of some addresses can be taken.
    outlet
        Its way out; None for one to whom nothing is sent.
    """

    def __init__(self, name: str, form: Form, takes: Takes, outlet: Outlet | None) -> None:
        self.name, self.form, self.outlet = name, form, outlet
        self.counts = no_counts()
        self.inlet = Inlet(takes, self.counts)
        self.leads = False  # whether the chip's time goes by it, in a fast run
        self.done = False  # nothing more is to be sent
        self._clock = form.clock()
        self._told: dict[Code, int] = {}
        self._at = 0  # us, when counts were told

    def take(self, data: bytes, now: int) -> I64:
        """Return the records in some bytes, int64[m, 2], by the chip's clock, which is at `now`, us."""
        return self._clock(self.form.rows(data), now)

    def give(self, rows: I64, now: int, lost: int) -> None:
        """Send spikes (int64[m, 2]); now: us, that has been reached; lost: within the chip so far."""
        if self.outlet is None or self.done:
            return
        tail = [(now, int(Code.TIME))]
        if now - self._at >= _EVERY:
            tail += self._news(now, lost)
        self._put(rows, tail)

    def finish(self, now: int, lost: int) -> None:
        """Send all counts and the end, which may be asked for again; now, lost: as of `give`."""
        self._told.clear()
        self._put(_NONE, [*self._news(now, lost), (now, int(Code.END))])
        self.done = True

    def _put(self, rows: I64, tail: list[tuple[int, int]]) -> None:
        if self.outlet is None:
            return
        dropped = self.outlet.put(rows, tail if self.form.controls else [])
        self.counts[Code.DROPPED_OUT] += dropped
        self.counts[Code.SENT] += len(rows) - dropped

    def _news(self, now: int, lost: int) -> list[tuple[int, int]]:
        """Counts that are others than those told last."""
        self._at, self.counts[Code.CHIP_LOST] = now, lost
        news = {code: n for code, n in self.counts.items() if n != self._told.get(code, 0)}
        self._told |= news
        return [(n, int(code)) for code, n in news.items()]
