"""Clients over UDP. Datagrams have numbers: what did not come is counted, on both sides."""

from __future__ import annotations

import selectors
import socket
from collections.abc import Sequence
from time import monotonic
from typing import Any, final

from circuits.arrays import I64
from circuits.errors import DataError
from system.stream.form import Form, joined
from system.stream.hub import Hub
from system.stream.record import Code
from system.stream.session import Session
from system.stream.tcp import MOST, Tell

AT_ONCE = 256  # datagrams that are read between two looks at the chip; ours
LARGEST = 65_535  # bytes
BUFFER = 2**22  # bytes that the system is asked to keep of a socket; ours
IDLE = 60.0  # s without a datagram after which a client has gone; ours
LINGER = 1.0  # s after the end in which a client may ask for it again; ours
HELLO = -1  # number of the datagram of the `Hello`


@final
class Mail:
    """The way out to one address: datagrams with numbers."""

    def __init__(self, opened: socket.socket, form: Form, address: Any) -> None:
        self.socket, self.form, self.address = opened, form, address
        self.number = 0

    @property
    def full(self) -> bool:
        """There is always room; what the system does not take is dropped."""
        return False

    def put(self, rows: I64, tail: Sequence[tuple[int, int]]) -> int:
        """Send events (int64[m, 2]) and control records; returns how many events were not taken."""
        records, sent = joined(rows, tail), 0
        for datagram in self.form.datagrams(records, self.number):
            count = (len(datagram) - self.form.before) // self.form.record
            sent += count if self.send(datagram) else 0
            self.number = self.form.after(self.number, count)
        return max(len(rows) - sent, 0)

    def send(self, datagram: bytes) -> bool:
        """Return whether the system took a datagram."""
        try:
            self.socket.sendto(datagram, self.address)
        except OSError:  # no room, or nobody there
            return False
        return True


@final
class UdpClients:
    """Clients over UDP.

    hub : what they talk to; form : how; selector : tells what has come; tick : us; tell : takes lines.
    to : address to which spikes go, whoever sends; None where each client gets them.
    """

    def __init__(
        self, hub: Hub, form: Form, selector: selectors.BaseSelector, bound: socket.socket, tick: int,
        to: Any = None,
    ) -> None:  # fmt: skip
        self.hub, self.form, self.selector, self.socket, self.tick = hub, form, selector, bound, tick
        self.tell: Tell = print
        self._to = to
        self._found: dict[Any, Session] = {}
        self._expected: dict[Any, int] = {}
        self._heard: dict[Any, float] = {}
        for option in (socket.SO_RCVBUF, socket.SO_SNDBUF):
            bound.setsockopt(socket.SOL_SOCKET, option, BUFFER)
        selector.register(bound, selectors.EVENT_READ, self._read)
        if to is not None:
            self.hub.join(Session(f"{to[0]}:{to[1]}", form, hub.takes, Mail(bound, form, to)))

    def tend(self) -> None:
        """Let go those who are through, or have sent nothing for long."""
        for address, session in list(self._found.items()):
            if monotonic() - self._heard[address] > (LINGER if session.done else IDLE):
                del self._found[address], self._expected[address], self._heard[address]
                self.hub.part(session)

    def close(self) -> None:
        """Let all go."""
        for session in list(self.hub.sessions):
            self.hub.part(session)
        self.selector.unregister(self.socket)
        self.socket.close()

    def _read(self) -> None:
        for _ in range(AT_ONCE):
            try:
                datagram, address = self.socket.recvfrom(LARGEST)
            except OSError:  # nothing more, or an answer that nobody is there
                return
            try:
                number = self.form.number(datagram)
            except DataError as error:
                self.tell(f"{address[0]}:{address[1]}: a datagram of {error}; not taken")
                continue
            self._take(address, number, datagram[self.form.before :])

    def _take(self, address: Any, number: int, data: bytes) -> None:
        session = self._found.get(address) or self._met(address, number)
        if session is None:
            return
        self._heard[address] = monotonic()
        if number == 0 and not data:
            self._greet(session)
        if session.done:  # the end was lost on the way
            session.finish(self.hub.now, self.hub.lost)
            return
        missed = self.form.missed(self._expected[address], number)
        if missed < 0:
            return  # it was counted as missed when a later one came
        session.counts[Code.MISSED] += missed
        self._expected[address] = self.form.after(number, len(data) // self.form.record)
        self.hub.take(session, session.take(data, self.hub.now))

    def _met(self, address: Any, number: int) -> Session | None:
        """A client that is new; jAER's may have begun to count long ago."""
        name = f"{address[0]}:{address[1]}"
        if len(self._found) >= MOST:
            self.tell(f"{name}: there are {MOST} clients, must be no more; not heard")
            return None
        mail = Mail(self.socket, self.form, address) if self._to is None else None
        session = self._found[address] = Session(name, self.form, self.hub.takes, mail)
        self._expected[address] = 0 if self.form.controls else number
        self.hub.join(session)
        return session

    def _greet(self, session: Session) -> None:
        """Send the server's first words, in a datagram of their own."""
        if self.form.controls and isinstance(session.outlet, Mail):
            session.outlet.send(self.form.numbered(HELLO, self.hub.hello(self.tick).bytes()))
