"""Circuits of PySpice:ours written as theirs, theirs taken over as ours, and a simulator for them."""

from netlists.pyspice.read import from_pyspice
from netlists.pyspice.write import Simulator, pyspice_simulator, to_pyspice

__all__ = [  # noqa: RUF022 - in the order of the reference, grouped by its headings
    # PySpice
    "to_pyspice",
    "pyspice_simulator",
    "Simulator",
    "from_pyspice",
]
