"""The two formats in which events are sent: noctule's own (`system.stream.record`), and jAER's.

jAER's, from its source (`net.sf.jaer.eventio`: `AESocket`, `AEUnicastOutput`, `AEUnicastInput`, defaults of
`AEUnicastSettings`), is big-endian:

    TCP  int32 address, int32 time in us, for each event, and nothing else
    UDP  int32 number of the datagram, from 0 on, then events as above; at most 63000 bytes

Its times are of the sensor's clock and wrap after 2^32 us: they are told from the first event, which is for
the chip's time at which it comes. A clock that is set back by more than a second goes on from the event
before.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from chips.aer import MAGIC
from circuits.arrays import I64
from circuits.errors import DataError
from system.stream.record import RECORD, records_of

TICKS = 2**32  # of a clock of 32 bits
SET_BACK = 1_000_000  # us by which a sensor's clock must fall to have been set anew; ours
MTU = 1472  # bytes of a datagram that no network cuts: Ethernet's 1500 less the headers of IP and UDP
Clock = Callable[[I64, int], I64]  # of records (int64[m, 2]) and the chip's time (us): records of its time
_SEQUENCE = struct.Struct("<8sq")
_NUMBER = struct.Struct(">i")


@dataclass(frozen=True, slots=True)
class Form:
    """A format.

    name : what it is called; record : bytes of a record; head : of a client's first bytes over TCP.
    before : bytes of a datagram ahead of its records; controls : whether it has records that are no events.
    rows, data : records of bytes, and bytes of records (int64[m, 2]).
    numbered : a datagram with its number ahead; number : reads it, and raises `DataError` for rubbish.
    wraps : where the number begins again, which then counts datagrams; 0 where it counts records.
    clock : makes what a client's times are told by.
    """

    name: str
    record: int
    head: bytes
    before: int
    controls: bool
    rows: Callable[[bytes], I64]
    data: Callable[[I64], bytes]
    numbered: Callable[[int, bytes], bytes]
    number: Callable[[bytes], int]
    wraps: int
    clock: Callable[[], Clock]

    def datagrams(self, rows: I64, number: int) -> list[bytes]:
        """Return the datagrams of records, the first with a number."""
        most = (MTU - self.before) // self.record
        found = []
        for k in range(0, len(rows), most):
            some = rows[k : k + most]
            found.append(self.numbered(number, self.data(some)))
            number = self.after(number, len(some))
        return found

    def after(self, number: int, records: int) -> int:
        """Return the number of the datagram that comes after one of so many records."""
        return (number + 1) % self.wraps if self.wraps else number + records

    def missed(self, expected: int, number: int) -> int:
        """Return how many are missing before a number; below 0 for a datagram that is late."""
        if not self.wraps:
            return number - expected
        return (number - expected + self.wraps // 2) % self.wraps - self.wraps // 2


def _number(datagram: bytes) -> int:
    if len(datagram) < _SEQUENCE.size or (len(datagram) - _SEQUENCE.size) % RECORD:
        raise DataError(f"{len(datagram)} bytes, must be 16 and 16 a record")
    magic, number = _SEQUENCE.unpack_from(datagram)
    if magic != MAGIC or number < -1:
        raise DataError(f"begins with {datagram[:8]!r}, must be {MAGIC!r} and a number")
    return int(number)


def _jaer_number(datagram: bytes) -> int:
    if len(datagram) < _NUMBER.size or (len(datagram) - _NUMBER.size) % 8:
        raise DataError(f"{len(datagram)} bytes, must be 4 and 8 an event")
    return int(_NUMBER.unpack_from(datagram)[0]) % TICKS


def _jaer_rows(data: bytes) -> I64:
    found = np.frombuffer(data, dtype=">i4", count=len(data) // 8 * 2).reshape(-1, 2)
    rows = found[:, ::-1].astype(np.int64)
    rows[:, 1] %= TICKS  # an address has no sign
    return rows


def _jaer_data(rows: I64) -> bytes:
    return np.ascontiguousarray(rows[:, ::-1]).astype(">i4").tobytes()  # a time beyond 32 bits wraps


@final
class SensorClock:
    """Times of a sensor, whose clock has 32 bits, by the chip's."""

    def __init__(self) -> None:
        self._told: tuple[int, int] | None = (
            None  # the last of the sensor's times, us, and what it was for us
        )

    def __call__(self, rows: I64, now: int) -> I64:
        """Return records (int64[m, 2]) with times of the chip, us, which is at `now`."""
        if not len(rows):
            return rows
        before, told = self._told or (int(rows[0, 0]), now)
        passed = np.diff(rows[:, 0], prepend=before)
        passed = (passed + TICKS // 2) % TICKS - TICKS // 2
        times = told + np.cumsum(np.where(passed < -SET_BACK, 0, passed))
        self._told = int(rows[-1, 0]), int(times[-1])
        return np.column_stack((times, rows[:, 1]))


def _same(rows: I64, _: int) -> I64:
    return rows


def _data(rows: I64) -> bytes:
    return rows.astype("<i8").tobytes()


def _numbered(number: int, data: bytes) -> bytes:
    return _SEQUENCE.pack(MAGIC, number) + data


def _jaer_numbered(number: int, data: bytes) -> bytes:
    return _NUMBER.pack((number + TICKS // 2) % TICKS - TICKS // 2) + data


NATIVE = Form(
    name="noctule", record=RECORD, head=MAGIC, before=_SEQUENCE.size, controls=True, rows=records_of,
    data=_data, numbered=_numbered, number=_number, wraps=0, clock=lambda: _same,
)  # fmt: skip
JAER = Form(
    name="jaer", record=8, head=b"", before=_NUMBER.size, controls=False, rows=_jaer_rows, data=_jaer_data,
    numbered=_jaer_numbered, number=_jaer_number, wraps=TICKS, clock=SensorClock,
)  # fmt: skip
FORMS = {form.name: form for form in (NATIVE, JAER)}


def joined(rows: I64, tail: Sequence[tuple[int, int]]) -> I64:
    """Return records with some more behind them."""
    if not tail:
        return rows
    return np.concatenate((rows, np.array(tail, dtype=np.int64)))
