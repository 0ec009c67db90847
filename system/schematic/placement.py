"""Where the parts of a schematic stand: a column and a row each. A pure function of the parts.

Rows are layers of the path of current: a part stands below what feeds it, pFETs as near to the supply as that
allows, all others as near to ground. A column is a branch, in which current flows straight down. Pairs (two
transistors of one source, with gates of their own) and mirrors (of one gate, one of them a diode) stand side
by side; else branches go from the inputs at the left to the outputs at the right.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations, pairwise

import networkx as nx

from system.schematic.part import Part, Rails

WIDEST = 12
"""Columns beyond which a schematic goes on in another band below; ours."""
_BAND, _TORN, _NARROW = 3, 8, 32  # what bands cost, in nets cut; ours


@dataclass(frozen=True, slots=True)
class Place:
    """Where a part stands: its band from the top, its column and row there, and whether its gate is right."""

    band: int
    column: int
    row: int
    flipped: bool = False


def place(parts: Sequence[Part], rails: Rails, inputs: Iterable[str]) -> tuple[Place, ...]:
    """Place of each part; inputs: nets from which signals come.

    A capacitor stands beside the branch whose net it holds.
    """
    fixed = rails.high | rails.low
    rows = _rows(parts, fixed)
    branches = _branches(parts, rows, fixed)
    distance = _distances(parts, fixed, inputs)
    order = _order(parts, branches, rows, distance, fixed)
    order = _with_capacitors(parts, order, rows, fixed)
    return _bands(parts, order, rows, fixed)


def pairs(parts: Sequence[Part], fixed: Iterable[str]) -> dict[tuple[int, int], str]:
    """Pairs of transistors that are a `pair` or a `mirror`, by their places in `parts`.

    fixed: the rails. In a mirror the one with the diode comes first.
    """
    found: dict[tuple[int, int], str] = {}
    rails = set(fixed)
    for i, j in combinations(range(len(parts)), 2):
        a, b = parts[i], parts[j]
        if not (a.is_transistor and a.kind == b.kind):
            continue
        if a.left == b.left and a.is_diode != b.is_diode and a.source == b.source:
            found[(i, j) if a.is_diode else (j, i)] = "mirror"
        elif a.left != b.left and a.source == b.source and a.source not in rails and a.drain != b.drain:
            found[i, j] = "pair"
    return found


def _rows(parts: Sequence[Part], fixed: frozenset[str]) -> list[int]:
    """Rows from 0 at the supply, by the longest ways of current above and below each part."""
    graph = _flow(parts, fixed)
    up, down = _depths(graph), _depths(graph.reverse())
    last = max((up[k] + down[k] for k in graph), default=0)
    rows = [
        up[k] if k in graph and parts[k].kind == "pfet" else last - down.get(k, 0) for k in range(len(parts))
    ]
    while wrong := [a for a, b in graph.edges if rows[a] >= rows[b] and rows[a] != up[a]]:
        rows[wrong[0]] = up[wrong[0]]
    while wrong := [b for a, b in graph.edges if rows[a] >= rows[b]]:
        rows[wrong[0]] = max(rows[a] + 1 for a in graph.predecessors(wrong[0]))
    return rows


def _flow(parts: Sequence[Part], fixed: frozenset[str]) -> nx.DiGraph:
    """Edges from each part to those that its current may flow on to, without circles; capacitors apart."""
    graph = nx.DiGraph()
    conducting = [k for k, part in enumerate(parts) if part.kind != "capacitor"]
    graph.add_nodes_from(conducting)
    for a in conducting:
        for b in conducting:
            joined = parts[a].bottom == parts[b].top and parts[a].bottom not in fixed
            if a != b and joined and not nx.has_path(graph, b, a):
                graph.add_edge(a, b)
    return graph


def _depths(graph: nx.DiGraph) -> dict[int, int]:
    depth: dict[int, int] = {}
    for k in nx.topological_sort(graph):
        depth[k] = max((depth[p] + 1 for p in graph.predecessors(k)), default=0)
    return depth


def _branches(parts: Sequence[Part], rows: Sequence[int], fixed: frozenset[str]) -> list[list[int]]:
    """Parts in columns: each goes below the nearest above it that has nothing below yet."""
    columns: list[list[int]] = []
    conducting = [k for k, part in enumerate(parts) if part.kind != "capacitor"]
    for k in sorted(conducting, key=lambda k: (rows[k], k)):
        top = parts[k].top
        above = [c for c in columns if parts[c[-1]].bottom == top and rows[c[-1]] < rows[k]]
        if top in fixed or not above:
            columns.append([k])
        else:
            max(above, key=lambda c: rows[c[-1]]).append(k)
    return columns


def _distances(parts: Sequence[Part], fixed: frozenset[str], inputs: Iterable[str]) -> dict[str, int]:
    """How many gates or channels a net is from the nearest input."""
    graph = nx.DiGraph()
    for part in parts:
        graph.add_nodes_from(_nets(part))
        ends = [n for n in (part.top, part.bottom, *part.right) if n not in fixed]
        graph.add_edges_from((a, b) for a in (*part.left, *ends) if a not in fixed for b in ends)
    starts = {n for n in inputs if n in graph}
    if not starts:
        return {}
    return dict(nx.multi_source_dijkstra_path_length(graph, starts))


def _order(
    parts: Sequence[Part],
    branches: list[list[int]],
    rows: Sequence[int],
    distance: Mapping[str, int],
    fixed: frozenset[str],
) -> list[list[int]]:
    """Branches from left to right: what belongs side by side first, then by distance from the inputs."""
    where = {k: c for c, branch in enumerate(branches) for k in branch}
    links: dict[tuple[int, int], float] = {}

    def link(i: int, j: int, weight: float) -> None:
        a, b = sorted((where[i], where[j]))
        if a != b:
            links[a, b] = links.get((a, b), 0.0) + weight

    for (i, j), kind in pairs(parts, fixed).items():
        if rows[i] == rows[j]:
            link(i, j, 100.0 if kind == "pair" else 30.0)
    for i, j in combinations(where, 2):
        nets = {parts[i].top, parts[i].bottom} & {parts[j].top, parts[j].bottom}
        driven = {*parts[i].left} & {parts[j].top, parts[j].bottom} | {*parts[j].left} & {
            parts[i].top,
            parts[i].bottom,
        }
        link(i, j, 2.0 * len(nets - fixed) + len(driven - fixed))
    far = 1 + max(distance.values(), default=0)
    keys = [_key(parts, branch, distance, far) for branch in branches]
    drives = [_drives(parts, branch, fixed) for branch in branches]
    return [branches[c] for line in _lines(links, keys, drives) for c in line]


def _drives(
    parts: Sequence[Part], branch: list[int], fixed: frozenset[str]
) -> tuple[frozenset[str], frozenset[str]]:
    """Nets that a branch has at its sides' inputs, and nets that its current flows through."""
    inputs = frozenset(n for k in branch for n in parts[k].left) - fixed
    ends = frozenset(n for k in branch for n in (parts[k].top, parts[k].bottom, *parts[k].right)) - fixed
    return inputs - ends, ends


