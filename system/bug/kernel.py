"""Compiled geometry of the Bug robot: ranges along rays, and a disc that slides along walls.

The paper (Stöckel 2017, III.A) stops a disc of radius r that moves along d towards a wall of direction o
where its centre is so far from the wall, along d,

    printed:    r (1 - |<d, o>| / (|d| |o|))^(-1/2)          d' = <d, o> o / |o|
    corrected:  r (1 - <d, o>^2 / (|d| |o|)^2)^(-1/2)        d' = <d, o> o / |o|^2

and goes on along d'. The disc touches the wall at r / sin of the angle between d and o, which is the second
form; the printed one stops it too early, by up to a factor of sqrt(2). The printed projection grows with the
length of o. Here the first contact of the moving disc is exact, corners included, where the paper sends three
parallel rays, which do not see a corner between them.
"""

from __future__ import annotations

import math

from circuits.arrays import F64
from circuits.compiled import compiled

_BOUNCES = 6  # walls that one step may slide along, one after the other; ours
_TINY = 1e-12
_compiled = compiled()


@_compiled
def look(pieces: F64, x: float, y: float, heading: float, rays: F64, longest: float, ranges: F64) -> None:
    """Fill `ranges` with the distance to the first piece along each ray, at most `longest`.

    pieces: float64[n, 4]; rays: float64[k], rad from the heading.
    """
    for k in range(rays.size):
        ux, uy = math.cos(heading + rays[k]), math.sin(heading + rays[k])
        best = longest
        for i in range(pieces.shape[0]):
            ax, ay = pieces[i, 0] - x, pieces[i, 1] - y
            ox, oy = pieces[i, 2] - pieces[i, 0], pieces[i, 3] - pieces[i, 1]
            cross = ux * oy - uy * ox
            if abs(cross) < _TINY:
                continue
            far = (ax * oy - ay * ox) / cross
            along = (ax * uy - ay * ux) / cross
            if 0.0 <= far < best and -_TINY <= along <= 1.0 + _TINY:
                best = far
        ranges[k] = best


@_compiled
def slide(pieces: F64, place: F64, dx: float, dy: float, radius: float, contact: F64) -> bool:
    """Move a disc by (dx, dy), along walls where they are in the way; whether it touched one.

    place: float64[2], overwritten; contact: float64[3], scratch. After a contact the rest of the way is
    projected on the outline, or at a corner on the tangent of the disc, as without friction.
    """
    touched = False
    for _ in range(_BOUNCES):
        if math.hypot(dx, dy) < _TINY:
            break
        contact[0] = 1.0
        hit = False
        for i in range(pieces.shape[0]):
            side = _meet_side(pieces[i], place, dx, dy, radius, contact)
            begin = _meet_corner(pieces[i, 0], pieces[i, 1], place, dx, dy, radius, contact)
            end = _meet_corner(pieces[i, 2], pieces[i, 3], place, dx, dy, radius, contact)
            hit = hit or side or begin or end
        done = contact[0]
        place[0] += done * dx
        place[1] += done * dy
        if not hit:
            break
        touched = True
        ox, oy = -contact[2], contact[1]
        rest = (1.0 - done) * (dx * ox + dy * oy)
        dx, dy = rest * ox, rest * oy
    return touched


@_compiled
def _meet_side(piece: F64, place: F64, dx: float, dy: float, radius: float, contact: F64) -> bool:
    """Update `contact` (share of the way, normal) if the disc's flank meets the piece earlier."""
    ox, oy = piece[2] - piece[0], piece[3] - piece[1]
    length = math.hypot(ox, oy)
    nx, ny = -oy / length, ox / length
    away = (place[0] - piece[0]) * nx + (place[1] - piece[1]) * ny
    if away < 0.0:
        nx, ny, away = -nx, -ny, -away
    closing = -(dx * nx + dy * ny)
    if closing <= _TINY:
        return False
    share = max((away - radius) / closing, 0.0)
    along = ((place[0] + share * dx - piece[0]) * ox + (place[1] + share * dy - piece[1]) * oy) / length**2
    if share < contact[0] and 0.0 <= along <= 1.0:
        contact[0], contact[1], contact[2] = share, nx, ny
        return True
    return False


@_compiled
def _meet_corner(cx: float, cy: float, place: F64, dx: float, dy: float, radius: float, contact: F64) -> bool:
    """Update `contact` if the disc meets the point (cx, cy) earlier."""
    px, py = place[0] - cx, place[1] - cy
    a, b, c = dx * dx + dy * dy, px * dx + py * dy, px * px + py * py - radius * radius
    root = b * b - a * c
    if b >= -_TINY or root <= 0.0:
        return False
    share = max((-b - math.sqrt(root)) / a, 0.0)
    if share < contact[0]:
        nx, ny = px + share * dx, py + share * dy
        length = math.hypot(nx, ny)
        contact[0], contact[1], contact[2] = share, nx / length, ny / length
        return True
    return False
