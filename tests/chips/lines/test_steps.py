"""Lines in steps: the density of what they have, whose it is, and the ripple in it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from chips.latency.design import bias_circuit
from chips.latency.errors import usual_design
from chips.latency.model import usual_biases
from chips.lines.steps import LineSteps, bring_lines, copied_steps, drawn_steps, line_steps
from chips.lines.wander import wander_of
from chips.noise import SiliconNoise
from circuits.arrays import F64
from circuits.devices.noise import WHITE_ONLY
from circuits.generator.ripple import Ripple
from circuits.silicon.process import AMI_1500
from circuits.silicon.silicon import Silicon

SILICON = Silicon(AMI_1500)
BIASES = bias_circuit(usual_biases(usual_design(), "generator", AMI_1500))
NAMES = ("i_tonic", "i_hold", "i_inhibition")
STEP = 1e-3


def steps(noise: SiliconNoise) -> LineSteps:
    wander = wander_of(BIASES, NAMES, SILICON, noise)
    return line_steps(wander, np.full(3, 25.0), SILICON, noise, "chip", STEP)


def run(lines: LineSteps, count: int) -> F64:
    own, found = copied_steps(lines), np.empty((count, 3))
    for k in range(count):
        bring_lines(own, k)
        found[k] = own.shift
    return found


def test_steps_have_the_lines_white_density() -> None:
    noise = SiliconNoise(4, flicker=WHITE_ONLY)
    lines, wander = steps(noise), wander_of(BIASES, NAMES, SILICON, noise)
    found = run(lines, 4000)
    density = wander.white + (wander.follow_white**2).sum(axis=1)
    held = STEP * np.exp2(lines.doubled)
    assert np.abs(np.log2(held * wander.rate / 2.0))[lines.doubled > 0].max() <= 0.5
    # 4,000 draws know a deviation to 1.1 %, and those that stand for 32 steps to 6 %
    assert found.std(axis=0) == pytest.approx(25.0 * np.sqrt(density / (2.0 * held)), rel=0.15)
    whole = found[: len(found) // 64 * 64].reshape(-1, 64, 3).mean(axis=1).std(axis=0)
    assert whole == pytest.approx(25.0 * np.sqrt(density / (128.0 * STEP)), rel=0.25)
    assert np.array_equal(run(lines, 5), found[:5])


def test_flicker_is_slow() -> None:
    slow = run(steps(SiliconNoise(4)), 4000)
    fast = run(steps(SiliconNoise(4, flicker=WHITE_ONLY)), 4000)
    own = (slow - fast)[::64]
    moved = own - own.mean(axis=0)
    assert (own.std(axis=0) > 3e-4).all()
    assert ((moved[1:] * moved[:-1]).mean(axis=0) > 0.3 * moved.var(axis=0)).all()


def test_a_ripple_is_a_sine_in_them() -> None:
    ripple = Ripple(20e-3, 20.0)
    still, moved = (steps(SiliconNoise(4, flicker=WHITE_ONLY, ripple=r)) for r in (None, ripple))
    sine = run(moved, 200) - run(still, 200)
    angle = 2.0 * np.pi * 20.0 * STEP * (np.arange(200) + 0.5)
    assert sine == pytest.approx(moved.ripple * np.sin(angle[:, None] + moved.lag + moved.phase), abs=1e-9)
    assert moved.ripple.min() > 1e-3


def test_a_ripple_is_its_mean_over_each_step() -> None:
    """One of whole periods a step moves no current, and a faster one less than a slow one by its sinc."""
    noise, wander = SiliconNoise(4), wander_of(BIASES, NAMES, SILICON, SiliconNoise(4))
    moved = wander._replace(supply=np.full(3, 1e-3 + 0j))

    def peaks(frequency: float) -> F64:
        rippled = SiliconNoise(4, ripple=Ripple(10e-3, frequency))
        return line_steps(moved, np.full(3, 25.0), SILICON, rippled, "chip", STEP).ripple

    assert line_steps(moved, np.full(3, 25.0), SILICON, noise, "chip", STEP).ripple == pytest.approx(25e-3)
    assert peaks(1.0) == pytest.approx(25e-3, rel=1e-4)
    assert peaks(500.0) == pytest.approx(25e-3 * 2.0 / np.pi, rel=1e-9)
    assert peaks(1e3) == pytest.approx(0.0, abs=1e-12)
    assert np.abs(peaks(10.5e3)) == pytest.approx(25e-3 / (10.5 * np.pi), rel=1e-9)


def test_lines_of_another_trial_are_drawn_as_if_built_in_it() -> None:
    noise = SiliconNoise(4, ripple=Ripple(20e-3, 20.0))
    lines, other = steps(noise), replace(noise, trial=7)
    first = run(lines, 40)
    again = drawn_steps(lines, other, "chip")
    assert np.array_equal(run(again, 40), run(steps(other), 40))
    assert not np.array_equal(run(again, 40), first)
    assert np.array_equal(run(drawn_steps(again, noise, "chip"), 40), first)


def test_lines_that_do_not_wander_are_none() -> None:
    gates = bias_circuit(usual_biases(usual_design(), "gate", AMI_1500))
    noise = SiliconNoise(1)
    lines = line_steps(wander_of(gates, NAMES, SILICON, noise), np.ones(3), SILICON, noise, "chip", STEP)
    assert lines.shift.size == 0
    bring_lines(lines, 3)
    assert lines.shift.size == 0
