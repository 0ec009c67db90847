"""Small signals about an operating point: voltages and currents at the frequencies that measures ask for.

With u the voltages that a source moves (`circuits.solver.small_signal`), a current (`circuits.gradient.flow`)
moves by

    i = (s_G + j 2 pi f s_C)^T u

with s_G what voltages do at the operating point to what flows without charge, S, and s_C its charges, F.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from circuits.arrays import C128, F64
from circuits.gradient.flow import Flow, flow_of, gather
from circuits.gradient.sums import ends_of, no_sums
from circuits.measure.current import current_in
from circuits.solver.operating_point import OperatingPoint
from circuits.solver.small_signal import Linear, linearise, source_column

if TYPE_CHECKING:
    from scipy.sparse.linalg import SuperLU

Moves = tuple[tuple[str, complex], ...]  # name of a source, and what it moves by, V or A, each
Probe = int | str  # column of a voltage, or name of the device or source whose current is read


class Drawn(NamedTuple):
    """A current as a sum over the voltages.

    flow : what carries it.
    conducted : float64[columns], S, s_G.
    charge : float64[columns], F, s_C.
    """

    flow: Flow
    conducted: F64
    charge: F64

    def at(self, frequency: float) -> C128:
        """What each voltage does to it at a frequency, Hz, complex128[columns], S."""
        return self.conducted + 2j * np.pi * frequency * self.charge


class Spectrum:
    """Small signals about an operating point at the frequencies that measures ask for, each solved once."""

    def __init__(self, point: OperatingPoint) -> None:
        self.point = point
        self.linear: Linear = linearise(point)
        self._factors: dict[float, SuperLU] = {}
        self._driven: dict[Moves, tuple[C128, C128, C128]] = {}
        self._full: dict[tuple[Moves, float], C128] = {}
        self._drawn: dict[str, Drawn] = {}

    def probe(self, node: str) -> Probe:
        """What reads a node, or `i(NAME)`; raises `UnknownNameError` where there is none."""
        name = current_in(node)
        if name is None:
            return self.point.machine.column_of(node)
        self.drawn(name)
        return name

    def drawn(self, name: str) -> Drawn:
        """The current of a device or source; raises `UnknownNameError` where there is none."""
        if name not in self._drawn:
            machine = self.point.machine
            ends = ends_of(machine)
            flow, slopes = flow_of(machine, name, ends), np.zeros((1, machine.kernel.columns))
            none = no_sums(machine.kernel, 1, ends)
            gather(machine.kernel, self.point.voltage[None, :], np.ones(1), flow, 0, slopes, none)
            self._drawn[name] = Drawn(flow, slopes[0], flow.charge)
        return self._drawn[name]

    def read(self, moves: Moves, frequency: float, probe: Probe) -> complex:
        """Transfer to a voltage or a current at a frequency, Hz."""
        full = self.at(moves, frequency)
        return complex(full[probe] if isinstance(probe, int) else self.drawn(probe).at(frequency) @ full)

    def slope(self, moves: Moves, frequency: float, probe: Probe) -> complex:
        """How a transfer changes with the frequency, a Hz."""
        along = self._along(moves, frequency)
        if isinstance(probe, int):
            return complex(along[probe])
        own = self.drawn(probe)
        by_rate = 2j * np.pi * (own.charge @ self.at(moves, frequency))
        return complex(own.at(frequency) @ along + by_rate)

    def at(self, moves: Moves, frequency: float) -> C128:
        """All voltages at a frequency, Hz, complex128[columns], V; A at sources of current."""
        if (moves, frequency) not in self._full:
            driven, by_g, by_c = self._drive(moves)
            full = driven.copy()
            full[: by_g.size] = self._factored(frequency).solve(-(by_g + 2j * np.pi * frequency * by_c))
            self._full[moves, frequency] = full
        return self._full[moves, frequency]

    def backwards(self, frequency: float, weights: C128) -> C128:
        """Solution of the transposed equations at a frequency, complex128[unknowns]; weights: as that."""
        return np.asarray(self._factored(frequency).solve(weights, trans="T"))

    def transfers(self, moves: Moves, frequency: F64, probes: Sequence[Probe]) -> C128:
        """Transfers to some voltages and currents, complex128[F, probes]; frequency: float64[F], Hz."""
        new = [f for f in frequency.tolist() if f not in self._factors]
        for f, factors in zip(new, self.linear.admittances(np.array(new)), strict=True):
            self._factors[f] = factors
        every = frequency.tolist()
        return np.array([[self.read(moves, f, probe) for probe in probes] for f in every])

    def _along(self, moves: Moves, frequency: float) -> C128:
        """How the voltages change with the frequency, complex128[columns], V/Hz."""
        found = np.zeros(self.point.machine.kernel.columns, dtype=complex)
        forced = 2j * np.pi * (self.linear.charge @ self.at(moves, frequency))
        found[: forced.size] = self._factored(frequency).solve(-forced)
        return found

    def _factored(self, frequency: float) -> SuperLU:
        if frequency not in self._factors:
            self._factors[frequency] = next(self.linear.admittances(np.array([frequency])))
        return self._factors[frequency]

    def _drive(self, moves: Moves) -> tuple[C128, C128, C128]:
        """What moves, complex128[columns], and the currents that it makes by G, and by C per rad/s."""
        if moves not in self._driven:
            full = np.zeros(self.point.machine.kernel.columns, dtype=complex)
            for source, value in moves:
                full[source_column(self.point, source)] = value
            self._driven[moves] = full, self.linear.conductance @ full, self.linear.charge @ full
        return self._driven[moves]
