"""Records and datagrams of both formats: what is written is read, numbers tell what is missing."""

from __future__ import annotations

import struct

import numpy as np
import pytest

from chips.aer import Events, read_events, write_events
from chips.live.chip import Addresses
from circuits.errors import DataError
from system.stream.form import JAER, MTU, NATIVE, SET_BACK, SensorClock
from system.stream.record import Hello, hello_size, read_hello

ROWS = np.column_stack((np.arange(1000), np.arange(1000) % 7)).astype(np.int64)


def test_records_are_those_of_a_file_of_events(tmp_path) -> None:  # type: ignore[no-untyped-def]
    path = tmp_path / "events.bin"
    write_events(path, Events(ROWS[:, 0] * 1e-6, ROWS[:, 1]))
    assert path.read_bytes() == NATIVE.head + NATIVE.data(ROWS)
    assert np.array_equal(NATIVE.rows(path.read_bytes()[8:]), ROWS)
    assert np.array_equal(read_events(path).addresses, ROWS[:, 1])


def test_jaers_records_are_big_endian_with_the_address_first() -> None:
    assert JAER.data(np.array([[2**32 + 5, 1027]])) == struct.pack(">ii", 1027, 5)
    assert JAER.rows(struct.pack(">iiii", 1027, 5, -1, -2)).tolist() == [[5, 1027], [-2, 2**32 - 1]]


def test_datagrams_fit_and_their_numbers_tell_what_is_missing() -> None:
    for form, count in ((NATIVE, 91), (JAER, 183)):
        sent = form.datagrams(ROWS, 7)
        assert max(map(len, sent)) <= MTU
        assert np.array_equal(np.concatenate([form.rows(d[form.before :]) for d in sent]), ROWS)
        expected = form.after(form.number(sent[0]), count)
        assert form.missed(expected, form.number(sent[1])) == 0
        assert form.missed(expected, form.number(sent[3])) == (2 if form.wraps else 2 * count)
        assert form.missed(expected, form.number(sent[0])) < 0
    assert JAER.missed(2**32 - 2, 1) == 3
    assert JAER.number(JAER.numbered(2**31 + 5, b"")) == 2**31 + 5


@pytest.mark.parametrize(
    ("form", "data"), [(NATIVE, b"GET / HTTP/1.1\r\n"), (NATIVE, b"?"), (JAER, b"12345")]
)
def test_a_datagram_that_is_none_is_refused(form: type[NATIVE], data: bytes) -> None:  # type: ignore[valid-type]
    with pytest.raises(DataError, match="must be"):
        form.number(data)


def test_a_sensors_clock_wraps_and_is_set_back() -> None:
    clock = SensorClock()
    near = 2**31 - 10
    times = np.array([near, near + 5, near + 25 - 2**32, near + 24 - 2**32, 3, 7])
    told = clock(np.column_stack((times, times)), 1000)[:, 0]
    assert told.tolist() == [
        1000,
        1005,
        1025,
        1024,
        *(1024 + passed(times[3], 3) + np.array([0, 4])).tolist(),
    ]
    later = clock(np.array([[7 - 2 * SET_BACK, 0], [17 - 2 * SET_BACK, 0]]), 0)[:, 0]
    assert (later - told[-1]).tolist() == [0, 10]


def passed(before: int, after: int) -> int:
    """Us between two times of 32 bits."""
    return int((after - before + 2**31) % 2**32 - 2**31)


def test_what_a_server_says_first_is_read() -> None:
    kinds = (Addresses("excite", 131072, 1024),), (Addresses("neuron", 0, 256),)
    hello = Hello("rolls", "real", 12, *kinds, 1000)
    data = hello.bytes()
    assert (hello_size(data[:10]), hello_size(data)) == (0, len(data))
    assert read_hello(data) == hello
    with pytest.raises(DataError, match="must be b'NOCTAER1'"):
        hello_size(b"HTTP/1.1")
