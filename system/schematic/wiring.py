"""Which terminals of a schematic are joined by wires: a pure function of the parts and their places.

A wire goes straight down a column, straight from gate to gate of two neighbours, or across the corridor
between two rows. It is drawn where it spans few columns and meets no other net; what stays apart is joined by
name. The sides of a column count as thirds of one, so that the order of all verticals in a corridor is known.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import combinations, pairwise
from typing import NamedTuple

import networkx as nx

from system.schematic.part import Part
from system.schematic.placement import Place

_SIDE = 0.3  # columns from an axis to a terminal at the side
_SHORT = 2.5  # columns that a wire spans at most; ours
_TWO = 10.0  # points of each of two terminals at one side from the centre


class Pin(NamedTuple):
    """A terminal: place of its part, net, side (`top` to `right`), and points above the part's centre."""

    part: int
    net: str
    side: str
    rise: float = 0.0


class Joint(NamedTuple):
    """Where a pin can reach the middle of a corridor: the band, the row below it, the column or its side."""

    band: int
    corridor: int
    at: float
    pin: Pin


@dataclass(slots=True)
class Wiring:
    """What is joined.

    joined : pins, and an edge between each two that a wire joins directly.
    columns : wires down a column, from the bottom of a part to the top of the next.
    facing : wires from gate to gate.
    inverters : wires from the gate of a pFET down to that of the nFET on whose drain its own is.
    across : wires in corridors.
    """

    joined: nx.Graph = field(default_factory=nx.Graph)
    columns: list[tuple[Pin, Pin]] = field(default_factory=list)
    facing: list[tuple[Pin, Pin]] = field(default_factory=list)
    inverters: list[tuple[Pin, Pin]] = field(default_factory=list)
    across: list[tuple[Joint, Joint]] = field(default_factory=list)


def pins_of(k: int, part: Part, *, flipped: bool) -> list[Pin]:
    """Terminals of part number `k`."""
    sides = {"left": part.right, "right": part.left} if flipped else {"left": part.left, "right": part.right}
    pins = [Pin(k, part.top, "top"), Pin(k, part.bottom, "bottom")]
    for side, nets in sides.items():
        rises = (0.0,) if len(nets) == 1 else (_TWO, -_TWO)
        pins += [Pin(k, net, side, rise) for net, rise in zip(nets, rises, strict=False)]
    return pins


def wire(parts: Sequence[Part], places: Sequence[Place], fixed: frozenset[str]) -> Wiring:
    """Join what can be joined; fixed: the rails, which are drawn at each terminal instead."""
    found = Wiring()
    pins = [p for k, part in enumerate(parts) for p in pins_of(k, part, flipped=places[k].flipped)]
    found.joined.add_nodes_from(pins)
    free = [pin for pin in pins if pin.net not in fixed]
    by_part: dict[int, list[Pin]] = {}
    for pin in free:
        by_part.setdefault(pin.part, []).append(pin)
    for k, own in by_part.items():  # a diode's gate and drain
        ends = [p for p in own if p.side in {"top", "bottom"}]
        sides = [p for p in own if p not in ends]
        found.joined.add_edges_from(
            (a, b)
            for a in ends
            for b in sides
            if a.net == b.net and parts[k].is_transistor and _drains(parts[k], a)
        )
    found.columns = list(_down(places, by_part))
    found.joined.add_edges_from(found.columns)
    found.facing = list(_facing(parts, places, free))
    found.joined.add_edges_from(found.facing)
    found.inverters = list(_inverters(parts, places, found.columns, by_part))
    found.joined.add_edges_from(found.inverters)
    hung = [Joint(places[p.part].band, _corridor(places, p), places[p.part].column, p) for p in pins
            if p.net in fixed and p.side in {"top", "bottom"}]  # fmt: skip
    _cross(found, _joints(parts, places, free, (*found.columns, *found.inverters)), hung)
    return found


def groups(wiring: Wiring, fixed: Iterable[str]) -> list[list[Pin]]:
    """Terminals that wires join, each group in a fixed order; without rails."""
    rails = set(fixed)
    found = (sorted(group) for group in nx.connected_components(wiring.joined))
    return sorted(group for group in found if group[0].net not in rails)


def _drains(part: Part, end: Pin) -> bool:
    return (end.side == "bottom") == part.source_up


