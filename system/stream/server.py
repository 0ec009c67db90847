"""A server of address-events: a live chip to which other programs talk as to a real one.

    with EventServer(chip, "127.0.0.1:8990") as server:
        server.run()                                   until `stop`, or Ctrl-C

One thread: it looks at its clients, lets the chip go on, and tells them; all of it array by array. Memory is
bounded: queues have limits (`system.stream.inlet`, `tcp`), and what they do not hold is counted.
"""

from __future__ import annotations

import selectors
import socket
from collections import Counter
from collections.abc import Callable, Mapping
from time import monotonic
from typing import Any, Self, final

from chips.live.chip import LiveChip
from circuits.errors import ParameterError, unknown_name
from system.stream.form import FORMS, Form
from system.stream.hub import Hub
from system.stream.mapping import read_map
from system.stream.record import PACES, named
from system.stream.tcp import TcpClients, Tell
from system.stream.udp import UdpClients
from system.stream.wall import Wall

PORT = 8990  # jAER's for streams
HERE = f"127.0.0.1:{PORT}"
_LONGEST = 0.5  # s that nothing is looked at where nothing comes; ours
_LINES = 10  # of a kind that are said; ours


@final
class EventServer:
    """A live chip at a place of the network.

    Parameters
    ----------
    chip
        The chip.
    at
        Host and port, as 127.0.0.1:8990; port 0 is any that is free.
    udp
        Whether clients talk over UDP, instead of TCP.
    pace
        `fast`, as fast as events come and the chip can, or `real`, by the wall's clock.
    tick
        Time between two looks at the chip at real pace, s.
    form
        Format, `noctule` or `jaer`.
    to
        Host and port to which spikes go over UDP; those who send get them unless given.
    mapped
        Path of a CSV file with columns `from` and `to`: addresses of clients, and those of the chip.

    Raises
    ------
    ParameterError
        A port is in use or none, a tick is not above 0, or `to` comes without UDP.
    UnknownNameError
        There is no such pace or format.
    DataError
        The file of addresses is none.
    """

    def __init__(
        self, chip: LiveChip, at: str = HERE, *, udp: bool = False, pace: str = "fast",
        tick: float = 1e-3, form: str = "noctule", to: str | None = None, mapped: str | None = None,
    ) -> None:  # fmt: skip
        if pace not in PACES:
            raise unknown_name("pace", pace, PACES)
        if form not in FORMS:
            raise unknown_name("format", form, FORMS)
        if not 1e-6 <= tick <= 1.0:
            raise ParameterError(f"tick: {tick:g} s, must be 1e-06 to 1")
        if to is not None and not udp:
            raise ParameterError(f"to: {to}, only UDP sends elsewhere; leave it out, or take UDP")
        takes = chip.state.engine.takes
        self.hub = Hub(chip, pace, None if mapped is None else read_map(mapped, takes))
        self._wall = Wall(round(tick * 1e6)) if pace == "real" else None
        self._selector = selectors.SelectSelector()  # the others round waits up to whole milliseconds
        self._bound = _bound(at, socket.SOCK_DGRAM if udp else socket.SOCK_STREAM)
        self._clients = self._clients_of(
            FORMS[form], None if to is None else _resolved(to, socket.SOCK_DGRAM)
        )
        self._wake, self._woken = socket.socketpair()
        self._woken.settimeout(0.0)
        self._selector.register(self._woken, selectors.EVENT_READ, lambda: self._woken.recv(64))
        self._stopped, self._said = False, Counter[str]()
        self.tell: Tell | None = None

    @property
    def port(self) -> int:
        """Port at which it listens."""
        return int(self._bound.getsockname()[1])

    @property
    def place(self) -> str:
        """Host and port at which it listens."""
        return f"{self._bound.getsockname()[0]}:{self.port}"

    def run(
        self, duration: float | None = None, *, once: bool = False, tell: Callable[[str], None] | None = None
    ) -> None:
        """Serve clients until `stop` is called.

        Parameters
        ----------
        duration
            For how long at most, s of the wall's clock.
        once
            Whether to end when the last client has gone.
        tell
            Takes each line about a client that sends what is none, or does not read.
        """
        self.tell, self._clients.tell = tell, self._say
        end = None if duration is None else monotonic() + duration
        if self._wall is not None:
            self._warm_up()
            self._wall.start(self.hub.now)
        while not self._stopped and (end is None or monotonic() < end):
            self._turn(end)
            if once and self.hub.served and not self.hub.sessions:
                break

    def stop(self) -> None:
        """Let `run` end, from any thread."""
        self._stopped = True
        self._wake.send(b"!")

    def close(self) -> None:
        """Let all clients go, and free the port."""
        self._clients.close()
        self._selector.close()
        self._wake.close()
        self._woken.close()

    def report(self) -> Mapping[str, Any]:
        """Return what it did: times in s, and counts of events by what became of them."""
        wall = self._wall
        return {
            "chip": self.hub.chip.path,
            "pace": self.hub.pace,
            "time_s": self.hub.now * 1e-6,
            "behind_s": 0.0 if wall is None else wall.behind * 1e-6,
            "slipped_s": 0.0 if wall is None else wall.slipped * 1e-6,
            "clients": self.hub.served,
            "events": named(self.hub.counts()),
            "on_chip": dict(self.hub.chip.lost),
        }

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _clients_of(self, form: Form, to: Any) -> TcpClients | UdpClients:
        tick = 0 if self._wall is None else self._wall.tick
        self._bound.settimeout(0.0)
        if self._bound.type == socket.SOCK_STREAM:
            return TcpClients(self.hub, form, self._selector, self._bound, tick)
        return UdpClients(self.hub, form, self._selector, self._bound, tick, to)

    def _warm_up(self) -> None:
        """Let the chip compile what it needs before time runs; its state stays."""
        chip = self.hub.chip
        kept = chip.state
        chip.advance(1e-3)
        chip.state = kept

    def _turn(self, end: float | None) -> None:
        """Look at all who are ready, let the chip go on, and tell."""
        for key, _ in self._selector.select(self._wait(end)):
            key.data()
        hub = self.hub
        goal = hub.goal() if self._wall is None else self._wall.goal(hub.now)
        if goal > hub.now:
            hub.go_on(goal)
        hub.finish()
        for session in hub.sessions:
            for remark in session.inlet.remarks:
                self._say(f"{session.name}: {remark}")
            session.inlet.remarks.clear()
        self._clients.tend()

    def _wait(self, end: float | None) -> float:
        hub = self.hub
        if self._wall is not None:
            wait = self._wall.wait(hub.now)
        else:
            wait = 0.0 if hub.goal() > hub.now else _LONGEST
        return wait if end is None else min(wait, max(end - monotonic(), 0.0))

    def _say(self, line: str) -> None:
        """Tell a line, unless many of its kind have been told."""
        kind = line.partition(": ")[2].rstrip("0123456789")[:20]
        self._said[kind] += 1
        if self.tell is not None and self._said[kind] <= _LINES:
            self.tell(line if self._said[kind] < _LINES else f"{line}; no more of these are told")


def _bound(at: str, kind: socket.SocketKind) -> socket.socket:
    address, family = _resolved(at, kind), socket.AF_INET
    bound = socket.socket(family, kind)
    try:
        if kind == socket.SOCK_STREAM:
            bound.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        bound.bind(address)
    except OSError as error:
        bound.close()
        reason = error.strerror or error
        raise ParameterError(f"port: {at}, {reason}; name another, 0 for any that is free") from None
    return bound


def _resolved(at: str, kind: socket.SocketKind) -> Any:
    """The address of a host and its port as sockets take it."""
    host, _, port = at.rpartition(":")
    if not port.isdecimal() or not 0 <= int(port) <= 65_535 or not host:
        raise ParameterError(f'"{at}", must be HOST:PORT, as 127.0.0.1:8990; a port is 0 to 65535')
    try:
        return socket.getaddrinfo(host, int(port), socket.AF_INET, kind)[0][4]
    except OSError as error:
        raise ParameterError(f"host: {host}, {error.strerror}; name one of this machine's") from None
