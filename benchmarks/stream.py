"""Claim: a stream on the loopback carries 500,000 events/s in and out over TCP, and none is lost.

A server (`noctule serve CHIP`) runs in a process of its own, and a client in this one. `ours` is in the unit
that the row's name says. Over UDP what was lost is counted: what the chip took and what was missed make all
that was sent, and what came back and what was missed make all that was sent back. Latency is from the call
that sends an event for as soon as may be to the spike's being there, on the loopback that gives each event
back, at real pace. Its claim is of an idle core: `accuracy` has the load of the machine. The rows of ROLLS
are what a chip gives with an event in 20 us on 256 neurons; its latency is from the chip's time of a spike,
by the client's least distance between the server's time and its own. Processor time is the server's.

Returns 1 where a claim is missed.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter, sleep
from typing import Any

import numpy as np

from _report import Row, parser_of, report
from chips.aer import Events
from system.stream.client import EventStream

RATE = 5e5  # events/s
CHUNK = 5000  # events that are sent at once
PROGRAM = """
from chips.api.rolls import Network, PopulationInput, network_program, place, winner_take_all

sides = place({"left": 128, "right": 128})
groups = tuple(sides.values())
inputs = tuple(PopulationInput(name, side) for name, side in sides.items())
program = network_program(Network(groups, winner_take_all(groups, excitation=0, inhibition=-1), inputs))
"""


@dataclass(slots=True)
class Served:
    """A server that runs: its port, and when it has ended what it did and its processor time, s."""

    port: int
    cpu: float = 0.0
    did: dict[str, Any] = field(default_factory=dict)


@contextmanager
def server(*options: str) -> Iterator[Served]:
    """A server in a process of its own, which ends when its client has gone."""
    command = [
        sys.executable,
        "-m",
        "system.cli.command_line",
        "serve",
        *options,
        "--port",
        "0",
        "--once",
        "--json",
    ]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        line = process.stderr.readline() if process.stderr else ""
        served = Served(int(line.partition("listens at ")[2].partition(",")[0].rpartition(":")[2]))
        before = cpu_of(process.pid)
        yield served
        served.cpu = cpu_of(process.pid) - before
        out, _ = process.communicate(timeout=90)
        served.did = json.loads(out)


def cpu_of(process: int) -> float:
    """Processor time of a process so far, s."""
    fields = Path(f"/proc/{process}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def main() -> int:
    """Measure and print all rows."""
    parser = parser_of(__doc__, "a fifth as long")
    options = parser.parse_args()
    long = 0.2 if options.quick else 1.0
    rows = [*tcp(2e6 * long), paced(5.0 * long), *udp(5e5 * long), *latency(4.0 * long)]
    with TemporaryDirectory() as folder:
        program = Path(folder) / "sides.py"
        program.write_text(PROGRAM, encoding="utf-8")
        chip = ("rolls", "--die", "1001", "--program", f"{program}:program")
        rows += [rolls_fast(chip, 5.0 * long), rolls_latency(chip, 5.0 * long)]
    return report(rows, options, lambda row: f"{row.ours:10.4g}")


def load() -> str:
    """How many processes wanted a core of this machine in the last minute."""
    return f"load {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores"


def stamps(stream: EventStream, count: int) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Times of so many events, one each 2 us from the chip's time on, s."""
    return stream.time + 1e-6 + np.arange(count) / RATE


def tcp(count: float) -> list[Row]:
    """As fast as it goes: events in, and back."""
    with server("loopback") as served, EventStream(served.port) as stream:
        times, got, begun = stamps(stream, int(count)), 0, perf_counter()
        for k in range(0, times.size, CHUNK):
            stream.send(times[k : k + CHUNK], np.arange(k, k + times[k : k + CHUNK].size))
            got += stream.receive().times.size
        got += stream.until(float(times[-1]) + 1e-6).times.size
        rate = times.size / (perf_counter() - begun)
        got += stream.end().times.size
        lost = 2 * times.size - stream.counts["taken"] - got
    cost = 1e6 * served.cpu / times.size
    note = f"{lost} of {times.size} lost, {cost:.2g} us of the server an event, {load()}"
    return [
        Row("TCP, events/s in and out", rate, RATE, rate / RATE, note, least=1.0),
        Row("TCP, share that came back", got / times.size, 1.0, got / times.size, note, least=1.0, most=1.0),
    ]


def paced(duration: float) -> Row:
    """500,000 events/s by the wall's clock."""
    with server("loopback", "--pace", "real") as served, EventStream(served.port) as stream:
        stream.until(stream.time + 0.05)  # a clock that goes
        sent, got, begun, zero = 0, 0, perf_counter(), stream.time
        while (now := perf_counter() - begun) < duration:
            count = int(now * RATE) - sent
            stream.send(zero + 5e-3 + (sent + np.arange(count)) / RATE, np.arange(count))
            sent += count
            got += stream.receive(1e-3).times.size
        got += stream.end().times.size
        lost, late = 2 * sent - stream.counts["taken"] - got, stream.counts["late"]
    note = (
        f"{lost} of {sent} lost, {late} late by the wall's clock, the server behind by"
        f" {1e3 * served.did['behind_s']:.2g} ms at most, {served.cpu / duration:.0%} of a core, {load()}"
    )
    return Row(
        "TCP at real pace, events/s in and out", got / duration, RATE, got / sent, note, least=1.0, most=1.0
    )


