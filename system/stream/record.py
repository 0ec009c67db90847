"""What is sent over the wire: records of 16 bytes, little-endian, as in a file of events (`chips.aer`).

    int64  time in microseconds of the chip, or a count
    int64  address of the chip, or below 0 a `Code`

A client begins with the 8 bytes `NOCTAER1` and goes on with records; the server begins with a `Hello` of
its own and goes on with records. The digit is the version of the format.
"""

from __future__ import annotations

import struct
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from chips.aer import MAGIC
from chips.live.chip import Addresses
from circuits.arrays import I64
from circuits.errors import DataError

RECORD = 16  # bytes
PACES = ("fast", "real")  # by their numbers in `Hello`
_HELLO = struct.Struct("<8sIIqqIIq32s")
_KIND = struct.Struct("<qq32s")


class Code(IntEnum):
    """What a record with an address below 0 says; counts are totals of the client's session."""

    TIME = -1  # no event before this time comes after it
    END = -2  # the last record
    TAKEN = -10  # events that the chip took
    SENT = -11  # spikes sent to this client
    UNKNOWN = -12  # events of no address of the chip
    BACKWARDS = -13  # events before the one ahead of them, or before the chip's time
    FAR = -14  # events too far ahead of the chip's time
    LATE = -15  # events taken at the chip's time, since their own had passed; they are among those taken
    DROPPED_IN = -16  # events that found the queue full
    DROPPED_OUT = -17  # spikes that found the client's queue full
    MISSED = -18  # of the client's events or datagrams, those that never came
    REFUSED = -19  # events of a client while another one leads the time
    LEFT = -20  # events that waited for their time when the client went
    CHIP_LOST = -21  # events lost within the chip since it was opened, of all clients


Counts = Counter[Code]
_RESULTS = (Code.CHIP_LOST, Code.LATE)  # are no events that came, or are among others


def no_counts() -> Counts:
    """Return counts that are all 0, which other threads may read while they change."""
    return Counts({code: 0 for code in Code if code <= Code.TAKEN})


def came(counts: Mapping[Code, int]) -> int:
    """Return how many events a client sent, by what became of each."""
    lost = set(Code) - {Code.TIME, Code.END, Code.SENT, Code.DROPPED_OUT, *_RESULTS}
    return sum(counts.get(code, 0) for code in lost)


def named(counts: Mapping[Code, int]) -> dict[str, int]:
    """Return counts by their names in small letters, all that there are."""
    return {code.name.lower(): counts.get(code, 0) for code in Code if code <= Code.TAKEN}


@dataclass(frozen=True, slots=True)
class Hello:
    """What the server says first.

    chip : its name; time, tick : us, its time now and the step of its clock, 0 where it has none.
    pace : one of `PACES`; inputs, outputs : addresses that it takes and sends.
    """

    chip: str
    pace: str
    time: int
    inputs: tuple[Addresses, ...]
    outputs: tuple[Addresses, ...]
    tick: int = 0

    def bytes(self) -> bytes:
        """Return it as it is sent."""
        kinds = (*self.inputs, *self.outputs)
        size = _HELLO.size + len(kinds) * _KIND.size
        head = _HELLO.pack(
            MAGIC, size, PACES.index(self.pace), self.time, self.tick, len(self.inputs), len(self.outputs), 0,
            _short(self.chip),
        )  # fmt: skip
        return head + b"".join(_KIND.pack(k.first, k.count, _short(k.name)) for k in kinds)


def hello_size(data: bytes) -> int:
    """Return how many bytes a `Hello` has that begins with these; 0 where they are too few to say.

    Raises `DataError` where they are none.
    """
    if not data.startswith(MAGIC[: len(data)]):
        raise DataError(f"stream: begins with {data[:8]!r}, must be {MAGIC!r}; is it a noctule server?")
    return 0 if len(data) < _HELLO.size else int(_HELLO.unpack_from(data)[1])


def read_hello(data: bytes) -> Hello:
    """Return the `Hello` of its bytes; raises `DataError` where they are none."""
    try:
        _, _, pace, time, tick, inputs, outputs, _, chip = _HELLO.unpack_from(data)
        found = [_KIND.unpack_from(data, _HELLO.size + k * _KIND.size) for k in range(inputs + outputs)]
        kinds = tuple(Addresses(_long(name), first, count) for first, count, name in found)
        return Hello(_long(chip), PACES[pace], time, kinds[:inputs], kinds[inputs:], tick)
    except (struct.error, IndexError, UnicodeDecodeError) as error:
        raise DataError(f"stream: {error}, must be a server's first bytes; is it a noctule server?") from None


def control(code: Code, value: int) -> tuple[int, int]:
    """Return the record of a code."""
    return value, int(code)


def records_of(data: bytes) -> I64:
    """Return the records in some bytes, int64[m, 2]; what is left of one at the end is not among them."""
    whole = len(data) // RECORD
    rows: I64 = np.frombuffer(data, dtype="<i8", count=2 * whole).reshape(whole, 2)
    return rows


def _short(name: str) -> bytes:
    return name.encode()[:32].decode(errors="ignore").encode()


def _long(name: bytes) -> str:
    return name.rstrip(b"\0").decode()
