"""A chip and its clients: whose events it takes, how far its time goes, who is told of its spikes.

In a fast run the client that sends first leads: time goes as far as it has told, and waits where it does not
read what it is sent; events of others are refused and counted, until it has gone. At real pace time goes with
the wall's clock, and all clients' events are taken.
"""

from __future__ import annotations

from time import monotonic
from typing import final

import numpy as np

from chips.aer import rows_of
from chips.live.chip import LiveChip
from circuits.arrays import I64
from system.stream.inlet import ROOM, Takes
from system.stream.mapping import AddressMap
from system.stream.record import Code, Counts, Hello, no_counts
from system.stream.session import Session

SLICE = 50_000  # us that the chip goes on at most between two looks at its clients; ours
LONG, SHORT = 0.05, 0.01  # s that a look should not take, and that it may take longer than; ours
FIRST, FEWEST = 4096, 64  # events of a client that are taken at the first look, and at any; ours
US = 1e-6


@final
class Hub:
    """A chip and its clients.

    chip : the chip; pace : `fast` or `real`; mapped : where events of its clients go; None as they say.
    """

    def __init__(self, chip: LiveChip, pace: str, mapped: AddressMap | None = None) -> None:
        self.chip, self.pace, self.mapped = chip, pace, mapped
        self.sessions: list[Session] = []
        self.now = int(np.ceil(chip.time / US - US))  # us
        self.gone = no_counts()  # of clients that have gone
        self.served = 0  # clients
        self._most = FIRST  # events of a client that are taken between two looks

    @property
    def takes(self) -> Takes:
        """What tells whether addresses can be taken."""
        return self.mapped.takes if self.mapped else self.chip.state.engine.takes

    @property
    def lost(self) -> int:
        """Events that the chip has lost within."""
        return sum(count for name, count in self.chip.lost.items() if name.startswith("lost"))

    def hello(self, tick: int) -> Hello:
        """Return what a client is told first; tick: of the server's clock, us."""
        return Hello(self.chip.path, self.pace, self.now, self.chip.inputs, self.chip.outputs, tick)

    def join(self, session: Session) -> None:
        """Let a client in."""
        self.sessions.append(session)
        self.served += 1

    def part(self, session: Session) -> None:
        """Let a client go; its counts stay."""
        session.inlet.leave()
        session.leads = False
        self.gone.update(session.counts)
        self.sessions.remove(session)

    def take(self, session: Session, rows: I64) -> None:
        """Take records of a client, int64[m, 2]."""
        if self.pace == "fast" and len(rows) and not session.leads:
            leader = next((each for each in self.sessions if each.leads), None)
            if leader is not None:
                session.inlet.refuse(rows, f"{leader.name} leads the time; send after it")
                return
            session.leads = True
            session.inlet.begin(self.now)
        session.inlet.take(rows, self.now)

    def goal(self) -> int:
        """Return the time to which a fast run can go on now, us."""
        leader = next((each for each in self.sessions if each.leads), None)
        if leader is None or (leader.outlet is not None and leader.outlet.full):
            return self.now
        return leader.inlet.limit(min(leader.inlet.last, self.now + SLICE), self._most)

    def go_on(self, until: int) -> None:
        """Let the chip go on to a time, us, and tell its clients."""
        begun = monotonic()
        rows = self._through(until)
        spent = monotonic() - begun
        if spent > LONG:
            self._most = max(self._most // 2, FEWEST)
        elif spent < SHORT:
            self._most = min(self._most * 2, ROOM)
        self.now = until
        lost = self.lost
        for session in self.sessions:
            session.give(rows, until, lost)

    def finish(self) -> None:
        """Send the end to those who asked for it and have all that they wait for."""
        for session in self.sessions:
            if self._is_through(session):
                session.finish(self.now, self.lost)
                session.leads = False

    def counts(self) -> Counts:
        """Return the counts of all clients, gone ones too."""
        total = Counts(self.gone)
        for session in self.sessions:
            total.update(session.counts)
        total[Code.CHIP_LOST] = self.lost
        return total

    def _is_through(self, session: Session) -> bool:
        inlet = session.inlet
        led = self.pace == "real" or session.leads
        return (
            inlet.ended and not session.done and (not led or (self.now >= inlet.last and not inlet.waiting))
        )

    def _through(self, until: int) -> I64:
        """The chip's spikes up to a time, us, with the events of all clients before it."""
        most = ROOM if self.pace == "fast" else self._most  # at real pace the others are taken later
        parts = [rows for each in self.sessions if len(rows := each.inlet.due(until, self.now, most))]
        if self.mapped:
            parts = [self.mapped.sent_on(rows) for rows in parts]
        if parts:
            rows = np.concatenate(parts)
            if len(parts) > 1:
                rows = rows[np.argsort(rows[:, 0], kind="stable")]
            self.chip.send(np.maximum(rows[:, 0] * US, self.chip.time), rows[:, 1])
        spikes = self.chip.advance(until * US - self.chip.time)
        return rows_of(spikes.times, spikes.addresses)
