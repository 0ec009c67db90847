"""Neurons of a ROLLS chip, lumped for its steps: tables over v_mem become straight lines over zeta.

From the tables of `chips.rolls.neuron.model`, by a change of variable alone: `y = int C(v) / share(v) dv`,
share being that of weak inversion.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from chips.rolls.layout import BENT, DRAWN, LINE_COLUMNS, OCTAVE_BITS, REACH
from chips.rolls.layout import STATIC as OWN
from chips.rolls.lumped.grid import edges, integral, interpolated
from chips.rolls.lumped.network import pair as pair_shares
from chips.rolls.neuron.kernel import INJECTED, REVERSE, STATIC, Neurons, weak_share
from circuits.arrays import F64, I64
from circuits.compiled import compiled
from circuits.devices.ekv import weak_over

REFERENCE_INPUT = 1e-9  # A, ours: at which the share's correction for strong inversion is taken
LESS_SURE = 0.1  # by which a line's slope may be off times the step, where it is taken beyond its end; ours
FARTHEST = 16  # lines behind its end up to which a line may be taken; ours
_BENT_BY, _DRAWN_BY = 0.1e-9, 0.3e-9  # A, ours: of an input and an inhibition for which that is looked at


class Lines(NamedTuple):
    """Neurons over zeta: their lines, the charge Q_0 of zeta (C), and zeta where they spike.

    lines: float64[n, rows, LINE_COLUMNS]; charge, top: float64[n]; rise: time left to the top.
    """

    lines: F64
    charge: F64
    top: F64
    rise: F64  # float64[n, rows, 4]: time left to the top, s, and what a drive takes off it, 1/A


def lines_of(m: Neurons) -> Lines:
    """Return the tables of `chips.rolls.neuron.model` over v_mem, as lines over zeta."""
    n, points = m.table.shape[:2]
    share = weak_share(m)
    v = np.linspace(0.0, 1.0, points)[None, :] * m.top[:, None]
    c = m.capacitance[:, None] + share * (m.input_linear[:, None] + share * m.input_square[:, None])
    y = integral(v, c / share)
    unit = m.capacitance * m.u_t / m.kappa_p
    zeta = 1.0 + y / unit[:, None]
    bend, injected = _bend(m, share), m.table[:, :, INJECTED]
    strong = weak_over(injected / m.ground_current[:, None]) - 1.0
    columns = (
        m.table[:, :, STATIC] / share + injected * (1.0 + bend * strong),
        bend,
        m.table[:, :, REVERSE] / share,
        v,
    )
    rows = (int(math.frexp(float(zeta[:, -1].max()))[1]) << OCTAVE_BITS) + 1
    grid = edges(rows - 1)
    lines = np.zeros((n, rows - 1, LINE_COLUMNS))
    for j, column in enumerate(columns):
        _chords(zeta, column, grid, column is not v, lines[:, :, 2 * j : 2 * j + 2])
    return Lines(lines, unit, zeta[:, -1].copy(), _rise(columns[0], y, zeta, grid))


@compiled(_nrt=True)
def _chords(zeta: F64, column: F64, grid: F64, shifted: bool, lines: F64) -> None:  # noqa: FBT001 - a kernel's
    """Fill `lines` with the chords of a column over zeta: intercept and slope, float64[n, rows, 2].

    shifted: whether each is put to the column's mean along it (Simpson): a chord is above what bends upwards.
    """
    centres = 0.5 * (grid[1:] + grid[:-1])
    value, middle = np.empty(grid.size), np.empty(centres.size)
    for k in range(zeta.shape[0]):
        interpolated(grid, zeta[k], column[k], value)
        interpolated(centres, zeta[k], column[k], middle)
        for i in range(centres.size):
            slope = (value[i + 1] - value[i]) / (grid[i + 1] - grid[i])
            shift = (2.0 * middle[i] - value[i] - value[i + 1]) / 3.0 if shifted else 0.0
            lines[k, i, 0], lines[k, i, 1] = value[i] - slope * grid[i] + shift, slope


def with_reach(lines: F64, charge: F64, step: float) -> F64:
    """Return lines with how far each is taken, down and up, in steps of `step` s: zeta, its last two columns.

    Half a line behind its ends at least, and as far as the other lines differ from it by less than
    `LESS_SURE` of their distance in a step.
    """
    found = lines.copy()
    _reach(edges(lines.shape[1]), LESS_SURE * charge / step, found)
    return found


@compiled()
def _reach(grid: F64, allowed: F64, lines: F64) -> None:
    """Fill the last two columns of lines; allowed: by how much a slope may be off, A, float64[n]."""
    count = lines.shape[1]
    for k in range(lines.shape[0]):
        for own in range(count):
            width, centre = grid[own + 1] - grid[own], 0.5 * (grid[own + 1] + grid[own])
            for column, sign in ((REACH, -1), (REACH + 1, 1)):
                reach = (grid[own] if sign < 0 else grid[own + 1]) + 0.5 * sign * width
                for far in range(1, FARTHEST + 1):
                    other = own + sign * far
                    if not 0 <= other < count:
                        break
                    end = grid[other] if sign < 0 else grid[other + 1]
                    if not _apart(lines[k, other], lines[k, own], end) <= allowed[k] * abs(end - centre):
                        break
                    reach = end
                lines[k, own, column] = reach


@compiled(forceinline=True)
def _apart(other: F64, own: F64, zeta: float) -> float:
    """By how much two lines of a neuron differ at zeta, A, static, bent and drawn together."""
    off = abs((other[OWN] - own[OWN]) + (other[OWN + 1] - own[OWN + 1]) * zeta)
    off += _BENT_BY * abs((other[BENT] - own[BENT]) + (other[BENT + 1] - own[BENT + 1]) * zeta)
    off += _DRAWN_BY * abs((other[DRAWN] - own[DRAWN]) + (other[DRAWN + 1] - own[DRAWN + 1]) * zeta)
    return float(off)


def _rise(own: F64, y: F64, zeta: F64, grid: F64) -> F64:
    """Lines of T_0 = int dy / a and of T_1 / T_0, T_1 = int dy / a^2, from zeta to the top."""
    # below the last point that does not rise nothing is sure
    first = np.array([int(np.flatnonzero(a <= 0.0).max(initial=-1)) + 1 for a in own])
    density = np.ones((2, *own.shape))
    for k, begin in enumerate(first):
        # a row at a time: the last bit of numpy's powers hangs on how many there are
        for j, power in enumerate((-1.0, -2.0)):
            density[j, k, begin:] = (own[k, begin:][None, ::-1] ** power)[0, ::-1]
    found = np.zeros((own.shape[0], grid.size - 1, 4))
    for j in range(2):
        left = -integral(y[:, ::-1], density[j, :, ::-1])[:, ::-1]
        _ends(zeta, left, first, grid, found[:, :, 2 * j : 2 * j + 2])
    low = np.where(found[:, :, 0::2] > 0.0, found[:, :, 0::2], 1e-30)
    high = np.where(found[:, :, 1::2] > 0.0, found[:, :, 1::2], 1e-30)
    for end in (low, high):
        end[:, :, 1] /= end[:, :, 0]
    slope = (high - low) / np.diff(grid)[None, :, None]
    found[:, :, 1::2], found[:, :, 0::2] = slope, low - slope * grid[None, :-1, None]
    return found


@compiled(_nrt=True)
def _ends(zeta: F64, left: F64, first: I64, grid: F64, ends: F64) -> None:
    """Fill `ends` with `left` at both ends of each line, float64[n, rows, 2]; first: point that counts."""
    value = np.empty(grid.size)
    for k in range(zeta.shape[0]):
        interpolated(grid, zeta[k, first[k] :], left[k, first[k] :], value)
        for i in range(grid.size - 1):
            ends[k, i, 0], ends[k, i, 1] = value[i], value[i + 1]


def _bend(m: Neurons, share: F64) -> F64:
    """w: how much of the correction for strong inversion the share of the reference input needs."""
    n, points = share.shape
    exact = np.empty(n * points)
    pair_shares(
        np.repeat(m.ground_current, points), np.repeat(m.ground_pinch, points),
        np.repeat(m.membrane_current, points), m.inside.ravel(), np.full(n * points, REFERENCE_INPUT), exact,
    )  # fmt: skip
    more = exact.reshape(n, points) / (REFERENCE_INPUT * share) - 1.0
    return np.asarray(more / (weak_over(REFERENCE_INPUT / m.ground_current)[:, None] - 1.0))
