"""Lines that wander in a run by steps: what each has in a step, without allocation.

White noise S of a line that follows up to a rate r stands for a time T with the variance `S / (2 T)`, T about
2 / r, a step doubled some times, one at least, so that it has its density below the line's corner and k T / C
in all. Flicker is a sum of octaves (`chips.noise_draw`), which the line's capacitor does not hold here. Both
are of the line itself and of the masters that lines share; lines of other times T have other white noise of
these. A ripple is its mean over the step, `sin(w T / 2) / (w T / 2)` of its value in the middle, so that one
faster than the steps does not come back as a slow one. What a model gets is the relative change of the
current that each line sets.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from chips.lines.wander import Wander, swing_of
from chips.noise import SiliconNoise
from chips.noise_draw import Draws, Slow, bring, copied_slow, draw, new_draws, new_slow
from circuits.arrays import F64, I64
from circuits.compiled import compiled
from circuits.devices.noise import WHITE_ONLY
from circuits.silicon.silicon import Silicon

_compiled = compiled()


class LineSteps(NamedTuple):
    """n lines of a chip, which m sources move, in steps; n is 0 where none wanders.

    white: deviations by each line and by each source, relative, float64[n, n + m]; doubled: how often steps
    are doubled for which they stand, int64[n]; slow: flicker of each line and each source, of 1 / f; follow:
    what a unit of it changes, relative, float64[n, n + m]; ripple, lag: peak of its means over steps,
    relative, of either sign, and how far it is behind the supply, rad, float64[n]; pace, phase: of the
    supply, rad/s and rad; step: s; fast, held: draws; shift: relative changes of the currents in the present
    step, float64[n], overwritten.
    """

    white: F64
    doubled: I64
    slow: Slow
    follow: F64
    ripple: F64
    lag: F64
    pace: float
    phase: float
    step: float
    fast: Draws
    held: Draws
    shift: F64


def line_steps(
    wander: Wander, slope: F64, silicon: Silicon, noise: SiliconNoise, name: str, step: float
) -> LineSteps:
    """Return lines in steps of `step` s.

    slope: `d ln I / dv` of what each line biases, 1/V, float64[n]; name: of the chip on its die.
    """
    n, m = wander.follow.shape
    if not (wander.white.any() or wander.supply.any()):
        n, m, wander, slope = 0, 0, _none(), np.zeros(0)
    doubled = np.rint(np.log2(np.maximum(2.0 / (wander.rate * step), 1.0)))
    held = np.sqrt(2.0 * step * np.exp2(doubled))
    white = np.concatenate([np.diag(np.sqrt(wander.white)), wander.follow_white], axis=1) / held[:, None]
    follow = np.concatenate([np.diag(np.sqrt(wander.flicker)), wander.follow], axis=1)
    swing = swing_of(noise)
    return LineSteps(
        slope[:, None] * white,
        doubled.astype(np.int64),
        new_slow(np.ones(n + m), noise.flicker_in(silicon.process), step, 1),
        slope[:, None] * follow,
        slope * np.abs(wander.supply) * np.sinc(swing.pace * step / (2.0 * math.pi)),
        np.angle(wander.supply),
        swing.pace,
        swing.phase,
        step,
        *_draws(noise, name, n + m),
        np.zeros(n),
    )  # fmt: skip


def no_lines() -> LineSteps:
    """Return the lines of a chip where none wanders."""
    return line_steps(_none(), np.zeros(0), Silicon(), SiliconNoise(flicker=WHITE_ONLY), "", 1.0)


def _draws(noise: SiliconNoise, name: str, lines: int) -> tuple[Draws, Draws]:
    """Draws of white noise of lines and sources, and of their flicker."""
    path = f"{name}, bias lines"
    return (
        new_draws(noise.seed, noise.trial, path, lines),
        new_draws(noise.seed, noise.trial, f"{path}, slowly", 1),
    )


def _none() -> Wander:
    none, flat = np.zeros(0), np.zeros((0, 0))
    return Wander(none, none, none, flat, flat, np.zeros(0, np.complex128))


def copied_steps(lines: LineSteps) -> LineSteps:
    """Return the same lines with working space of their own, from any step on."""
    fast, held = (
        d._replace(**{n: getattr(d, n).copy() for n in ("counters", "words", "normal")})
        for d in (lines.fast, lines.held)
    )
    return lines._replace(slow=copied_slow(lines.slow), fast=fast, held=held, shift=lines.shift.copy())


def drawn_steps(lines: LineSteps, noise: SiliconNoise, name: str) -> LineSteps:
    """Return the same lines with the draws of another seed and trial, from any step on.

    noise: with what `line_steps` had but for the seed and the trial; name: of the chip on its die.
    """
    fast, held = _draws(noise, name, lines.white.shape[1])
    return copied_steps(lines)._replace(fast=fast, held=held, phase=swing_of(noise).phase)


@_compiled
def bring_lines(t: LineSteps, number: int) -> None:
    """Write the relative changes of step `number` into `shift`."""
    n = t.shift.size
    if n == 0:
        return
    bring(t.slow, t.held, number)
    slow = t.slow.deviation.size > 0
    for k in range(n):
        draw(t.fast, number >> t.doubled[k], t.doubled[k])
        shift = 0.0
        for j in range(t.white.shape[1]):
            shift += t.white[k, j] * t.fast.normal[j]
            if slow:
                shift += t.follow[k, j] * t.slow.value[j, 0]
        if t.pace > 0.0:
            shift += t.ripple[k] * math.sin(t.pace * (number + 0.5) * t.step + (t.lag[k] + t.phase))
        t.shift[k] = shift
