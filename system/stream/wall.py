"""The wall's clock, by which a chip goes at real pace, in whole ticks.

A chip that cannot keep up falls behind; by how much at most is kept. Where it is a tenth of a second behind,
its time slips: it goes on from there, and how much time was lost is kept too.
"""

from __future__ import annotations

from collections.abc import Callable
from time import monotonic_ns
from typing import final

LAG = 100_000  # us that a chip may be behind before its time slips; ours


@final
class Wall:
    """The wall's clock.

    tick : us between two looks at the chip; clock : tells ns.
    """

    def __init__(self, tick: int, clock: Callable[[], int] = monotonic_ns) -> None:
        self.tick, self._clock = tick, clock
        self._zero = 0  # ns
        self.behind = self.slipped = 0  # us

    def start(self, now: int) -> None:
        """Begin to count: it is `now`, us of the chip's time."""
        self._zero = self._clock() - 1000 * now

    def goal(self, now: int) -> int:
        """Return the time to which the chip, which is at `now`, is to go, us."""
        late = self._time() - now
        if late > LAG:
            self.slipped += late - LAG
            self._zero += 1000 * (late - LAG)
            late = LAG
        self.behind = max(self.behind, late - self.tick)
        return now + late // self.tick * self.tick

    def wait(self, now: int) -> float:
        """Return how long it is to the next tick of a chip at `now`, us; in s, 0 where it has passed."""
        return max(now + self.tick - self._time(), 0) * 1e-6

    def _time(self) -> int:
        return (self._clock() - self._zero) // 1000