def _key(parts: Sequence[Part], branch: list[int], distance: Mapping[str, int], far: int) -> float:
    nets = [n for k in branch for n in (*parts[k].left, parts[k].top, parts[k].bottom) if n in distance]
    return sum(distance[n] for n in nets) / len(nets) if nets else float(far)


def _lines(
    links: Mapping[tuple[int, int], float],
    keys: Sequence[float],
    drives: Sequence[tuple[frozenset[str], frozenset[str]]],
) -> list[list[int]]:
    """Join branches to lines, the strongest link first, and order the lines by the keys.

    A line is turned so that most branches drive the gates of those at their right, else by the keys.
    """

    def rightward(line: list[int]) -> tuple[int, float]:
        forth = sum(len(drives[a][1] & drives[b][0]) for a, b in pairwise(line))
        back = sum(len(drives[b][1] & drives[a][0]) for a, b in pairwise(line))
        return forth - back, keys[line[-1]] - keys[line[0]]

    lines = {c: [c] for c in range(len(keys))}  # by either end
    for (a, b), weight in sorted(links.items(), key=lambda link: (-link[1], link[0])):
        if weight <= 0.0 or a not in lines or b not in lines or lines[a] is lines[b]:
            continue
        left, right = lines.pop(a), lines.pop(b)
        left = left if left[-1] == a else left[::-1]
        right = right if right[0] == b else right[::-1]
        joined = left + right
        lines[joined[0]] = lines[joined[-1]] = joined
    found = [line for end, line in lines.items() if line[0] == end]
    turned = [line if rightward(line) >= rightward(line[::-1]) else line[::-1] for line in found]
    return sorted(turned, key=lambda line: (sum(keys[c] for c in line) / len(line), line))


