"""How the lines of a chip's bias generator wander: one place for all chips' models.

A line's gate-source voltage is moved by its own devices' noise, by that of the masters, which lines share
(`circuits.generator.noise`), and by the ripple of the supply (`circuits.generator.ripple`). What a model asks
for is the mean of it over a time T. Of white noise S that a line follows up to a rate r, of flicker as a sum
of relaxations, and of a sine it has the variances, and the value,

    S r / 4 <(r T)>,    sum_i v_i <(r_i T)>,    |H| a (cos(w t + p) - cos(w (t + T) + p)) / (w T)

with `<l>` of `chips.noise.mean_variance`. Means over several times of one line have the same draw: they are
taken to differ in size alone. The phase of the ripple is drawn once a run.

Lines of kind `gate` and `ideal` do not wander, and a ripple of their supply is refused.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from chips.noise import SiliconNoise, mean_variance
from chips.noise_draw import Draws, new_draws, normals
from circuits.arrays import C128, F64, I64
from circuits.bias import lines_of
from circuits.circuit import Circuit
from circuits.errors import ParameterError
from circuits.generator.noise import following, line_noise, shared_noise
from circuits.generator.ripple import Ripple, line_response
from circuits.silicon.silicon import Silicon
from circuits.solver.noise.transient import noise_keys, relaxations

GENERATOR = "generator"
_MOST_SWING = 0.2  # of U_T, up to which a line's ripple is a small signal: 1 % of the mean current; ours
_LEAST = 1e-9  # rad, for a mean over no time
_FASTEST = 0.1  # of the shortest time: a grid up to whose band flicker is summed


class Wander(NamedTuple):
    """How the gate-source voltages of n lines wander; m shared sources, none where no line wanders.

    white, flicker: by each line's own devices, V^2/Hz, of flicker at 1 Hz, float64[n]; rate: up to which a
    line follows, 1/s, float64[n]; follow_white, follow: by each source, V/Hz^0.5, float64[n, m]; supply: peak
    by the ripple, V, complex128[n].
    """

    white: F64
    flicker: F64
    rate: F64
    follow_white: F64
    follow: F64
    supply: C128


class Swing(NamedTuple):
    """A ripple in a run: w, rad/s, and p, rad."""

    pace: float
    phase: float


def wander_of(circuit: Circuit, names: Sequence[str], silicon: Silicon, noise: SiliconNoise) -> Wander:
    """Return how the lines behind biases of a circuit wander, all of a bias's one after the other.

    circuit: a chip, or a part whose biases know their place on it. Raises `ParameterError` for a ripple where
    a bias is none of the generator's, and one that is no small signal at a line.
    """
    require_generator(circuit, names, noise.ripple)
    return joined([_of_bias(circuit, name, silicon, noise) for name in names])


def require_generator(circuit: Circuit, names: Sequence[str], ripple: Ripple | None) -> None:
    """Raise `ParameterError` for a ripple where a bias is not of the generator."""
    if ripple is None:
        return
    for name in names:
        if (kind := circuit.bias(name).kind) != GENERATOR:
            raise ParameterError(
                f"{circuit.name}.{name}: ripple of {ripple} on a bias of kind {kind}, must be generator,"
                " whose lines have a supply; choose that kind"
            )


def joined(parts: Sequence[Wander]) -> Wander:
    """Return the lines of several parts of one chip in their order; the sources are the same."""
    most = max(p.follow.shape[1] for p in parts)
    wide = [
        p._replace(
            **{
                n: np.pad(getattr(p, n), ((0, 0), (0, most - p.follow.shape[1])))
                for n in ("follow_white", "follow")
            }
        )
        for p in parts
    ]
    return Wander(*(np.concatenate([getattr(p, n) for p in wide]) for n in Wander._fields))


def apart(parts: Sequence[Wander]) -> Wander:
    """Return the lines of several generators in their order; each generator has its own sources."""
    begins = np.cumsum([0, *(p.follow.shape[1] for p in parts)])
    wide = [
        p._replace(**{
            n: np.pad(getattr(p, n), ((0, 0), (begin, begins[-1] - begin - p.follow.shape[1])))
            for n in ("follow_white", "follow")
        })
        for p, begin in zip(parts, begins, strict=False)
    ]  # fmt: skip
    return joined(wide)


def still(count: int) -> Wander:
    """Return lines that do not wander."""
    none, flat = np.zeros(count), np.zeros((count, 0))
    return Wander(none, none, np.ones(count), flat, flat, np.zeros(count, np.complex128))


def _of_bias(circuit: Circuit, name: str, silicon: Silicon, noise: SiliconNoise) -> Wander:
    bias = circuit.bias(name)
    if bias.kind != GENERATOR:
        return still(int(np.prod(circuit.port(bias.port).shape, dtype=np.int64)))
    lines, current = lines_of(circuit, bias, silicon)
    model = noise.flicker_in(silicon.process)
    own, shared = line_noise(lines, current, silicon, model), shared_noise(lines, silicon, model)
    on = 1.0 if lines.device.polarity == "n" else -1.0
    supply = np.zeros(own.white.size, np.complex128)
    if noise.ripple is not None:
        supply = noise.ripple.amplitude * line_response(lines, current, silicon, noise.ripple.frequency)
        _check_small(f"{circuit.name}.{name}", noise.ripple, supply, silicon)
    follow = on * following(shared.white, own), on * following(shared.flicker, own)
    return Wander(own.white, own.flicker, own.rate, *follow, supply)


def _check_small(path: str, ripple: Ripple, supply: C128, silicon: Silicon) -> None:
    """Refuse a ripple by which a current does not move in proportion any more."""
    most, found = _MOST_SWING * silicon.thermal_voltage, float(np.abs(supply).max())
    if found > most:
        raise ParameterError(
            f"{path}: ripple of {ripple} moves its line by {1e3 * found:.3g} mV, must be at most"
            f" {1e3 * most:.3g} mV, a fifth of U_T; give a smaller one"
        )


def swing_of(noise: SiliconNoise) -> Swing:
    """Return the ripple in a run, all zero for none; its phase is that of (seed, trial) on every chip."""
    if noise.ripple is None:
        return Swing(0.0, 0.0)
    (word,) = noise_keys(noise.seed, noise.trial, ["supply"])[0].tolist()
    return Swing(2.0 * math.pi * noise.ripple.frequency, 2.0 * math.pi * word / 2.0**32)


class Reach(NamedTuple):
    """What wandering lines do to quantities of one shape.

    line: number of the line that each follows, int64; time: over which it means it, s; slope: what it changes
    by, relative, a volt, 1/V; white, slow: deviations of the means by white noise of 1 V^2/Hz and by flicker
    of 1 V^2/Hz at 1 Hz, V.
    """

    line: I64
    time: F64
    slope: F64
    white: F64
    slow: F64


@dataclass(frozen=True, slots=True, eq=False)
class WanderDraws:
    """Lines that wander from ping to ping, and their draws, by the number of the ping.

    rate, variance: of the relaxations that flicker is the sum of.
    """

    wander: Wander
    swing: Swing
    rate: F64
    variance: F64
    draws: Draws

    def reach(self, line: I64, time: F64, slope: F64) -> Reach:
        """Return what the lines do to quantities; arguments as of `Reach`, broadcast to the time's shape."""
        k = np.broadcast_to(line, time.shape)
        own = self.wander.rate[k]
        white = np.sqrt(0.25 * own * mean_variance(own * time))
        slow = np.zeros(time.shape)
        if self.rate.size:
            followed = self.variance * own[..., None] / (own[..., None] + self.rate)
            slow = np.sqrt((followed * mean_variance(self.rate * time[..., None])).sum(axis=-1))
        return Reach(k, time, np.broadcast_to(slope, time.shape), white, slow)

    def spread(self, reach: Reach) -> F64:
        """Return standard deviations of quantities by the noise of their lines, relative."""
        w = self.wander
        white = (w.white + (w.follow_white**2).sum(axis=1))[reach.line] * reach.white**2
        slow = (w.flicker + (w.follow**2).sum(axis=1))[reach.line] * reach.slow**2
        return np.asarray(np.abs(reach.slope) * np.sqrt(white + slow))

    def drawn(self, number: int) -> F64:
        """Return what each line has in ping `number`, V/Hz^0.5: white noise, then flicker, [2, lines]."""
        w = self.wander
        n, m = w.follow.shape
        unit = normals(self.draws, number, np.empty((2, n + m)))
        white = np.sqrt(w.white) * unit[0, :n] + w.follow_white @ unit[0, n:]
        return np.stack([white, np.sqrt(w.flicker) * unit[1, :n] + w.follow @ unit[1, n:]])

    def noise(self, reach: Reach, drawn: F64) -> F64:
        """Return relative changes of quantities in a ping by their lines' noise; drawn: as of `drawn`."""
        k = reach.line
        return np.asarray(reach.slope * (reach.white * drawn[0][k] + reach.slow * drawn[1][k]))

    def changes(self, reach: Reach, drawn: F64, begin: float) -> F64:
        """Return relative changes in a ping that begins at `begin` s, by the supply's ripple too."""
        rippled = swung(self.swing, self.wander.supply[reach.line], begin, reach.time)
        return np.asarray(self.noise(reach, drawn) + reach.slope * rippled)


def wander_draws(
    wander: Wander, silicon: Silicon, noise: SiliconNoise, name: str, shortest: float
) -> WanderDraws:
    """Return the draws of a chip's lines.

    name: of the chip on its die; shortest: time over which a mean is asked for, s.
    """
    rate, variance = relaxations(noise.flicker_in(silicon.process), _FASTEST * shortest)
    draws = new_draws(noise.seed, noise.trial, f"{name}, bias lines", 2 * sum(wander.follow.shape))
    return WanderDraws(wander, swing_of(noise), rate, variance, draws)


def swung(swing: Swing, supply: C128, begin: float, time: F64) -> F64:
    """Return the mean of lines' ripple over times from `begin` (s) on, V; supply: peaks, V, of one shape."""
    if swing.pace == 0.0:
        return np.zeros(time.shape)
    angle = swing.pace * begin + swing.phase + np.angle(supply)
    over = np.maximum(swing.pace * time, _LEAST)
    return np.asarray(np.abs(supply) * (np.cos(angle) - np.cos(angle + over)) / over)
