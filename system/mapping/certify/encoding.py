"""Events of samples as ROLLS takes them, put in order once for all dies that a process runs.

What the bus hands to which neuron in which step hangs on the inputs, the window and on how the network's
channels become events, none of which a die or its codes change.
"""

from __future__ import annotations

import hashlib
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass
from threading import Lock

import numpy as np

from chips.aer import Bus, send
from chips.rolls.brief.encoded import Encoded, encode
from chips.rolls.chip import Inputs
from circuits.arrays import F64
from system.mapping.rolls.mapped import Mapped

MOST = 1 << 29  # bytes that are kept, those of some 6,000 samples of 100 ms on 60 neurons; ours
_Key = tuple[bytes, bytes, float]


class _Kept:
    """What was encoded, of which the least recently used goes first; threads that run dies share it."""

    def __init__(self) -> None:
        self._found: OrderedDict[_Key, Encoded | None] = OrderedDict()
        self._bytes = 0
        self._turn = Lock()

    def get(self, key: _Key, make: Callable[[], Encoded | None]) -> Encoded | None:
        with self._turn:
            if key in self._found:
                self._found.move_to_end(key)
                return self._found[key]
        found = make()  # side by side: another thread may make the same
        with self._turn:
            self._bytes += _size(found) - _size(self._found.get(key))
            self._found[key] = found
            while self._bytes > MOST:
                self._bytes -= _size(self._found.popitem(last=False)[1])
        return found


def _size(found: Encoded | None) -> int:
    return 0 if found is None else found.size


_KEPT = _Kept()


@dataclass(frozen=True, slots=True)
class Wiring:
    """How channels of a mapped network become events of a chip with a bus and a step.

    name : of it, by its contents; bus, step : s; neurons : of the chip, up to the last one in use.
    """

    name: bytes
    bus: Bus
    step: float
    neurons: int

    def encoded(self, rates: F64, window: float, events: Callable[[], Inputs]) -> Encoded | None:
        """Return the encoded events of a window (s) from rest, None where they do not fit.

        rates : of all channels, Hz; events : gives those of the chip.
        """

        def make() -> Encoded | None:
            given = events()
            arrived = send(self.bus, given.times, given.neurons + (given.columns << 8))
            return encode(arrived, self.step, round(window / self.step), self.neurons)

        return _KEPT.get((self.name, rates.tobytes(), window), make)


def wiring_of(mapped: Mapped, bus: Bus, step: float) -> Wiring:
    """Return the wiring of a mapped network."""
    virtual, neurons = mapped.program.virtual, np.ascontiguousarray(mapped.neurons)
    told = hashlib.sha256(repr((virtual, bus, step, mapped.excite.shape)).encode())
    for each in (mapped.excite, mapped.inhibit, neurons):
        told.update(np.ascontiguousarray(each, dtype=np.int64).tobytes())
    return Wiring(told.digest(), bus, step, int(neurons.max()) + 1)