def _with_capacitors(
    parts: Sequence[Part], order: list[list[int]], rows: list[int], fixed: frozenset[str]
) -> list[list[int]]:
    """Put each capacitor where a column has room for it, beside a branch that holds one of its nets."""
    columns = [list(branch) for branch in order]
    bound = {frozenset(pair) for pair in pairs(parts, fixed)}
    own: list[list[int]] = []  # columns that capacitors made
    for k, part in enumerate(parts):
        if part.kind != "capacitor":
            continue
        at, rows[k] = _beside(parts, columns, rows, part, fixed, bound)
        near = [column for column in columns[max(at - 1, 0) : at + 1] if column in own]
        free = [column for column in near if all(rows[k] != rows[j] for j in column)]
        if free:
            free[0].append(k)
        else:
            column = [k]
            own.append(column)
            columns.insert(at, column)
    return columns


def _beside(
    parts: Sequence[Part],
    columns: list[list[int]],
    rows: Sequence[int],
    part: Part,
    fixed: frozenset[str],
    bound: set[frozenset[int]],
) -> tuple[int, int]:
    """Where a capacitor's column goes, and its row: just below its upper net or above its lower one.

    It parts no pair and no mirror where there is another place.
    """
    last = max((rows[k] for column in columns for k in column), default=0)
    anchors = [(c, min(row, last)) for c, row in _anchors(parts, columns, rows, part, fixed)]
    for at, row in (*((c + 1, row) for c, row in anchors), *anchors):  # at the right, else at the left
        sides = columns[at - 1 : at + 1] if 0 < at < len(columns) else []
        if len(sides) < 2 or not any(frozenset((i, j)) in bound for i in sides[0] for j in sides[1]):
            return at, row
    return (anchors[0][0] + 1, anchors[0][1]) if anchors else (len(columns), last)


def _anchors(
    parts: Sequence[Part], columns: list[list[int]], rows: Sequence[int], part: Part, fixed: frozenset[str]
) -> Iterator[tuple[int, int]]:
    """Columns with a terminal of one of a capacitor's nets, and the row that puts it at the same height."""
    for net, step in ((part.top, 0), (part.bottom, -1)):
        for c, column in enumerate(columns):
            for k in sorted(column, key=lambda k: rows[k]) if net not in fixed else ():
                if parts[k].bottom == net:
                    yield c, max(rows[k] + 1 + step, 0)
                elif parts[k].top == net:
                    yield c, max(rows[k] + step, 0)
                elif net in parts[k].right:
                    yield c, rows[k]


def _cut(parts: Sequence[Part], order: list[list[int]], fixed: frozenset[str]) -> list[list[list[int]]]:
    """Cut the columns into bands of at most `WIDEST`, there where neighbours have least in common.

    A band costs `_BAND`, and the square of the columns that it lacks over `_NARROW`; a cut one a net that
    both sides have, and `_TORN` where it parts a pair or mirror.
    """
    bound = pairs(parts, fixed)

    def cost(at: int) -> int:
        if at == len(order):
            return 0
        left, right = order[at - 1], order[at]
        nets = ({n for k in column for n in _nets(parts[k])} - fixed for column in (left, right))
        torn = any((i, j) in bound or (j, i) in bound for i in left for j in right)
        return len(set.intersection(*nets)) + (_TORN if torn else 0)

    best: list[tuple[int, list[int]]] = [(0, [0])]  # to end a band after so many columns: cost, and the cuts
    for end in range(1, len(order) + 1):
        ways = (
            (best[start][0] + (WIDEST - end + start) ** 2 // _NARROW, best[start][1])
            for start in range(max(end - WIDEST, 0), end)
        )
        least, cuts = min(ways)
        best.append((least + _BAND + cost(end), [*cuts, end]))
    return [order[a:b] for a, b in pairwise(best[-1][1])]


def _nets(part: Part) -> tuple[str, ...]:
    return part.top, part.bottom, *part.left, *part.right


def _bands(
    parts: Sequence[Part], order: list[list[int]], rows: Sequence[int], fixed: frozenset[str]
) -> tuple[Place, ...]:
    """Number bands, columns and rows, and turn the gates of a mirror to each other, those of a pair apart."""
    found: dict[int, Place] = {}
    for band, inside in enumerate(_cut(parts, order, fixed)):
        used = sorted({rows[k] for column in inside for k in column})
        for c, column in enumerate(inside):
            found |= {k: Place(band, c, used.index(rows[k])) for k in column}
    for (i, j), kind in pairs(parts, fixed).items():
        left, right = sorted((i, j), key=lambda k: (found[k].band, found[k].column))
        a, b = found[left], found[right]
        if (a.band, a.row, a.column + 1) == (b.band, b.row, b.column) and not (a.flipped or b.flipped):
            turned = left if kind == "mirror" else right
            p = found[turned]
            found[turned] = Place(p.band, p.column, p.row, flipped=True)
    return tuple(found[k] for k in range(len(parts)))