def _down(places: Sequence[Place], by_part: dict[int, list[Pin]]) -> Iterator[tuple[Pin, Pin]]:
    order = sorted(range(len(places)), key=lambda k: (places[k].band, places[k].column, places[k].row))
    for a, b in pairwise(order):
        if (places[a].band, places[a].column) != (places[b].band, places[b].column):
            continue
        lower = [p for p in by_part.get(a, ()) if p.side == "bottom"]
        upper = [p for p in by_part.get(b, ()) if p.side == "top"]
        if lower and upper and lower[0].net == upper[0].net:
            yield lower[0], upper[0]


def _facing(parts: Sequence[Part], places: Sequence[Place], pins: list[Pin]) -> Iterator[tuple[Pin, Pin]]:
    gates = {
        (places[p.part].band, places[p.part].row, places[p.part].column): p
        for p in pins
        if parts[p.part].is_transistor and p.side in {"left", "right"}
    }
    for (band, row, column), a in gates.items():
        b = gates.get((band, row, column + 1))
        if b is not None and a.side == "right" and b.side == "left" and a.net == b.net:
            yield a, b


def _inverters(
    parts: Sequence[Part],
    places: Sequence[Place],
    columns: list[tuple[Pin, Pin]],
    by_part: dict[int, list[Pin]],
) -> Iterator[tuple[Pin, Pin]]:
    for upper, lower in columns:
        kinds = parts[upper.part].kind, parts[lower.part].kind
        gates = [[p for p in by_part[k.part] if p.side == "left"] for k in (upper, lower)]
        if kinds == ("pfet", "nfet") and all(gates) and gates[0][0].net == gates[1][0].net:
            yield gates[0][0], gates[1][0]


def _corridor(places: Sequence[Place], pin: Pin) -> int:
    """Corridor at the end of a part: its number is that of the row below it."""
    return places[pin.part].row + (pin.side == "bottom")


def _joints(
    parts: Sequence[Part], places: Sequence[Place], pins: list[Pin], downward: Sequence[tuple[Pin, Pin]]
) -> list[Joint]:
    """Where each pin reaches a corridor: ends at their own and down their column, gates at the left two."""
    found = []
    for pin in pins:
        place = places[pin.part]
        if pin.side == "left" and parts[pin.part].is_transistor:
            found += [Joint(place.band, place.row + d, place.column - _SIDE, pin) for d in (0, 1)]
        elif pin.side in {"top", "bottom"}:
            found.append(Joint(place.band, _corridor(places, pin), place.column, pin))
    for a, b in downward:
        p = places[a.part]
        at = p.column - (_SIDE if a.side == "left" else 0.0)
        found += [Joint(p.band, r, at, a) for r in range(p.row + 2, places[b.part].row + 1)]
    return found


def _cross(found: Wiring, joints: list[Joint], hung: list[Joint]) -> None:
    """Add wires in corridors, the shortest first; none crosses another net or a rail that hangs there."""
    taken: dict[tuple[int, int], list[tuple[float, float, str]]] = {}
    down = {pin for pair in found.columns for pin in pair}
    lowest = {b: max(j.corridor for j in joints if j.pin == b) - 1 for _, b in found.inverters}
    highest = {a: min(j.corridor for j in joints if j.pin == a) + 1 for a, _ in found.inverters}
    for j in (*joints, *hung):
        tied = j.corridor == lowest.get(j.pin) or j.corridor >= highest.get(j.pin, j.corridor + 1)
        if j.pin in down or tied or j in hung:
            taken.setdefault((j.band, j.corridor), []).append((j.at, j.at, j.pin.net))
    by_net: dict[tuple[int, int, str], list[Joint]] = {}
    for joint in joints:
        by_net.setdefault((joint.band, joint.corridor, joint.pin.net), []).append(joint)
    candidates = [
        (abs(b.at - a.at), a, b) if a.at <= b.at else (abs(b.at - a.at), b, a)
        for near in by_net.values()
        for a, b in combinations(near, 2)
    ]
    for span, a, b in sorted(candidates):
        others = taken.setdefault((a.band, a.corridor), [])
        met = any(net != a.pin.net and low <= b.at and a.at <= high for low, high, net in others)
        if span <= _SHORT and not met and not nx.has_path(found.joined, a.pin, b.pin):
            found.across.append((a, b))
            found.joined.add_edge(a.pin, b.pin)
            others.append((a.at, b.at, a.pin.net))
