"""From three logarithmic envelopes to a direction, by a network of radial basis functions.

The middle transducer sends, all three hear. With the half-power width B of a beam in intensity, the amplitude
of a direct echo from the direction theta and the range r at the transducer that points to psi is

    a = b(theta) b(theta - psi) / r^2,    b(theta) = exp(-(ln 2 / 2) (2 theta / B)^2),    r in m,

in units of an echo from 1 m straight ahead. The Gaussian form is ours; B and the psi are the paper's. Its
voltage is `volts_per_decade` log10(a), noise included.

The network maps three voltages u to an angle: y = sum_i w_i exp(-|u - c_i|^2 / (2 width^2)), rounded to 1
degree. It is trained, by least squares, on the paper's 910 echoes: 91 angles (from -90 to 90 degrees, ours)
by 10 intensities (of ranges 0.25 to 1.5 m, ours). Which echoes are centres, width and ridge are ours.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from circuits.arrays import F64
from system.car.numbers import Robot
from system.worlds.sound.acoustics import beam

ANGLES, INTENSITIES = 91, 10  # the paper's
WIDEST = math.radians(90.0)  # of the training angles, to either side; ours
NEAREST, FARTHEST = 0.25, 1.5  # m, ranges of the training echoes; ours
CENTRES = 130  # of the training echoes, evenly spaced among them; ours
WIDTH = 0.35  # V, of a basis function; ours
_RIDGE = 1e-6  # of the least squares, relative to the number of echoes; ours
_OUTPUT_STEP = math.radians(1.0)  # the paper's
_TRAINING_SEED = 0  # of the training echoes' noise


class Localiser(NamedTuple):
    """A trained network.

    centres : float64[CENTRES, 3], V; weights : float64[CENTRES], rad.
    """

    centres: F64
    weights: F64


def hearing(robot: Robot, angle: F64) -> F64:
    """Amplitude at which each transducer hears from an angle (rad), float64[3, n]: left, middle, right."""
    axes = robot.squint * np.array([[1.0], [0.0], [-1.0]])
    return beam(angle[None, :] - axes, robot.beam)


def volts(robot: Robot, amplitude: F64) -> F64:
    """Voltage (V) of the logarithmic envelope."""
    return np.asarray(robot.volts_per_decade * np.log10(amplitude))


def training_echoes(robot: Robot) -> tuple[F64, F64]:
    """Voltages, float64[910, 3], and angles (rad) of the training echoes, with the envelope's noise."""
    random = np.random.default_rng(_TRAINING_SEED)
    angle, distance = (
        v.ravel()
        for v in np.meshgrid(
            np.linspace(-WIDEST, WIDEST, ANGLES),
            np.geomspace(NEAREST, FARTHEST, INTENSITIES),
            indexing="ij",
        )
    )
    amplitude = beam(angle, robot.beam) * hearing(robot, angle) / distance**2
    noise = robot.noise * random.standard_normal((2, *amplitude.shape))
    return volts(robot, np.hypot(amplitude + noise[0], noise[1])).T, angle


@lru_cache(maxsize=8)
def trained(robot: Robot) -> Localiser:
    """Return the network of a robot, trained on its echoes."""
    u, angle = training_echoes(robot)
    centres = u[np.linspace(0, len(u) - 1, CENTRES).astype(np.int64)]
    basis = _basis(u, centres)
    normal = basis.T @ basis + _RIDGE * len(u) * np.eye(CENTRES)
    return Localiser(centres, np.asarray(np.linalg.solve(normal, basis.T @ angle), dtype=np.float64))


def localise(network: Localiser, u: F64) -> F64:
    """Angles (rad, to the left of the head's axis, whole degrees) of voltages, float64[n, 3]."""
    angle = _basis(u, network.centres) @ network.weights
    return np.asarray(_OUTPUT_STEP * np.rint(angle / _OUTPUT_STEP))


def _basis(u: F64, centres: F64) -> F64:
    apart = ((u[:, None, :] - centres[None, :, :]) ** 2).sum(axis=2)
    return np.asarray(np.exp(-apart / (2.0 * WIDTH**2)))
