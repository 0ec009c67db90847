"""Clients over TCP. Nothing is lost on the way: one whose queue is full is not read until there is room."""

from __future__ import annotations

import selectors
import socket
from collections.abc import Callable, Sequence
from time import monotonic
from typing import final

from circuits.arrays import I64
from circuits.errors import CircuitError, DataError
from system.stream.form import Form, joined
from system.stream.hub import Hub
from system.stream.record import Code
from system.stream.session import Session

READ = 2**18  # bytes that are read at once; ours
ROOM_OUT = 2**22  # bytes that wait to be sent to a client; ours
PATIENCE = 10.0  # s after which a client that reads nothing is dropped; ours
MOST = 16  # clients at once; ours
_BOTH = selectors.EVENT_READ | selectors.EVENT_WRITE
Tell = Callable[[str], None]


@final
class Link:
    """A connection: bytes on their way, and whose they are; `waits_since` is in s."""

    def __init__(self, opened: socket.socket, form: Form) -> None:
        self.socket, self.form = opened, form
        self.out = bytearray()
        self.rest = b""  # of a record that has not come as a whole
        self.head = form.head
        self.waits_since = monotonic()
        self.over = False  # nothing more is read

    @property
    def full(self) -> bool:
        """Whether nothing more has room."""
        return len(self.out) >= ROOM_OUT

    def put(self, rows: I64, tail: Sequence[tuple[int, int]]) -> int:
        """Send events (int64[m, 2]) and control records; returns how many events had no room."""
        if not self.out:
            self.waits_since = monotonic()
        room = max(ROOM_OUT - len(self.out), 0) // self.form.record
        dropped = max(len(rows) - room, 0)
        kept = rows[: len(rows) - dropped]
        ends = bool(tail) and tail[-1][1] == Code.END
        if len(kept) or (tail and (room or ends)):
            self.out += self.form.data(joined(kept, tail))
        return dropped

    def flush(self) -> None:
        """Send what can be sent now; raises `OSError` where the client has gone."""
        while self.out:
            try:
                sent = self.socket.send(bytes(self.out[:READ]))
            except BlockingIOError:
                return
            del self.out[:sent]
            self.waits_since = monotonic()

    def read(self) -> bytes | None:
        """Return whole records that have come, None at the end; raises `OSError` as `flush`, and `DataError`.

        `DataError` is for one that does not begin as it must, or ends within a record.
        """
        data = self.socket.recv(READ)
        if not data:
            if self.rest or len(self.head) not in {0, len(self.form.head)}:
                raise DataError(f"{len(self.rest)} bytes behind the last record, must be whole ones")
            return None
        data = self.rest + data
        if self.head:
            k = min(len(self.head), len(data))
            if data[:k] != self.head[:k]:
                raise DataError(f"begins with {data[:8]!r}, must be {self.form.head!r}")
            self.head, data = self.head[k:], data[k:]
        whole = len(data) // self.form.record * self.form.record
        self.rest = data[whole:]
        return data[:whole]


@final
class TcpClients:
    """Clients over TCP; raises `ParameterError` where the place is taken.

    hub : what they talk to; form : how; selector : tells who is ready; tick : us; tell : takes lines.
    """

    def __init__(
        self, hub: Hub, form: Form, selector: selectors.BaseSelector, listener: socket.socket, tick: int
    ) -> None:
        self.hub, self.form, self.selector, self.listener, self.tick = hub, form, selector, listener, tick
        self.tell: Tell = print
        self._links: dict[Session, Link] = {}
        listener.listen(MOST)
        selector.register(listener, selectors.EVENT_READ, self._accept)

    def tend(self) -> None:
        """Send what waits, let go those who are through or do not read, and say whom to listen to."""
        for session, link in list(self._links.items()):
            try:
                link.flush()
            except OSError:
                self._drop(session, "went away")
                continue
            if session.done and not link.out:
                self._drop(session, "")
            elif link.out and monotonic() - link.waits_since > PATIENCE:
                self._drop(session, f"has read nothing for {PATIENCE:g} s; dropped")
            else:
                self._listen(session, link)

    def close(self) -> None:
        """Let all go."""
        for session in list(self._links):
            self._drop(session, "")
        self.selector.unregister(self.listener)
        self.listener.close()

    def _accept(self) -> None:
        try:
            opened, address = self.listener.accept()
        except OSError:
            return  # it went before it was let in
        name = f"{address[0]}:{address[1]}"
        if len(self._links) >= MOST:
            opened.close()
            self.tell(f"{name}: there are {MOST} clients, must be no more; sent away")
            return
        opened.settimeout(0.0)
        opened.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        link = Link(opened, self.form)
        session = Session(name, self.form, self.hub.takes, link)
        if self.form.controls:
            link.out += self.hub.hello(self.tick).bytes()
        self._links[session] = link
        self.hub.join(session)
        self.selector.register(opened, selectors.EVENT_READ, lambda: self._read(session))

    def _read(self, session: Session) -> None:
        link = self._links.get(session)
        if link is None or link.over or session.inlet.full:
            return
        try:
            data = link.read()
        except BlockingIOError:
            return
        except CircuitError as error:
            self._drop(session, str(error))
            return
        except OSError:
            self._drop(session, "went away")
            return
        if data is None:
            link.over = True
            session.inlet.end()
        else:
            self.hub.take(session, session.take(data, self.hub.now))

    def _listen(self, session: Session, link: Link) -> None:
        """Wait for what can be done: room in the queue, and bytes that wait."""
        wanted = 0 if link.over or session.inlet.full else selectors.EVENT_READ
        wanted |= selectors.EVENT_WRITE if link.out else 0
        key = self.selector.get_map().get(link.socket)
        if key is None and wanted:
            self.selector.register(link.socket, wanted, lambda: self._read(session))
        elif key is not None and not wanted:
            self.selector.unregister(link.socket)
        elif key is not None and key.events != wanted:
            self.selector.modify(link.socket, wanted, key.data)

    def _drop(self, session: Session, why: str) -> None:
        link = self._links.pop(session)
        self.hub.part(session)
        if link.socket in self.selector.get_map():
            self.selector.unregister(link.socket)
        link.socket.close()
        if why:
            self.tell(f"{session.name}: {why}")
