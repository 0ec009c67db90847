"""Runs in ngspice: its library, decks, testbenches, and the comparison with the solver."""

from netlists.foundry.engine import operating_point, simulate
from netlists.ngspice.agreement import Agreement, compare
from netlists.ngspice.library import version
from netlists.ngspice.raw import write_raw
from netlists.ngspice.run import Waveforms, run
from netlists.ngspice.small_signal import ac, noise

__all__ = [  # noqa: RUF022 - in the order of the reference, grouped by its headings
    # The library
    "version",
    # Decks
    "run",
    "Waveforms",
    # Testbenches
    "simulate",
    "operating_point",
    "ac",
    "noise",
    "write_raw",
    # The solver beside ngspice
    "compare",
    "Agreement",
]
