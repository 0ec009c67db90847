"""Calibration of the sonar head's chip: spikes that a level difference makes, and where left and right agree.

On the bench both ears get bursts whose envelopes rise in a straight line to levels of the bench's choice:
`DIFFERENCES` about `LOUDNESSES`, left and right in turn the louder. What is counted are the spikes of the two
LSO neurons, left less right; a burst at one ear alone tells how long a synapse's step lasts, by the number of
its spikes and the time between them. All without noise, as the means of many bursts have it.

    i_step    brings the step to the design's
    i_exc     brings the slope, spikes a decibel, to the design's
    balance   a trim of the board that counts: the mean of left less right over the whole sweep, in which
              both are the louder as often, is taken from each count

Excitation and inhibition of both neurons come from the same two lines. So what a mirror takes too much or too
little of its neuron's inhibition stays, 5 % rms on each side: it opens or closes a gap about equal levels in
which neither neuron spikes, and moves the balance with the loudness. Level units that are deaf stay deaf.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from chips.codes import Codes, Measured, attempted, codes_near, left_off
from chips.lso.measure import circuits
from chips.lso.model import SIDES, Head, head_on, level_times, side_spikes
from chips.lso.place import Currents
from circuits.arrays import F64, Bools
from circuits.circuit import BiasKind
from circuits.errors import ParameterError
from circuits.generator import code as generator_code
from circuits.silicon.silicon import Silicon

NAME = "lso-chip"  # of the calibration
DIFFERENCES = np.arange(-6.0, 7.0)  # dB, left over right; ours
LOUDNESSES = 3.0 * np.arange(-3, 4)  # dB over the middle of the thresholds, both ears' mean; ours
RISE = 0.2e-3  # s, of a burst's envelope; ours
BURST = 20e-3  # s, from burst to burst; ours
BURSTS = 16  # of which each count is the mean; ours
ROUNDS = 5  # in which both lines are measured and moved; ours
OFF = 0.1  # share of a number beyond which it is told to stay off; ours
UNBALANCED = 0.5  # spikes, beyond which a loudness is told to stay off; ours
LINES = ("i_exc", "i_step")


@dataclass(frozen=True, slots=True)
class Design:
    """What the chip is calibrated for.

    Attributes
    ----------
    thresholds : tuple of float
        Of the level units of either ear, V above the envelope's pedestal.
    area : float
        Area of the chip's drawn devices over the circuits', a ratio.
    """

    thresholds: tuple[float, ...]
    area: float = 1.0


@dataclass(frozen=True, slots=True)
class Trial:
    """What the bench measured at codes.

    currents: nominal currents of `LINES`, A. step: how long a step lasts, s, the mean of both neurons. slope:
    spikes, left less right, a decibel. even: mean of left less right over all differences,
    float64[loudnesses]. deaf: level units that never spike, bool[ears, units].
    """

    currents: Mapping[str, float]
    step: float
    slope: float
    even: F64
    deaf: Bools

    @property
    def balance(self) -> float:
        """Mean of left less right, spikes."""
        return float(self.even.mean())


def calibrate(silicon: Silicon, kind: BiasKind, design: Design) -> Codes:
    """Calibrate the chip of a design on a silicon, at its temperature.

    A chip whose neurons do not spike, or of which a line has no code for what it should have, cannot be used.

    Arguments are those of `chips.codes.attempted`; design: thresholds of its level units. Raises
    `OutsideBoxError` where its record was not measured for the silicon, or for a current that is tried.
    """
    return attempted(NAME, silicon, kind, design, lambda begun: _found(begun, silicon, design))


def _found(begun: Codes, silicon: Silicon, design: Design) -> Codes:
    """Codes of the chip on a silicon."""
    wanted = designed(silicon, design)
    found = _in_turn(silicon, begun.key.bias_kind, design, wanted)
    best = min(found, key=lambda trial: abs(math.log(trial.slope / wanted.slope)))
    measured = tuple(_measured(wanted, found[0], best))
    return replace(
        begun, biases=codes_near(best.currents), trims={"balance": (best.balance,)}, measured=measured,
        bench_s=len(found) * BURSTS * BURST * (DIFFERENCES.size * LOUDNESSES.size + SIDES),
        unmended=(*left_off(measured[:2], OFF), *_uneven(measured[2:]), *_told_deaf(best)),
    )  # fmt: skip


def currents_of(codes: Codes) -> Currents:
    """Return the currents of the chip's biases at codes, A, as `chips.lso.model.head_on` takes them."""
    return tuple((name, float(np.asarray(current))) for name, current in codes.currents.items())


def designed(silicon: Silicon, design: Design) -> Trial:
    """Return what the bench measures of the nominal chip under the ideal law, at its design's currents."""
    return _trial(Silicon(silicon.process.under("ideal")), "gate", design, _usual())


