"""Tables and state of a ROLLS chip's depressed synapses, in the form that compiled code takes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from chips.noise_draw import Draws
from circuits.arrays import F32, F64, I32, I64

COEFFICIENTS = 4  # of a charge over the share of the weight's current


class DepressionTables(NamedTuple):
    """Synapses in the order of columns, then of neurons; the weight devices of a synapse follow each other.

    start: int64[columns + 1], first synapse of a column; post: int32[synapses]; slot: int32[pre, post],
    number of a synapse, -1 for none; first: int32[synapses + 1], first device of a synapse. float32 of
    devices: fall: step of the chip over tau; kept: e^(-d / U_T); scale: E at the mean x of a pulse that finds
    R = 1; bend: a quarter of the variance of kappa x / U_T in it; part: I_S over the level's current at rest.
    half: float32[1], kappa / 2; shape: float32[synapses, COEFFICIENTS], charge in z over the share.
    """

    start: I64
    post: I32
    slot: I32
    first: I32
    fall: F32
    kept: F32
    scale: F32
    bend: F32
    part: F32
    half: F32
    shape: F32


class DepressionNoise(NamedTuple):
    """Noise of the cells: draws for the devices of the largest column, and variances of R (see the kernel).

    diffuse: q / (C U_T), float32[1]; shot: n q d / (C U_T^2), float32[devices].
    """

    draws: Draws
    diffuse: F32
    shot: F32


class DepressionArrays(NamedTuple):
    """State: R behind each device's last pulse, float32[devices], and the step of it, int32[devices]."""

    resource: F32
    seen: I32


class DepressionScratch(NamedTuple):
    """Working space, as long as the largest column has devices; `_bits` are the same numbers as int32."""

    found: F32
    found_bits: I32
    mantissa: F32
    mantissa_bits: I32
    power: F32
    share: F32


def most_devices(tables: DepressionTables) -> int:
    """Return how many devices the largest column has."""
    return int(np.diff(tables.first[tables.start]).max())


def new_depression_scratch(tables: DepressionTables) -> DepressionScratch:
    """Return the working space for the largest column."""
    most = most_devices(tables)
    found, mantissa, power, share = np.zeros((4, most), np.float32)
    return DepressionScratch(found, found.view(np.int32), mantissa, mantissa.view(np.int32), power, share)


class Depressing(NamedTuple):
    """The depressed synapses of a chip in a call of its kernel."""

    tables: DepressionTables
    arrays: DepressionArrays
    scratch: DepressionScratch
    noise: DepressionNoise | None = None


@dataclass(frozen=True, slots=True)
class BuiltDepression:
    """Tables, and of each weight device its step (V) and its time constant (s), float64[devices].

    u_t: V; electrons: of shot noise that an electron of a step has, rest: where its gate rests above its
    bias, V, float64[devices]; noise: of the cells, None for none.
    """

    tables: DepressionTables
    step: F64
    tau: F64
    u_t: float
    electrons: F64
    rest: F64
    noise: DepressionNoise | None = None
