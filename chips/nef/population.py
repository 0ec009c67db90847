"""An ensemble on tuning curves: encoders, gains and biases of its neurons, and decoders of functions.

Decoders of a function f are those of Stöckel 2017, section II.B, regularised least squares over points x:

    D = (A'A + m sigma^2 I)^-1 A' F,    sigma = regularisation max(A),

with rates A, float64[m, neurons], and values F, float64[m, results]. Encoders, rates, intercepts and points
are drawn from the seed and the ensemble's name, so that a change elsewhere in a network changes none of them.
"""

from __future__ import annotations

import zlib
from dataclasses import dataclass

import numpy as np

from chips.nef.calibration import USUAL, WINDOW
from chips.nef.chip import HEADROOM, Conditions
from chips.nef.network.curves import Curves
from chips.nef.network.network import Ensemble, Function
from chips.nef.network.solve import factor, gram, moment, solve
from chips.nef.whole.rate import count_spikes
from circuits.arrays import F64
from circuits.errors import ParameterError

FEWEST_POINTS = 1000  # where functions are fitted; ours
POINTS_A_NEURON = 2  # if these are more; ours


@dataclass(frozen=True, slots=True, eq=False)
class Population:
    """An ensemble whose first neuron has the number `first`, and whose vector's first line is `line`.

    tau: longest time constant of what brings the vector, s; gain, bias: currents, float64[n]; encoders: unit
    vectors, float64[n, d]; points: float64[m, d]; rates: at the points, Hz, float64[m, n]. On a chip gain and
    bias are what its codes are chosen for, and the rates what was measured with them.
    """

    ensemble: Ensemble
    first: int
    line: int
    tau: float
    gain: F64
    bias: F64
    encoders: F64
    points: F64
    rates: F64

    def factor(self, regularisation: float) -> F64:
        """Return the lower triangle of `A'A + m sigma^2 I`, which all its decoders share."""
        sigma = regularisation * max(float(self.rates.max()), 1.0)
        matrix = gram(self.rates)
        matrix[np.diag_indices_from(matrix)] += len(self.points) * sigma**2
        return factor(matrix)

    def decoders(self, values: F64, lower: F64) -> F64:
        """Return decoders, value a Hz, float64[n, k], of values at the points, float64[m, k].

        lower: `factor` of the regularisation.
        """
        return solve(lower, moment(self.rates, values))


def populate(
    ensemble: Ensemble, curves: Curves, first: int, seed: int, points: F64 | None = None, line: int = 0,
    tau: float = USUAL,
) -> Population:  # fmt: skip
    """Put an ensemble on the curves of neurons from `first` on.

    points: instead of drawn ones; line: of a chip, the first of those that bring the vector, through
    filters of which the slowest has `tau`, s. Raises `ParameterError` where a neuron cannot fire at the
    rate that is asked for.
    """
    n, d = ensemble.neurons, ensemble.dimensions
    random = np.random.default_rng((seed, zlib.crc32(ensemble.name.encode())))
    drawn = ensemble.drawn
    if drawn is None:
        rate = random.uniform(*ensemble.max_rates, n)
        intercept = random.uniform(*ensemble.intercepts, n)
        encoders = _encoders(ensemble, random)
    else:
        rate, intercept, encoders = drawn.rate, drawn.intercept, drawn.encoders
        points = drawn.points if points is None else points
    threshold, most = curves.currents(first, np.zeros(n)), curves.currents(first, rate)
    wrong = ~(most > threshold)
    if wrong.any():
        raise ParameterError(
            f"{ensemble.name}.max_rates: {rate[wrong][0]:.4g} Hz, neuron {first + int(np.argmax(wrong))}"
            " cannot fire so fast; ask for less"
        )
    gain = (most - threshold) / (1.0 - intercept)
    if isinstance(curves, Conditions):
        gain = np.minimum(gain, curves.highest_gain(HEADROOM))  # the rate at the radius is then less
    bias = threshold - gain * intercept
    many = max(FEWEST_POINTS, POINTS_A_NEURON * n)
    x = _ball(random, many, d, ensemble.radius) if points is None else points
    rows = (encoders * (gain / ensemble.radius)[:, None]).T
    if isinstance(curves, Conditions):
        rates = _measured(ensemble, curves, first, (line, tau), x, rows, bias, random)
    else:
        rates = curves.rates(first, np.einsum("md,dn->mn", x, rows) + bias)
    return Population(ensemble, first, line, tau, gain, bias, encoders, x, rates)


def _measured(
    ensemble: Ensemble,
    chip: Conditions,
    first: int,
    line: tuple[int, float],
    x: F64,
    rows: F64,
    bias: F64,
    random: np.random.Generator,
) -> F64:
    """Rates of a chip's neurons at points, as spikes counted for `WINDOW` s tell them.

    line: number of the first of those that bring the points, and their filters' time constant, s.
    """
    full = HEADROOM * ensemble.radius
    codes = [chip.codes(row, full, 1) for row in rows]
    standing = chip.standing(first, chip.bias_codes(bias), [column[0] for column in codes])
    given: list[F64] = []
    stages: list[F64] = []
    for d, column in enumerate(codes):
        given += chip.split(line[0] + d, x[:, d] / full, line[1])
        stages += chip.stage(first, 1 + d, column)
    rates = random.random((len(x), len(bias)))
    law, room = chip.law.own(slice(first, first + len(bias))), np.empty((3, len(bias)))
    count_spikes(law, np.stack(standing), np.stack(given, axis=1), np.stack(stages), WINDOW, room, rates)
    return rates


def evaluate(function: Function | None, points: F64, name: str) -> F64:
    """Return the values of a function at points, float64[m, d] -> float64[m, k], the points for None.

    Raises `ParameterError`, calling it `name`, where the shape is wrong or a value is not finite.
    """
    if function is None:
        return points
    values = np.asarray(function(points), dtype=float)
    if values.ndim != 2 or len(values) != len(points) or values.shape[1] < 1:
        raise ParameterError(
            f"{name}.function: shape {values.shape} of {points.shape}, must be ({len(points)}, results); it"
            " takes all points at once"
        )
    if not np.isfinite(values).all():
        at = points[np.argwhere(~np.isfinite(values))[0, 0]]
        raise ParameterError(
            f"{name}.function: not finite at {np.array2string(at, precision=3)}, must be finite in the radius"
        )
    return values


def _encoders(ensemble: Ensemble, random: np.random.Generator) -> F64:
    """Unit vectors, float64[n, d]."""
    n, d = ensemble.neurons, ensemble.dimensions
    drawn = random.normal(size=(n, d))
    given = np.asarray(ensemble.encoders, dtype=float)
    chosen = given[np.arange(n) % len(given)] if given.size else drawn
    return np.asarray(chosen / np.sqrt((chosen**2).sum(axis=1))[:, None])


def _ball(random: np.random.Generator, count: int, dimensions: int, radius: float) -> F64:
    """Points spread evenly in a ball, float64[count, dimensions]; in one dimension evenly spaced."""
    if dimensions == 1:
        return np.linspace(-radius, radius, count)[:, None]
    drawn = random.normal(size=(count, dimensions))
    length = radius * random.random(count) ** (1.0 / dimensions)
    return np.asarray(drawn * (length / np.sqrt((drawn**2).sum(axis=1)))[:, None])
