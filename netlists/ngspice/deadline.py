"""How long a run in ngspice may take unless told, because ngspice itself would go on for ever."""

from __future__ import annotations

DEADLINE = 600.0  # s of wall clock, ours
