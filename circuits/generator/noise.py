"""Noise of the bias generator's lines: what each makes by itself, and what all get from the shared masters.

A line is slow, and so are the currents that it sets. Its gate's voltage has the density

    S(f) = white + flicker / f^AF,   flicker = sum_k (dV / dV_gk)^2 K_F / (m W L Cox)

over the devices of the line, with the slopes of its operating point; white noise is that of channels and
resistors. What lines share reaches them through the diode of their coarse current: lines of one coarse code
have that noise in common, those of others a part of it, by the core.

The line's decoupling capacitor and its own conductance let it follow up to a rate; what else hangs at the
line would take that lower.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from circuits.arrays import F64, I64
from circuits.devices.noise import NoiseModel, gate_flicker
from circuits.generator.ripple import DECOUPLING
from circuits.generator.solve import AtRest, Slopes, slopes_at
from circuits.generator.voltage import (
    RANGES,
    Line,
    coded,
    lines_at_rest,
    masters_at_rest,
    resistor_of,
)
from circuits.silicon.silicon import Silicon


@dataclass(frozen=True, slots=True)
class LineNoise:
    """Noise of lines' voltages.

    white : by each line's own devices, V^2/Hz, float64[lines].
    flicker : likewise at 1 Hz, V^2/Hz, float64[lines].
    coarse : code of each line's coarse current, int64[lines].
    by_coarse : by how much a line follows its coarse current's diode, V/V, float64[lines].
    rate : up to which a line follows, 1/s, float64[lines].
    """

    white: F64
    flicker: F64
    coarse: I64
    by_coarse: F64
    rate: F64


@dataclass(frozen=True, slots=True)
class SharedNoise:
    """Noise of the diodes of all coarse currents, which lines share.

    white : covariance of their voltages, V^2/Hz, float64[8, 8].
    flicker : likewise at 1 Hz, V^2/Hz, float64[8, 8].
    """

    white: F64
    flicker: F64


def line_noise(lines: Line, current: F64, silicon: Silicon, model: NoiseModel) -> LineNoise:
    """Noise of lines whose codes are nearest to currents, but for what they share.

    lines, current, silicon, and what it raises: as of `circuits.generator.voltage.line_voltages`; model:
    flicker noise of the devices.
    """
    codes, there = coded(current), replace(silicon, place=lines.place)
    rest = lines_at_rest(lines, codes, there, resistor_of(silicon.process))
    slopes = slopes_at(rest, there, lines.node)
    flicker = (slopes.by_gate**2 * _at_gates(rest, silicon, model)).sum(axis=1)
    coarse = np.array([c for c, _ in codes], np.int64)
    rate = 1.0 / (slopes.resistance * DECOUPLING)
    return LineNoise(slopes.white, flicker, coarse, slopes.by_given["range_n"], rate)


def shared_noise(lines: Line, silicon: Silicon, model: NoiseModel) -> SharedNoise:
    """Noise that all lines of a chip share; arguments as of `line_noise`."""
    return _shared(replace(silicon, place=lines.place), model)


@lru_cache(maxsize=256)
def _shared(there: Silicon, model: NoiseModel) -> SharedNoise:
    rest = masters_at_rest(there, resistor_of(there.process))
    each = [slopes_at(rest, there, name) for name in RANGES]
    by_gate = np.concatenate([s.by_gate for s in each])
    white = np.array([[_white_of(a, b) for b in each] for a in each])
    return SharedNoise(white, by_gate @ np.diag(_at_gates(rest, there, model)[0]) @ by_gate.T)


def _white_of(one: Slopes, other: Slopes) -> float:
    """Covariance of two nodes of the masters by white noise, V^2/Hz."""
    return float((one.by_current * other.by_current * one.sources).sum())


def _at_gates(rest: AtRest, silicon: Silicon, model: NoiseModel) -> F64:
    """Flicker at the gate of each transistor at 1 Hz, V^2/Hz, float64[copies, transistors]."""
    is_n = np.array([d.polarity == "n" for d in rest.network.transistors()])
    areas = rest.network.of_transistors("gate_area").T
    return gate_flicker(model, silicon.process, np.broadcast_to(is_n, areas.shape), areas)


def following(shared: F64, noise: LineNoise) -> F64:
    """What lines get from independent unit sources by a covariance of the coarse diodes.

    shared: float64[8, 8], V^2/Hz. The result is float64[lines, 8], V/Hz^0.5: its product with itself is the
    covariance of the lines.
    """
    scale, vectors = np.linalg.eigh(shared)
    root = vectors * np.sqrt(np.maximum(scale, 0.0))
    return np.asarray(noise.by_coarse[:, None] * root[noise.coarse])
