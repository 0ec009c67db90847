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
from chips.rolls.lumped.grid import edges, integral
from chips.rolls.lumped.network import pair as pair_shares
from chips.rolls.neuron.kernel import INJECTED, REVERSE, STATIC, Neurons, weak_share
from circuits.arrays import F64
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
    centres = 0.5 * (grid[1:] + grid[:-1])
    lines = np.zeros((n, rows - 1, LINE_COLUMNS))
    for k in range(n):
        for j, column in enumerate(columns):
            value, middle = np.interp(grid, zeta[k], column[k]), np.interp(centres, zeta[k], column[k])
            slope = np.diff(value) / np.diff(grid)
            # a chord is above what bends upwards: shifted to the same mean (Simpson)
            shift = 0.0 if column is v else (2.0 * middle - value[:-1] - value[1:]) / 3.0
            lines[k, :, 2 * j], lines[k, :, 2 * j + 1] = value[:-1] - slope * grid[:-1] + shift, slope
    return Lines(lines, unit, zeta[:, -1].copy(), _rise(columns[0], y, zeta, grid))


def with_reach(lines: F64, charge: F64, step: float) -> F64:
    """Return lines with how far each is taken, down and up, in steps of `step` s: zeta, its last two columns.

    Half a line behind its ends at least, and as far as the other lines differ from it by less than
    `LESS_SURE` of their distance in a step.
    """
    grid = edges(lines.shape[1])
    width, centre = np.diff(grid), 0.5 * (grid[1:] + grid[:-1])
    allowed = LESS_SURE * charge[:, None] / step
    found = lines.copy()
    for column, sign in ((REACH, -1), (REACH + 1, 1)):
        start = grid[:-1] if sign < 0 else grid[1:]
        reach = np.broadcast_to(start + 0.5 * sign * width, lines.shape[:2]).copy()
        sure = np.ones(lines.shape[:2], dtype=np.bool_)
        for far in range(1, FARTHEST + 1):
            own = np.arange(lines.shape[1])
            other = np.clip(own + sign * far, 0, own.size - 1)
            end = grid[other] if sign < 0 else grid[other + 1]
            off = np.zeros(lines.shape[:2])
            for at, by in ((OWN, 1.0), (BENT, _BENT_BY), (DRAWN, _DRAWN_BY)):
                less = lines[:, other, at : at + 2] - lines[:, :, at : at + 2]
                off += by * np.abs(less[:, :, 0] + less[:, :, 1] * end)
            sure &= (off <= allowed * np.abs(end - centre)) & (other == own + sign * far)
            reach = np.where(sure, end, reach)
        found[:, :, column] = reach
    return found


def _rise(own: F64, y: F64, zeta: F64, grid: F64) -> F64:
    """Lines of T_0 = int dy / a and of T_1 / T_0, T_1 = int dy / a^2, from zeta to the top."""
    n = own.shape[0]
    found = np.zeros((n, grid.size - 1, 4))
    for k in range(n):
        # below the last point that does not rise nothing is sure
        still = np.flatnonzero(own[k] <= 0.0)
        first = int(still[-1]) + 1 if still.size else 0
        at, a = y[k, first:], own[k, first:]
        for j, power in enumerate((1.0, 2.0)):
            left = integral(at[None, ::-1], a[None, ::-1] ** -power)[0, ::-1]
            value = np.interp(grid, zeta[k, first:], -left)
            found[k, :, 2 * j] = value[:-1]
            found[k, :, 2 * j + 1] = value[1:]
    low = np.where(found[:, :, 0::2] > 0.0, found[:, :, 0::2], 1e-30)
    high = np.where(found[:, :, 1::2] > 0.0, found[:, :, 1::2], 1e-30)
    for end in (low, high):
        end[:, :, 1] /= end[:, :, 0]
    slope = (high - low) / np.diff(grid)[None, :, None]
    found[:, :, 1::2], found[:, :, 0::2] = slope, low - slope * grid[None, :-1, None]
    return found


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
