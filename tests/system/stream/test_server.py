"""A served chip answers as it does by hand; clients that misbehave harm nobody; nothing is lost uncounted."""

from __future__ import annotations

import socket
import struct
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from threading import Thread
from time import monotonic
from typing import Any

import numpy as np
import pytest

from chips.live.table import open_chip
from circuits.errors import DataError, ParameterError, SimulatorError, UnknownNameError
from circuits.silicon.die import Die
from system.stream import tcp
from system.stream.client import EventStream
from system.stream.record import Code, came
from system.stream.server import EventServer
from system.stream.wall import LAG, Wall


@contextmanager
def served(name: str = "loopback", lines: list[str] | None = None, **options: Any) -> Iterator[EventServer]:
    """A server that runs in a thread of its own."""
    with EventServer(open_chip(name, Die("A", 1001)), "127.0.0.1:0", **options) as server:
        thread = Thread(target=server.run, kwargs={"tell": None if lines is None else lines.append})
        thread.start()
        try:
            yield server
        finally:
            server.stop()
            thread.join()


def soon(met: Callable[[], bool]) -> bool:
    """Whether something comes about within seconds."""
    end = monotonic() + 5.0
    while monotonic() < end:
        if met():
            return True
    return False


def records(*pairs: tuple[int, int]) -> bytes:
    return np.array(pairs, dtype="<i8").tobytes()


@pytest.mark.parametrize("udp", [False, True])
def test_a_served_chip_answers_as_one_that_is_driven_by_hand(udp: bool) -> None:
    times, addresses = [1e-3, 9e-3, 21e-3, 30e-3], [0, 1, 0, 1]
    hand = open_chip("ranging-chip", Die("A", 1001))
    hand.send(times, addresses)
    wanted = hand.advance(40e-3)
    with served("ranging-chip", udp=udp) as server, EventStream(server.port, udp=udp) as stream:
        assert (stream.chip, stream.address("echo")) == ("ranging-chip", 1)
        stream.send(times, addresses)
        found = [stream.until(t) for t in (2e-3, 25e-3, 40e-3)]
        assert stream.end().times.size == 0
        counts = stream.counts
    assert wanted.times.size > 3
    assert np.concatenate([f.addresses for f in found]).tolist() == wanted.addresses.tolist()
    # a stop moves the steps that come after it, and a stream has whole microseconds
    assert np.allclose(np.concatenate([f.times for f in found]), wanted.times, rtol=0.0, atol=2e-6)
    assert (counts["taken"], counts["sent"], stream.missed) == (4, wanted.times.size, 0)


def test_at_real_pace_time_goes_on_and_all_clients_hear_all_spikes() -> None:
    with served(pace="real") as server, EventStream(server.port) as one, EventStream(server.port) as other:
        assert soon(lambda: server.hub.now > 0)
        one.send(None, [7])
        other.send(0.0, [8])
        heard: dict[EventStream, list[int]] = {one: [], other: []}
        for stream, found in heard.items():
            assert soon(lambda s=stream, f=found: f.extend(s.receive(0.01).addresses) or len(f) == 2)  # type: ignore[misc]
        one.end(), other.end()
        assert (one.counts["late"], other.counts["late"]) == (0, 1)
    assert all(sorted(found) == [7, 8] for found in heard.values())
    assert server.report()["clients"] == 2


def test_a_hundred_thousand_events_come_back_in_order_and_none_is_lost() -> None:
    count = 100_000
    with served() as server, EventStream(server.port) as stream:
        stream.send(np.arange(count) * 1e-6, np.arange(count))
        back = stream.until(count * 1e-6)
        stream.end()
    assert np.array_equal(back.addresses, np.arange(count))
    assert server.report()["events"]["taken"] == count


