"""Devices of a machine by their kind, and the columns of their ends."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from circuits.arrays import I64
from circuits.devices import Capacitor, Resistor, Transistor
from circuits.lowering.flatten import DeviceGroup
from circuits.lowering.kernel import Machine

Ends = tuple[I64, I64]
"""Columns of the ends of resistors, and of what has a capacitance, int64[2, pairs] each."""
OVERLAPS = ((1, 0), (1, 2), (0, 3), (2, 3))  # of a transistor's terminals, as `capacitances` has them


def ends_of(machine: Machine) -> Ends:
    """Return the ends of resistors, and of pairs of transistors and of capacitors, in that order."""
    fets, capacitors = groups_of(machine, Transistor), groups_of(machine, Capacitor)
    pairs = [_ends(machine, fets, (1, 3)), *(_ends(machine, fets, p) for p in OVERLAPS)]
    charged = np.concatenate([*pairs, _ends(machine, capacitors, (0, 1))], axis=1)
    return _ends(machine, groups_of(machine, Resistor), (0, 1)), charged


def groups_of(machine: Machine, kind: type) -> list[DeviceGroup]:
    """Return the groups of devices of a kind."""
    return [g for g in machine.flat.groups if isinstance(g.device, kind)]


def _ends(machine: Machine, groups: Sequence[DeviceGroup], pair: tuple[int, int]) -> I64:
    """Columns of two terminals of all devices of some groups, int64[2, devices]."""
    found = [machine.column[group.nodes[list(pair)]] for group in groups]
    return np.concatenate([np.zeros((2, 0), np.int64), *found], axis=1)
