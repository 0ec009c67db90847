"""Compiled steps of a transient with noise: backward Euler on a grid of noise currents, refined by bridges.

Time is cut into equal grid steps d. In each, every white noise current stands still, drawn with variance
`S / 2d` (S one-sided), so that what it brings to a capacitor in a time t has the variance `S t / 2` whatever
d is; its band ends at 1 / 2d. Where the circuit moves fast, a stimulus bends or Newton's method fails, a step
is halved, and the current y of the whole becomes `y + z` and `y - z` in the halves, z drawn with the variance
of y: both are independent with twice the variance, as a Brownian bridge has it. So refining a step changes
neither the statistics nor what the coarser steps saw. S is taken at the state in which a step begins (Ito).
A node of time constant tau keeps `k T / C` but for a factor of `1 / (1 + d / 2 tau)`.
Flicker is a shift of each threshold, a sum of relaxations of rates lambda_j, each drawn exactly:
`x' = e^(-lambda d) x + sqrt(1 - e^(-2 lambda d)) xi`.

Draws: Philox words of (key of the noise current; grid step, block, level, part), turned into normals in pairs
by Box and Muller (1958). Block 0 is the white current's, level 0 for a grid step and level l + 1 for the
halving of part p of 2^l; the blocks from 1 on are the flicker's.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from circuits.arrays import F64, I64, U32, Bools
from circuits.compiled import compiled
from circuits.devices.diode import diode_currents
from circuits.devices.noise import channel_noise, diode_noise, junction_noise
from circuits.devices.transistor import drain_currents
from circuits.lowering.kernel import Kernel, Sources
from circuits.silicon.die import philox
from circuits.solver.integrate import (
    BUFFER_FULL,
    DONE,
    STEP_TOO_SMALL,
    Recorder,
    Scratch,
    next_breakpoint,
    source_values,
)
from circuits.solver.newton import Work, newton

DEEPEST = 24  # halvings of a grid step, of which a failing step is the last
DEEPEST_BEND = 10  # halvings for a bend of a stimulus inside a step
SMALL_ERROR, LARGE_ERROR = 6, 14  # halvings for an error above the tolerance, and above ten times that
ROOM = 4096  # accepted steps that a grid step may want to record
_SAME_TIME = 1e-13  # s
_NEWTON = 1e-6  # ours: relative, of the tolerance that Newton's method has
_PER_BLOCK = 4  # normals of a Philox block


class NoisePlan(NamedTuple):
    """Noise currents of a machine: n of them, first those of its m transistors' channels, then junctions.

    start, end: columns between which a current flows. white: densities, A^2/Hz; those of the transistors are
    filled in as the run goes on. amplitude: float64[m, r], V rms of each relaxation at each gate. keep:
    float64[r], the share that a grid step leaves of a relaxation. first: position of the columns that bring
    the currents to the unknown nodes. tolerance: float64[unknowns], V, error of a step that a node may have.
    """

    start: I64  # [n]
    end: I64  # [n]
    white: F64  # [n]
    amplitude: F64  # [m, r]
    keep: F64  # [r]
    first: int
    tolerance: F64


class GridSteps(NamedTuple):
    """The grid steps that one call advances over: from the beginning of `first` to that of `last`."""

    length: float  # s
    first: int
    last: int


class NoiseState(NamedTuple):
    """What a noisy run carries from call to call; flicker moves the thresholds in the kernel itself."""

    time: F64  # [1], s
    voltage: F64  # [columns]
    rate: F64  # [columns], V/s, over the last accepted step
    step: F64  # [1], s, that step
    relaxation: F64  # [m, r], unit normals
    threshold: F64  # [m], V, of the transistors without flicker
    armed: Bools  # [watched]
    counts: I64  # [3]: steps accepted, rejected, iterations


class Draws(NamedTuple):
    """Arrays for the random draws of one trial, with a column for each block of a noise current.

    The columns of block 0 come first.
    """

    keys: U32  # [2, blocks]
    counters: U32  # [4, blocks]
    words: U32  # [4, blocks]
    unit: F64  # [DEEPEST + 1, n], the currents of the present part of each level, over sqrt(S / 2d)
    other: F64  # [DEEPEST + 1, n], the same of the part that follows it


@compiled()
def normal_pair(first: int, second: int) -> tuple[float, float]:
    """Two standard normals from two 32-bit words."""
    radius = math.sqrt(-2.0 * math.log((first + 0.5) * 2.0**-32))
    angle = 2.0 * math.pi * (second + 0.5) * 2.0**-32
    return radius * math.cos(angle), radius * math.sin(angle)


@compiled()
def start_flicker(p: NoisePlan, x: NoiseState, d: Draws) -> None:
    """Draw the relaxations from their stationary distribution, by the counter of grid step 2^32 - 1."""
    d.counters[0, :] = np.uint32(0xFFFFFFFF)
    philox(d.keys, d.counters, d.words)
    for i in range(x.relaxation.shape[0]):
        for j in range(p.keep.size):
            x.relaxation[i, j] = _flicker_normal(p, d, i, j)


@compiled()
def _flicker_normal(p: NoisePlan, d: Draws, i: int, j: int) -> float:
    """Normal of relaxation j of transistor i from the present words."""
    blocks = (p.keep.size + _PER_BLOCK - 1) // _PER_BLOCK
    column = p.start.size + i * blocks + j // _PER_BLOCK
    pair = 2 * (j % _PER_BLOCK // 2)
    both = normal_pair(d.words[pair, column], d.words[pair + 1, column])
    return both[j % 2]


@compiled()
def _begin_grid_step(k: Kernel, p: NoisePlan, x: NoiseState, d: Draws, number: int) -> None:
    """Draw the currents of a grid step, and move thresholds by their flicker."""
    d.counters[0, :] = np.uint32(number)
    d.counters[2, :] = np.uint32(0)
    d.counters[3, :] = np.uint32(0)
    philox(d.keys, d.counters, d.words)
    for i in range(p.start.size):
        d.unit[0, i] = normal_pair(d.words[0, i], d.words[1, i])[0]
    for i in range(x.threshold.size if p.keep.size else 0):
        shift = 0.0
        for j in range(p.keep.size):
            kept = p.keep[j]
            fresh = math.sqrt(1.0 - kept * kept) * _flicker_normal(p, d, i, j)
            x.relaxation[i, j] = kept * x.relaxation[i, j] + fresh
            shift += p.amplitude[i, j] * x.relaxation[i, j]
        k.transistors.v_t0[i] = x.threshold[i] + shift


@compiled()
def _halve(p: NoisePlan, d: Draws, level: int, part: int) -> None:
    """Currents of both halves of a part, the first into `unit`, the second into `other`."""
    n = p.start.size
    d.counters[2, :n] = np.uint32(level + 1)
    d.counters[3, :n] = np.uint32(part)
    philox(d.keys[:, :n], d.counters[:, :n], d.words[:, :n])
    scale = 2.0 ** (0.5 * level)
    for i in range(n):
        z = scale * normal_pair(d.words[0, i], d.words[1, i])[0]
        d.unit[level + 1, i] = d.unit[level, i] + z
        d.other[level + 1, i] = d.unit[level, i] - z


@compiled()
def moving_densities(k: Kernel, w: Work, white: F64) -> None:
    """Write the densities that a state moves, as evaluated there, A^2/Hz: channels, junctions and diodes."""
    n = k.transistors.sign.size
    channel_noise(k.transistors, w.transistor, white[:n])
    after = n
    if k.transistors.leaks:
        junction_noise(k.transistors, w.transistor, white[n : 3 * n])
        after = 3 * n
    d = k.diodes.saturation.size
    if d > 0:
        diode_noise(w.diode_current[0], white[after : after + d])


@compiled()
def _densities(k: Kernel, p: NoisePlan, x: NoiseState, w: Work) -> None:
    """White densities of all channels and junctions at the present state."""
    drain_currents(k.transistors, x.voltage, w.transistor)
    if k.diodes.saturation.size > 0:
        diode_currents(k.diodes, x.voltage, w.diode_current, w.diode_slope)
    moving_densities(k, w, p.white)


@compiled()
def _bring(k: Kernel, p: NoisePlan, unit: F64, grid: float, v: F64) -> None:
    """Noise currents into the columns that bring them to the nodes."""
    for i in range(k.unknowns):
        v[p.first + i] = 0.0
    for i in range(p.start.size):
        current = math.sqrt(0.5 * p.white[i] / grid) * unit[i]
        if p.start[i] < k.unknowns:
            v[p.first + p.start[i]] -= current
        if p.end[i] < k.unknowns:
            v[p.first + p.end[i]] += current


@compiled()
def _detect(x: NoiseState, t_new: float, v: F64, r: Recorder) -> None:
    """Note upward crossings of the threshold between the last point and (t_new, v), by a straight line."""
    for j in range(r.watch.size):
        before, after = x.voltage[r.watch[j]], v[r.watch[j]]
        if x.armed[j] and after >= r.levels[0, j]:
            p = r.filled[1]
            share = (r.levels[0, j] - before) / (after - before)
            r.spike_time[p] = x.time[0] + share * (t_new - x.time[0])
            r.spike_index[p] = j
            r.filled[1] = p + 1
            x.armed[j] = False
        elif after < r.levels[1, j]:
            x.armed[j] = True


@compiled()
def _try_step(k: Kernel, p: NoisePlan, x: NoiseState, step: float, scratch: Scratch) -> float:
    """Backward Euler into `v`; returns the error over the tolerance, or inf where it does not converge."""
    v, guess, history = scratch.v, scratch.guess, scratch.history
    a = 1.0 / step
    for i in range(k.columns):
        history[i] = -a * x.voltage[i]
    ahead = min(step, x.step[0])
    for i in range(k.unknowns):
        guess[i] = x.voltage[i] + ahead * x.rate[i]
        v[i] = guess[i]
    iterations = newton(k, a, history, v, _NEWTON, scratch.work)
    x.counts[2] += abs(iterations)
    if iterations < 0:
        return np.inf
    error = 0.0
    for i in range(k.unknowns):
        if k.dynamic[i]:
            error = max(error, 0.5 * abs(v[i] - guess[i]) / p.tolerance[i])
    return error


@compiled()
def allowed_error(level: int) -> float:
    """Error, over the tolerance, with which a step of a level of halving is accepted.

    A step that fails to converge has an infinite error, which no level accepts.
    """
    return 1.0 if level < SMALL_ERROR else 10.0 if level < LARGE_ERROR else 1e300


@compiled()
def _accept(
    x: NoiseState, t_new: float, step: float, v: F64, unknowns: int, columns: int, r: Recorder
) -> None:
    for i in range(unknowns):
        x.rate[i] = (v[i] - x.voltage[i]) / step
    for i in range(columns):
        x.voltage[i] = v[i]
    x.time[0], x.step[0] = t_new, step
    x.counts[0] += 1
    q = r.filled[0]
    r.time[q] = t_new
    for j in range(r.columns.size):
        r.voltage[q, j] = v[r.columns[j]]
    r.filled[0] = q + 1


@compiled()
def advance_noisy(
    k: Kernel, s: Sources, p: NoisePlan, x: NoiseState, d: Draws, steps: GridSteps, r: Recorder,
    scratch: Scratch,
) -> int:  # fmt: skip
    """Advance over grid steps, or until the recorder is nearly full; returns how it ended.

    The kernel has one more column for each unknown node, from `p.first` on, and its thresholds are moved.
    """
    n, grid = k.unknowns, steps.length
    w, v, cursor = scratch.work, scratch.v, scratch.cursor
    for number in range(steps.first, steps.last):
        if r.filled[0] + ROOM > r.time.size or r.filled[1] + ROOM * r.watch.size > r.spike_time.size:
            return BUFFER_FULL
        _begin_grid_step(k, p, x, d, number)
        _densities(k, p, x, w)
        level, part, begin, taken = 0, 0, number * grid, r.filled[0]
        while level >= 0:
            step = grid * 2.0**-level
            t_new = begin + (part + 1) * step
            source_values(s, cursor, x.time[0], v, n)
            bends = next_breakpoint(s, cursor, x.time[0], t_new) < t_new - _SAME_TIME
            error = np.inf
            if not (bends and level < DEEPEST_BEND):
                source_values(s, cursor, t_new, v, n)
                v[p.first - 1] = 0.0
                _bring(k, p, d.unit[level], grid, v)
                error = _try_step(k, p, x, step, scratch)
            if error > allowed_error(level):
                x.counts[1] += 1
                if level == DEEPEST or r.filled[0] - taken >= ROOM - 1:
                    return STEP_TOO_SMALL
                _halve(p, d, level, part)
                level, part = level + 1, 2 * part
                continue
            _detect(x, t_new, v, r)
            _accept(x, t_new, step, v, n, p.first, r)
            while level > 0 and part % 2 == 1:
                level, part = level - 1, part // 2
            if level == 0:
                break
            part += 1
            for i in range(p.start.size):
                d.unit[level, i] = d.other[level, i]
            _densities(k, p, x, w)
    return DONE
