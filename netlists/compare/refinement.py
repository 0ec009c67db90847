"""Colour refinement of two circuits side by side: it tells devices and nodes apart by their surroundings.

Both circuits are one set of arrays. A node begins with a colour of its own if it is a port or ground; a
device begins with the colour of its kind. Then, again and again, a device takes in the colours of its nodes,
and a node those of its devices, until no further colour splits. Colours are 64-bit hashes; where order does
not count, hashes are summed.

Symmetry. A device has sides, each with some terminals; sides of one name may be swapped. So drain and source
of a transistor are alike, because its law and its capacitances are symmetric in them, as are the ends of a
resistor or capacitor; a controlled source may turn both its output and its control round together.
Source: Ebeling and Zajicek, "Validating VLSI circuit layout by wirelist comparison" (1983), for the method.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache, singledispatch

import numpy as np

from circuits.arrays import I64, U64
from circuits.devices import Capacitor, ControlledSource, OperationalAmplifier, Resistor, Source, Transistor
from circuits.devices.device import Device
from circuits.devices.diode import Diode

Sides = tuple[tuple[str, tuple[tuple[str, int], ...]], ...]  # ((side, ((role, terminal position), ...)), ...)

_ENDS: Sides = (("end", (("end", 0),)), ("end", (("end", 1),)))


@singledispatch
def sides(device: Device) -> Sides:
    """Sides of a device type with their terminals; sides of one name may be swapped."""
    raise TypeError(f"{type(device).__name__}: no sides for comparison")


@sides.register
def _(device: Transistor) -> Sides:
    ends: Sides = (("channel", (("channel", 0),)), ("channel", (("channel", 2),)))
    return (*ends, ("gate", (("gate", 1),)), ("bulk", (("bulk", 3),)))


@sides.register
def _(device: Capacitor) -> Sides:
    return _ENDS


@sides.register
def _(device: Resistor) -> Sides:
    return _ENDS


@sides.register
def _(device: Diode) -> Sides:
    return (("anode", (("anode", 0),)), ("cathode", (("cathode", 1),)))


@sides.register
def _(device: ControlledSource) -> Sides:
    return (("side", (("output", 0), ("control", 2))), ("side", (("output", 1), ("control", 3))))


@sides.register
def _(device: OperationalAmplifier) -> Sides:
    names = ("positive", "negative", "output", "vdd", "vss")
    return tuple((name, ((name, k),)) for k, name in enumerate(names))


@sides.register
def _(device: Source) -> Sides:
    return (("node", (("node", 0),)),)


@dataclass(frozen=True, slots=True)
class Structure:
    """Devices, sides, terminals and nodes of both circuits as arrays; sides and terminals in device order.

    terminal_side, terminal_node: int64[T]; terminal_role: uint64[T]; side_device: int64[S]; side_label:
    uint64[S]; device_kind: uint64[D]; node_label: uint64[N].
    """

    terminal_side: I64
    terminal_node: I64
    terminal_role: U64
    side_device: I64
    side_label: U64
    device_kind: U64
    node_label: U64


@dataclass(frozen=True, slots=True)
class Colours:
    """A colouring: uint64[D], uint64[S], uint64[N]."""

    device: U64
    side: U64
    node: U64


@cache
def label(text: str) -> int:
    """Hash of a word, the same in every run."""
    return int.from_bytes(hashlib.blake2b(text.encode(), digest_size=8).digest(), "little")


def labels(texts: Iterable[str]) -> U64:
    """Hashes of words, uint64[n]."""
    return np.array([label(text) for text in texts], dtype=np.uint64)


def mix(x: U64) -> U64:
    """Scatter 64-bit words: the finalizer of splitmix64."""
    x = (x ^ (x >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    x = (x ^ (x >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    scattered: U64 = x ^ (x >> np.uint64(31))
    return scattered


def first_colours(structure: Structure, device_label: U64) -> Colours:
    """Colours before anything is known of the surroundings."""
    return Colours(mix(structure.device_kind + mix(device_label)), structure.side_label, structure.node_label)


def refine(structure: Structure, old: Colours) -> Colours:
    """One round: sides take in their nodes, devices their sides, nodes their devices."""
    t, s = structure.terminal_side, structure.side_device
    seen = mix(structure.terminal_role + mix(old.node[structure.terminal_node]))
    side = mix(structure.side_label + _sums(seen, t, structure.side_label.size))
    device = mix(old.device + _sums(mix(side), s, old.device.size))
    back = mix(mix(structure.terminal_role + side[t]) + device[s[t]])
    node = mix(old.node + _sums(back, structure.terminal_node, old.node.size))
    return Colours(device, side, node)


def class_count(colours: Colours) -> int:
    """Number of different colours of devices and nodes."""
    return int(np.unique(colours.device).size + np.unique(colours.node).size)


def _sums(values: U64, owner: I64, count: int) -> U64:
    """Sum of the values of each owner, modulo 2^64; an owner may have none."""
    order = np.argsort(owner, kind="stable")
    running = np.concatenate([np.zeros(1, np.uint64), np.cumsum(values[order], dtype=np.uint64)])
    ends = np.searchsorted(owner[order], np.arange(count + 1))
    total: U64 = running[ends[1:]] - running[ends[:-1]]
    return total
