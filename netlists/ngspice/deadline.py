"""How long a run in ngspice may take unless it is told: ngspice itself goes on for ever."""

from __future__ import annotations

DEADLINE = 600.0  # s of wall clock, ours