def test_a_client_that_sends_rubbish_floods_or_goes_away_harms_nobody(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(tcp, "ROOM_OUT", 2**16)
    lines: list[str] = []
    with served(lines=lines, pace="real") as server, EventStream(server.port) as good:
        clients = [socket.create_connection(("127.0.0.1", server.port)) for _ in range(4)]
        rubbish, torn, deaf, gone = clients
        rubbish.sendall(b"GET / HTTP/1.1\r\n\r\n")
        torn.sendall(b"NOCTAER1" + records((-1, 3))[:9])
        torn.shutdown(socket.SHUT_WR)
        deaf.sendall(b"NOCTAER1" + records(*[(-1, 5)] * 20_000, (5, 2**40), (9, 1), (0, 1), (2**62, 1)))
        gone.sendall(b"NOCTAER1" + records((3_000_000_000, 6)))
        # the one event of `gone` waits; those of `deaf` wait too for a moment, and are more
        assert soon(
            lambda: any(s.inlet.waiting == 1 and not s.counts[Code.TAKEN] for s in server.hub.sessions)
        )
        gone.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        gone.close()
        assert soon(lambda: sum("went away" in line or "must be" in line for line in lines) >= 4)
        good.send(None, [9])
        assert soon(lambda: 9 in good.receive(0.01).addresses)
        good.end()
        for each in (rubbish, torn, deaf):
            each.close()
    events = server.hub.counts()
    assert events[Code.UNKNOWN] == events[Code.FAR] == events[Code.LEFT] == 1
    assert events[Code.BACKWARDS] in {1, 2}
    assert came(events) == 20_000 + 4 + 1 + 1
    assert any("begins with b'GET / HT', must be b'NOCTAER1'" in line for line in lines)
    assert any("behind the last record, must be whole ones" in line for line in lines)
    assert any(f"address {2**40}, not on the chip" in line for line in lines)


def test_who_reads_nothing_is_dropped_and_one_client_too_many_is_sent_away(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(tcp, "PATIENCE", 0.05)
    monkeypatch.setattr(tcp, "MOST", 1)
    monkeypatch.setattr(tcp, "ROOM_OUT", 2**16)
    lines: list[str] = []
    with served(lines=lines) as server:
        deaf = socket.create_connection(("127.0.0.1", server.port))
        deaf.settimeout(0.2)
        deaf.sendall(b"NOCTAER1")
        assert soon(lambda: bool(server.hub.sessions))
        other = socket.create_connection(("127.0.0.1", server.port))
        with pytest.raises(
            OSError, match=r"timed out|reset|Broken"
        ):  # the pipe is full, or its other end gone
            for k in range(0, 10**9, 2**16):
                deaf.sendall(np.column_stack((k + np.arange(2**16), np.zeros(2**16))).astype("<i8").tobytes())
        assert soon(lambda: any("has read nothing for 0.05 s; dropped" in line for line in lines))
        deaf.close(), other.close()
    assert any("there are 1 clients, must be no more; sent away" in line for line in lines)


def test_in_a_fast_run_one_client_leads_and_others_are_refused_until_it_goes() -> None:
    with served() as server, EventStream(server.port) as first, EventStream(server.port) as second:
        first.send(1e-3, [1])
        first.until(2e-3)
        second.send(3e-3, [2])
        assert soon(lambda: server.hub.counts()[Code.REFUSED] == 1)
        first.end()
        second.send([1e-3, 3e-3], [3, 4])
        assert second.until(4e-3).addresses.tolist() == [1, 4]
        second.end()
        assert second.counts["backwards"] == 1


def test_datagrams_that_are_missing_are_counted_and_rubbish_is_told() -> None:
    lines: list[str] = []
    head = struct.Struct("<8sq")
    with served(lines=lines, udp=True) as server:
        raw = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        raw.connect(("127.0.0.1", server.port))
        for number, some in ((0, ((1, 1), (2, 1))), (5, ((7, 1),)), (3, ((6, 1),)), (6, ((9, Code.END),))):
            raw.send(head.pack(b"NOCTAER1", number) + records(*some))
        raw.send(b"rubbish")
        assert soon(lambda: server.hub.counts()[Code.TAKEN] == 3 and bool(lines))
        raw.close()
    assert server.hub.counts()[Code.MISSED] == 3
    assert "a datagram of 7 bytes, must be 16 and 16 a record; not taken" in lines[0]


def test_jaer_sends_and_hears_over_udp_and_a_map_leads_its_addresses_to_the_chip(tmp_path) -> None:  # type: ignore[no-untyped-def]
    path = tmp_path / "map.csv"
    path.write_text("from,to\n1027,3\n1027,4\n9,5\n")
    jaer = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    jaer.bind(("127.0.0.1", 0))
    jaer.settimeout(5.0)
    to = f"127.0.0.1:{jaer.getsockname()[1]}"
    with served(udp=True, form="jaer", to=to, mapped=str(path)) as server:
        jaer.sendto(struct.pack(">i6i", 41, 1027, 500, 77, 502, 9, 504), ("127.0.0.1", server.port))
        jaer.sendto(struct.pack(">i2i", 44, 9, 600), ("127.0.0.1", server.port))
        heard = struct.unpack_from(">i4i", jaer.recv(2000))
        assert soon(lambda: server.hub.counts()[Code.MISSED] == 2)
    jaer.close()
    assert heard == (0, 3, 0, 4, 0)
    assert server.hub.counts()[Code.UNKNOWN] == 1


def test_over_tcp_jaers_stream_has_events_and_nothing_else() -> None:
    with served(form="jaer") as server, socket.create_connection(("127.0.0.1", server.port)) as jaer:
        jaer.sendall(struct.pack(">6i", 5, 100, 6, 200, 7, 300))
        jaer.shutdown(socket.SHUT_WR)
        back = b""
        while more := jaer.recv(100):
            back += more
    assert struct.unpack(">6i", back) == (5, 0, 6, 100, 7, 200)


def test_a_chip_that_cannot_keep_up_slips() -> None:
    now = [0]
    wall = Wall(1000, lambda: 1000 * now[0])
    wall.start(500)
    now[0] = 2700
    assert (wall.goal(500), wall.wait(2500)) == (2500, pytest.approx(300e-6))
    now[0] += 3 * LAG
    assert wall.goal(2500) == 2500 + LAG
    assert (wall.slipped, wall.behind) == (2 * LAG + 700, LAG - 1000)


@pytest.mark.parametrize(
    ("error", "told", "options"),
    [
        (UnknownNameError, "pace slow: unknown", {"pace": "slow"}),
        (UnknownNameError, "format xml: unknown", {"form": "xml"}),
        (ParameterError, "tick: 0 s, must be", {"tick": 0.0}),
        (ParameterError, "only UDP sends elsewhere", {"to": "127.0.0.1:1"}),
        (ParameterError, '"here", must be HOST:PORT', {"at": "here"}),
        (DataError, "no such file", {"mapped": "none.csv"}),
    ],
)
def test_what_cannot_be_served_is_refused(error: type[Exception], told: str, options: dict[str, Any]) -> None:
    with pytest.raises(error, match=f"(?i){told}"):
        EventServer(open_chip("loopback"), **{"at": "127.0.0.1:0", **options})


def test_a_port_in_use_and_a_server_that_is_not_there_are_told_in_a_line() -> None:
    with EventServer(open_chip("loopback"), "127.0.0.1:0") as server:
        with pytest.raises(ParameterError, match=rf"^port: {server.place}, Address already in use; name"):
            EventServer(open_chip("loopback"), server.place)
        port = server.port
    with pytest.raises(
        SimulatorError, match=f"^stream 127.0.0.1:{port}: Connection refused; is noctule serve"
    ):
        EventStream(port)