def _in_turn(silicon: Silicon, kind: BiasKind, design: Design, wanted: Trial) -> list[Trial]:
    """What is measured at the usual codes, and at those that each round makes of it."""
    currents, found = _at_codes(_usual()), [_trial(silicon, kind, design, _at_codes(_usual()))]
    for _ in range(ROUNDS - 1):
        last = found[-1]
        if not (last.slope > 0.0 and last.step > 0.0):
            raise ParameterError(f"{NAME}: its neurons make no more spikes for more at their ear")
        factors = {"i_exc": wanted.slope / last.slope, "i_step": last.step / wanted.step}
        factors["i_exc"] *= factors["i_step"]  # a shorter step makes as many spikes by more current
        moved = _at_codes({name: currents[name] * factors[name] for name in LINES})
        if moved == currents:
            break
        currents = moved
        found.append(_trial(silicon, kind, design, currents))
    return found


def _usual() -> dict[str, float]:
    """Currents of the design, A."""
    lso = circuits()[0]
    return {name: float(np.asarray(lso.bias(name).value)) for name in LINES}


def _at_codes(currents: Mapping[str, float]) -> dict[str, float]:
    """Currents of the codes nearest to currents, A."""
    return {name: _nearest(value) for name, value in currents.items()}


def _nearest(current: float) -> float:
    return float(generator_code.currents_of(generator_code.codes_of(np.array(current))))


def _trial(silicon: Silicon, kind: BiasKind, design: Design, currents: Mapping[str, float]) -> Trial:
    """Measure the chip at currents of `LINES`, A."""
    head = head_on(silicon, kind, design.area, tuple(currents.items()))
    counts = np.array([[_heard(head, design, d, loud) for loud in LOUDNESSES] for d in DIFFERENCES])
    slope = np.polyfit(DIFFERENCES, counts.mean(axis=1), 1)[0]
    loud = 10.0 ** (0.05 * LOUDNESSES[-1]) * _middle(design)
    alone = [_alone(head, design, side, loud) for side in range(SIDES)]
    return Trial(currents, float(np.mean(alone)), float(slope), counts.mean(axis=0), ~_hearing(head, design))


def _middle(design: Design) -> float:
    """Geometric mean of the thresholds, V."""
    return float(np.exp(np.mean(np.log(design.thresholds))))


def _hearing(head: Head, design: Design) -> Bools:
    """Level units that are at rest on the pedestal, so that they can spike, bool[ears, units]."""
    above = np.array(design.thresholds)[None, :]
    return np.asarray((above + head.offset > 0.0) & (above > head.rest))


def _levels(head: Head, design: Design, peaks: F64) -> F64:
    """Spikes of the level units for a burst, s, inf for none; peaks: of both ears' envelopes, V."""
    slope = np.broadcast_to(peaks[:, None] / RISE, head.offset.shape)
    threshold = np.array(design.thresholds)[None, :] + head.offset
    passed = _hearing(head, design) & (threshold < peaks[:, None])
    crossed = np.where(passed, threshold / np.where(slope > 0.0, slope, 1.0), np.inf)
    return level_times(head, crossed, slope)


def _heard(head: Head, design: Design, difference: float, loudness: float) -> int:
    """Spikes of the left neuron less those of the right, in a burst of this difference and loudness, dB."""
    decibels = loudness + 0.5 * difference * np.array([1.0, -1.0])
    level = _levels(head, design, _middle(design) * 10.0 ** (0.05 * decibels))
    left, right = (side_spikes(head, side, level).size for side in range(SIDES))
    return left - right


def _alone(head: Head, design: Design, side: int, peak: float) -> float:
    """How long a neuron's steps last, s, by its spikes for a burst (V) at its own ear; 0 without any."""
    peaks = np.zeros(SIDES)
    peaks[side] = peak
    spikes = side_spikes(head, side, _levels(head, design, peaks))
    return float(spikes.size * np.median(np.diff(spikes))) if spikes.size > 1 else 0.0


def _measured(wanted: Trial, before: Trial, after: Trial) -> Iterator[Measured]:
    """Step and slope, and the balance of every loudness, after it the board's trim is taken off."""
    yield Measured("step", "s", wanted.step, before.step, after.step)
    yield Measured("slope", "", wanted.slope, before.slope, after.slope)
    for k, loudness in enumerate(LOUDNESSES):
        even = float(before.even[k]), float(after.even[k]) - after.balance
        yield Measured(f"even[{loudness:g}dB]", "", 0.0, *even)


def _uneven(measured: tuple[Measured, ...]) -> Iterator[str]:
    for each in measured:
        if abs(each.after) > UNBALANCED:
            yield f"{each.name}: left less right {each.after:+.2g} spikes, averaged over even differences"


def _told_deaf(trial: Trial) -> Iterator[str]:
    for side, unit in np.argwhere(trial.deaf):
        yield f"level unit {unit} of the {('left', 'right')[side]} ear: deaf at its threshold"
