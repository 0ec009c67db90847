"""A program's side of a stream: it sends events to a server, lets time go on, and takes spikes."""

from __future__ import annotations

import math
import select
import socket
from collections.abc import Callable
from time import monotonic
from typing import Self, final

import numpy as np
from numpy.typing import ArrayLike

from chips.aer import Events, rows_of
from chips.live.chip import Addresses
from circuits.arrays import I64
from circuits.errors import CircuitError, ParameterError, SimulatorError
from system.stream.form import NATIVE
from system.stream.record import RECORD, Code, control, hello_size, named, read_hello, records_of
from system.stream.server import PORT
from system.stream.udp import BUFFER, HELLO, LARGEST

_READ = 2**18  # bytes that are read at once; ours
_AGAIN = 0.1  # s after which a datagram without an answer is sent again; ours
_SOON = -1  # us, a time that means as soon as may be


@final
class EventStream:
    """A connection to a server of address-events (`noctule serve CHIP`).

    Parameters
    ----------
    port
        Port of the server.
    host
        Host of the server.
    udp
        Whether it is one over UDP.
    patience
        How long an answer may take, s.

    Attributes
    ----------
    chip : str
        Name of the chip.
    inputs, outputs : tuple of Addresses
        What it takes and sends.
    time : float
        Time of the chip that is known, s: all spikes before it have come.
    missed : int
        Records of the server that were lost on the way, which only UDP does.
    counts : dict of str
        What became of the events that were sent, as told last: counts by name.

    Raises
    ------
    SimulatorError
        Nobody is there, or there is no answer in time.
    DataError
        It is no such server.
    """

    def __init__(
        self, port: int = PORT, host: str = "127.0.0.1", *, udp: bool = False, patience: float = 10.0
    ) -> None:
        self._place, self._udp, self._patience = f"{host}:{port}", udp, patience
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM if udp else socket.SOCK_STREAM)
        self._number = self._next = self.missed = 0
        self._rest, self._spikes = b"", list[I64]()
        self._ended, self._began, self._counts = False, False, dict[Code, int]()
        try:
            hello = read_hello(self._greeted((host, port)))
        except CircuitError:
            self.close()
            raise
        self.chip, self.inputs, self.outputs = hello.chip, hello.inputs, hello.outputs
        self._time = hello.time  # us

    @property
    def time(self) -> float:
        """Time of the chip that is known, s."""
        return self._time * 1e-6

    @property
    def counts(self) -> dict[str, int]:
        """Counts of events by what became of them, as told last."""
        return named(self._counts)

    def address(self, name: str, index: int = 0) -> int:
        """Return the address of the event number `index` of the kind `name`, one of `inputs` or `outputs`.

        Raises `ParameterError` for one that the chip does not have.
        """
        kinds: dict[str, Addresses] = {one.name: one for one in (*self.outputs, *self.inputs)}
        if name not in kinds or not 0 <= index < kinds[name].count:
            known = ", ".join(f"{one.name}[{one.count}]" for one in kinds.values())
            raise ParameterError(f"{self.chip}.{name}[{index}]: not there; it has {known}")
        return kinds[name].first + index

    def send(self, times: ArrayLike | None, addresses: ArrayLike) -> None:
        """Send events.

        Parameters
        ----------
        times
            Times of the chip, s, float64[m], none before the one ahead; one number for all, None for as soon
            as may be.
        addresses
            Addresses, int64[m].

        Raises
        ------
        ParameterError
            There are not as many times as addresses.
        SimulatorError
            The server has gone.
        """
        where = np.atleast_1d(np.asarray(addresses, dtype=np.int64))
        when = np.asarray(_SOON * 1e-6 if times is None else times, dtype=np.float64)
        if when.ndim and when.shape != where.shape:
            raise ParameterError(f"send: {when.size} times and {where.size} addresses, must be as many")
        self._send(rows_of(np.broadcast_to(when, where.shape), where))

    def until(self, time: float) -> Events:
        """Let a fast run go on, or wait, to `time`, s, and return the spikes up to it.

        Raises `SimulatorError` where there is no answer in time, or the server has gone.
        """
        goal = round(time * 1e6)
        self._ask(control(Code.TIME, goal), lambda: self._time >= goal)
        return self._taken()

    def receive(self, wait: float = 0.0) -> Events:
        """Return the spikes that have come, or come within `wait`, s."""
        end = monotonic() + wait
        while self._read(max(end - monotonic(), 0.0)) and not self._spikes:
            pass
        while self._read(0.0):
            pass
        return self._taken()

    def end(self) -> Events:
        """Say that no more will come, and return the last spikes; `counts` are then the last ones.

        Raises `SimulatorError` where there is no answer in time.
        """
        self._ask(control(Code.END, 0), lambda: self._ended)
        return self._taken()

    def close(self) -> None:
        """Go away."""
        self._socket.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _greeted(self, place: tuple[str, int]) -> bytes:
        """The server's first bytes."""
        try:
            self._socket.connect(place)
        except OSError as error:
            raise self._failed(error.strerror or str(error)) from None
        for option in (socket.SO_RCVBUF, socket.SO_SNDBUF) if self._udp else ():
            self._socket.setsockopt(socket.SOL_SOCKET, option, BUFFER)
        self._socket.settimeout(0.0)
        data, end, size = b"", monotonic() + self._patience, 0
        while not size or len(data) < size:
            if self._udp:
                self._socket.send(NATIVE.numbered(0, b""))
            if monotonic() > end:
                raise self._failed("no answer")
            if not select.select([self._socket], [], [], _AGAIN)[0]:
                continue
            found = self._bytes()
            data = found[NATIVE.before :] if self._udp else data + found
            if self._udp and NATIVE.number(found) != HELLO:
                data = b""
            size = hello_size(data)
        self._rest = b"" if self._udp else data[size:]
        return data[:size]

    def _ask(self, record: tuple[int, int], answered: Callable[[], bool]) -> None:
        """Send a record until it is answered; over UDP it may be lost."""
        told, end = -math.inf, monotonic() + self._patience
        while not answered() and not self._ended:
            if monotonic() - told >= (_AGAIN if self._udp else math.inf):
                self._send(np.array([record], dtype=np.int64))
                told = monotonic()
            before = self._time
            self._read(_AGAIN)
            end = monotonic() + self._patience if self._time > before else end
            if monotonic() > end:
                raise self._failed(f"no answer for {self._patience:g} s")

    def _send(self, rows: I64) -> None:
        if self._udp:
            for datagram in NATIVE.datagrams(rows, self._number):
                self._push(datagram)
            self._number += len(rows)
            return
        self._push((b"" if self._began else NATIVE.head) + NATIVE.data(rows))
        self._began = True

    def _push(self, data: bytes) -> None:
        """Send bytes, and take what comes meanwhile, so that neither side waits for the other."""
        view, end = memoryview(data), monotonic() + self._patience
        while view:
            readable, writable, _ = select.select([self._socket], [self._socket], [], _AGAIN)
            if readable:
                self._read(0.0)
            if writable:
                try:
                    view = view[self._socket.send(view) :]
                except OSError as error:
                    raise self._failed(error.strerror or str(error)) from None
                end = monotonic() + self._patience
            if monotonic() > end:
                raise self._failed(f"took nothing for {self._patience:g} s")

    def _read(self, wait: float) -> bool:
        """Take what has come, or comes within `wait` s; whether there was anything."""
        if self._ended or not select.select([self._socket], [], [], wait)[0]:
            return False
        data = self._bytes()
        if self._udp:
            number = NATIVE.number(data)
            if number < self._next:  # the first answer again, or one that is late and was counted as missed
                return True
            data = data[NATIVE.before :]
            self.missed += number - self._next
            self._next = number + len(data) // RECORD
        else:
            data = self._rest + data
        rows = records_of(data)
        self._rest = data[len(rows) * RECORD :]
        self._take(rows)
        return True

    def _take(self, rows: I64) -> None:
        events = rows[:, 1] >= 0
        if events.any():
            self._spikes.append(rows[events])
        for value, code in rows[~events].tolist():
            if code == Code.TIME:
                self._time = value
            elif code == Code.END:
                self._ended = True
            else:
                self._counts[Code(code)] = value

    def _taken(self) -> Events:
        rows = np.concatenate([np.empty((0, 2), dtype=np.int64), *self._spikes])
        self._spikes.clear()
        return Events(rows[:, 0] * 1e-6, rows[:, 1].astype(np.int64))

    def _bytes(self) -> bytes:
        try:
            data = self._socket.recv(LARGEST if self._udp else _READ)
        except OSError as error:
            raise self._failed(error.strerror or str(error)) from None
        if not data and not self._udp:
            raise self._failed("the server has gone")
        return data

    def _failed(self, why: str) -> SimulatorError:
        return SimulatorError(f"stream {self._place}: {why}; is noctule serve running there?")