def udp(count: float) -> list[Row]:
    """500,000 events/s to a chip without a clock, nobody waiting for anybody."""
    with server("loopback", "--udp") as served, EventStream(served.port, udp=True) as stream:
        times, got, begun = stamps(stream, int(count)), 0, perf_counter()
        for k in range(0, times.size, 1000):
            stream.send(times[k : k + 1000], np.arange(times[k : k + 1000].size))
            got += stream.receive().times.size
            sleep(max(begun + k / RATE - perf_counter(), 0.0))
        got += stream.until(float(times[-1]) + 1e-6).times.size
        got += stream.end().times.size
        counts, missed = stream.counts, stream.missed
    into = (counts["taken"] + counts["missed"] + counts["dropped_in"] + counts["backwards"]) / times.size
    back = (got + missed) / counts["sent"]
    return [
        Row(
            "UDP in, share taken or counted",
            into,
            1.0,
            into,
            f"{counts['missed']} missed of {times.size}",
            least=1.0,
            most=1.0 + 1e-4,
        ),
        Row(
            "UDP out, share come or counted",
            back,
            1.0,
            back,
            f"{missed} missed of {counts['sent']}, {load()}",
            least=1.0,
            most=1.01,
        ),
    ]


def latency(duration: float) -> list[Row]:
    """From sending an event for as soon as may be to its coming back, one after another."""
    rows = []
    for over in ("TCP", "UDP"):
        options = ["--udp"] if over == "UDP" else []
        name = f"{over} latency at real pace, s, 99th percentile"
        with (
            server("loopback", "--pace", "real", *options) as served,
            EventStream(served.port, udp=bool(options)) as stream,
        ):
            rows.append(judged(name, round_trips(stream, duration), least=True))
            stream.end()
    return rows


def round_trips(stream: EventStream, duration: float) -> list[float]:
    """Seconds of each turn."""
    taken, begun = [], perf_counter()
    while perf_counter() - begun < duration:
        sent, got = perf_counter(), 0
        stream.send(None, [1])
        while not got:
            got = stream.receive(0.1).times.size
        taken.append(perf_counter() - sent)
        sleep(1e-3 * (1.0 + len(taken) % 7 / 7.0))
    return taken


def judged(name: str, taken: list[float], *, least: bool) -> Row:
    """A row of latencies: the ratio is the bar of 2 ms over the 99th percentile."""
    middle, high = np.quantile(taken, [0.5, 0.99])
    note = f"median {1e3 * middle:.2f} ms, greatest {1e3 * max(taken):.2f} ms of {len(taken)}, {load()}"
    return Row(name, float(high), 2e-3, 2e-3 / float(high), note, least=1.0 if least else 0.0)


def rolls_fast(chip: tuple[str, ...], duration: float) -> Row:
    """A ROLLS chip as fast as it goes."""
    with server(*chip) as served, EventStream(served.port) as stream:
        first, spikes, begun = stream.address("excite"), 0, perf_counter()
        count = int(duration / 20e-6)
        times = stream.time + np.arange(1, count + 1) * 20e-6
        for k in range(0, count, CHUNK):
            stream.send(times[k : k + CHUNK], first + np.arange(k, k + times[k : k + CHUNK].size) % 256)
            spikes += stream.receive().times.size
        spikes += stream.until(float(times[-1]) + 1e-6).times.size
        wall = perf_counter() - begun
        stream.end()
        counts = stream.counts
    note = (
        f"{counts['taken']} of {count} events taken, {spikes} spikes, {served.cpu / duration:.3f} s of the"
        f" server a second, {load()}"
    )
    return Row("ROLLS over TCP, times real time", duration / wall, 1.0, duration / wall, note)


def rolls_latency(chip: tuple[str, ...], duration: float) -> Row:
    """From the chip's time of a spike to its being there, at real pace."""
    ahead: list[float] = []
    late: list[np.ndarray[Any, Any]] = []
    with server(*chip, "--pace", "real") as served, EventStream(served.port) as stream:
        first, begun, sent = stream.address("excite"), perf_counter(), 0
        while (now := perf_counter() - begun) < duration:
            count = int(now / 20e-6) - sent
            stream.send(None, first + (sent + np.arange(count)) % 256)
            sent += count
            come: Events = stream.receive(1e-3)
            ahead.append(perf_counter() - stream.time)
            late.append(perf_counter() - come.times)
        stream.end()
    taken = list(np.concatenate(late) - min(ahead))
    return judged("ROLLS latency at real pace, s, 99th percentile", taken, least=False)


if __name__ == "__main__":
    sys.exit(main())
