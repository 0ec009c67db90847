"""A robot's program that talks to a served ranging chip: a call and an echo go out, spikes come back.

`talk` is all that such a program needs, in any language; it knows nothing of noctule but the format.

    noctule serve ranging-chip --die 1001
    python examples/stream_client.py 8990

The second needs the port that the first says. Without one it serves the chip itself.
"""

from __future__ import annotations

import socket
import struct
import sys
from threading import Thread

import numpy as np

from chips.api import open_chip
from circuits.api import Die
from system.api import EventServer

TIME = -1  # address of a record that says: no event before this time comes after it


def talk(port: int) -> np.ndarray[tuple[int, ...], np.dtype[np.int64]]:
    """The chip's spikes: a row each, microseconds since the call and neuron."""
    with socket.create_connection(("127.0.0.1", port)) as robot:
        stream = robot.makefile("rwb")
        head = stream.read(80)
        size, _, now = struct.unpack_from("<IIq", head, 8)
        stream.read(size - 80)  # names of addresses: here the call is 0, the echo 1
        call, end = now + 1000, now + 50_000
        events = [(call, 0), (call + 8000, 1), (end, TIME)]
        stream.write(b"NOCTAER1" + np.array(events, dtype="<i8").tobytes())
        stream.flush()
        spikes: list[tuple[int, int]] = []
        while True:
            time, address = struct.unpack("<qq", stream.read(16))
            if address >= 0:
                spikes.append((time - call, address))
            elif (time, address) == (end, TIME):
                return np.array(spikes)


def main() -> None:
    """Talk to the port that is named, or to a chip that is served here."""
    if sys.argv[1:2] and sys.argv[1].isdecimal():
        print(talk(int(sys.argv[1])))
        return
    with EventServer(open_chip("ranging-chip", Die("A", 1001)), "127.0.0.1:0") as server:
        serving = Thread(target=server.run)
        serving.start()
        spikes = talk(server.port)
        server.stop()
        serving.join()
    print(f"{len(spikes)} spikes, the first of neuron {spikes[0][1]} {spikes[0][0]} us after the call")


if __name__ == "__main__":
    main()
