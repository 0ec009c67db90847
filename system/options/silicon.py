"""Which silicon a user asked for, as the command line's texts; nothing here waits for numerical libraries."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True, slots=True)
class SiliconChoice:
    """Temperature (text, degC), the die's key, and the place of a block on a chip (`ranging-chip/neuron[2]`).

    `die` None is the nominal die; `mismatch` and `process` leave local and shared variation out. `study` is
    that die under the plan of a study, where it is a study's. `allow_implausible` lets sizes pass that no
    silicon has.
    """

    temperature: str = "27"
    lot: str = "A"
    die: int | None = None
    corner: Any = "random"  # one of circuits.silicon.die.CORNERS, which checks it
    mismatch: bool = True
    process: bool = True
    at: str | None = None
    study: Any = None  # a circuits.silicon.die.Die, which is slow to import
    allow_implausible: bool = False
