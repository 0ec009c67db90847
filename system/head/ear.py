"""The two ears of the sonar head: an echo goes in, spikes of both ears' level units come out.

With b the beam and p the echo's pressure of `system.worlds.sound.acoustics`, the
envelope of the ear that points to psi rises by

    A = volts b(theta_s) b(theta_h - psi) p(r) e^(glint g + noise n)

theta_s at the call and theta_h at the echo, from the head's axis; g is both ears', n each ear's own. It does
so on the envelope detector's pedestal, with raised cosines as edges, so that a level unit of the threshold h
(offset included) is passed at `(t_r / pi) arccos(1 - 2 h / A)`. Half of the spacing over the speed of sound,
times sin(theta_h), is by how much the nearer ear hears it sooner.

A level unit whose threshold is too near to the pedestal, or below it, never fires: its comparator is never at
rest (`chips.lso.law`).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from chips.lso.model import SIDES, Head, level_times
from chips.lso.noise import LsoNoise, level_jitter
from circuits.arrays import F64, Bools
from system.head.numbers import BEHIND, SonarHead
from system.worlds.sound.acoustics import AIR_TEMPERATURE, beam, echo_pressure, speed_of_sound

SPEED = speed_of_sound(AIR_TEMPERATURE)  # m/s
SIGNS = np.array([1.0, -1.0])  # left, right


class Echo(NamedTuple):
    """What both ears make of an echo.

    level : spikes of the level units, s after the echo, float64[SIDES, LEVELS], inf for none.

    clipped: ears whose envelope was cut off at the rail.
    """

    level: F64
    clipped: int


def amplitudes(numbers: SonarHead, sent: float, heard: float, distance: float) -> F64:
    """Envelopes (V) at both ears of a target at these angles (rad) from the head's axis, without noise."""
    if abs(sent) >= BEHIND or abs(heard) >= BEHIND:
        return np.zeros(SIDES)
    apart = heard - numbers.squint * SIGNS
    ears = beam(np.array([sent]), numbers.beam) * beam(apart, numbers.beam)
    return np.asarray(numbers.volts * ears * echo_pressure(distance))


def listen(
    numbers: SonarHead, head: Head, envelope: F64, heard: float, noise: LsoNoise | None = None,
    ping: int = 0,
) -> Echo:  # fmt: skip
    """Spikes of all level units at envelopes (V) of both ears of an echo from an angle (rad).

    noise: of the silicon, drawn for the number of a ping; `head` has what it does to thresholds.
    """
    clipped = int((envelope > numbers.rail).sum())
    peak = np.minimum(envelope, numbers.rail)[:, None]
    threshold = np.array(numbers.thresholds)[None, :] + head.offset
    share = np.full(threshold.shape, np.inf)
    passed = hearing(numbers, head) & (threshold < peak)
    share[passed] = (threshold / np.where(peak > 0.0, peak, 1.0))[passed]
    crossed, slope = np.full(share.shape, np.inf), np.zeros(share.shape)
    phase = np.arccos(1.0 - 2.0 * share[passed])
    crossed[passed] = numbers.rise / math.pi * phase
    slope[passed] = (peak * np.ones_like(share))[passed] * 0.5 * math.pi / numbers.rise * np.sin(phase)
    slope = np.maximum(slope, 1.0)
    spikes = level_times(head, crossed, slope)
    if noise is not None:
        late = np.where(passed, spikes, np.inf) - np.where(passed, crossed, 0.0)
        spikes += level_jitter(head, noise, ping, late, slope)
    spikes[spikes > numbers.call - crossed] = np.inf  # the envelope was gone before
    sooner = 0.5 * numbers.spacing / SPEED * math.sin(heard)
    return Echo(spikes - sooner * SIGNS[:, None], clipped)


def hearing(numbers: SonarHead, head: Head) -> Bools:
    """Which level units are at rest on the pedestal, so that they can fire, bool[SIDES, LEVELS]."""
    above = np.array(numbers.thresholds)[None, :]
    return np.asarray((above + head.offset > 0.0) & (above > head.rest))
