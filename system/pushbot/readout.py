"""Commands from spikes: equations (1) and (2) of Milde et al. 2017 over a window, or spikes themselves.

    fixed      counts of a window become a command at its end; the next window begins at 0
    sliding    at every look the counts of the last window
    spikes     no window: spikes drive the motors, whose inertia smooths them (the paper's wish, section 4)

The paper's robot has fixed windows of 500 ms, its improved versions 50 ms and a running average. Counts are
taken to 500 ms, so that speed and turn factors mean the same with every window.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from circuits.arrays import F64
from circuits.errors import ParameterError
from system.pushbot.body import Factors, demand

Kind = Literal["fixed", "sliding", "spikes"]
KINDS: tuple[Kind, ...] = ("fixed", "sliding", "spikes")

REFERENCE = 0.5  # s; window that the paper's factors belong to
LOOK = 0.05  # s between two exchanges of events at most; ours
DIRECT = 5e-3  # s, in which spikes that drive the motors are taken together: the robot's step
OUTPUTS = ("DL", "DR", "sp")


@dataclass(frozen=True, slots=True)
class Readout:
    """How spikes become commands; window: s, `DIRECT` where spikes drive the motors.

    Raises `ParameterError` for another kind, or a window that is no whole number of looks.

    factors : of equations (1) and (2).
    """

    factors: Factors = field(default_factory=Factors)
    window: float = REFERENCE
    kind: Kind = "sliding"

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise ParameterError(f"readout: {self.kind}, must be one of {', '.join(KINDS)}")
        if self.kind == "spikes":
            if self.window != DIRECT:
                raise ParameterError(
                    f"window: {self.window:g} s, must not be given with `readout=spikes`; leave it out"
                )
            return
        looks = round(self.window / LOOK)
        if looks < 1 or abs(looks * LOOK - self.window) > 1e-9:
            raise ParameterError(
                f"window: {self.window:g} s, must be a whole number of {LOOK:g} s; the paper has 500ms and"
                " 50ms"
            )

    @property
    def look(self) -> float:
        """Time between two exchanges of events, s."""
        return DIRECT if self.kind == "spikes" else LOOK

    @property
    def looks(self) -> int:
        """Number of looks in a window."""
        return round(self.window / self.look)


@dataclass(slots=True)
class Counter:
    """State: spikes a neuron of OUTPUTS in each look of the window so far.

    counts : a row a look, float64[looks, 3].
    """

    counts: deque[F64] = field(default_factory=deque)


def read(readout: Readout, counter: Counter, counts: F64) -> tuple[float, float] | None:
    """(v, w) after a look with `counts`, float64[3], spikes a neuron of OUTPUTS; None where none is due."""
    counter.counts.append(counts)
    if readout.kind == "sliding":
        while len(counter.counts) > readout.looks:
            counter.counts.popleft()
    elif len(counter.counts) < readout.looks:
        return None
    drive_left, drive_right, speed = (REFERENCE / readout.window * np.sum(counter.counts, axis=0)).tolist()
    if readout.kind != "sliding":
        counter.counts.clear()
    return demand(readout.factors, drive_left, drive_right, speed)
