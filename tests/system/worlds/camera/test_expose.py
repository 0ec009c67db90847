"""Pixels by themselves: counts, times, refractory period and low-pass."""

from __future__ import annotations

import math

import numpy as np
import pytest

from circuits.arrays import F64
from system.worlds.camera.expose import expose
from system.worlds.camera.lamp import no_glow
from system.worlds.camera.pixel import Beat, Memory, Pixels, raw_of, settle

COUNT, THETA_ON, THETA_OFF, DARK = 64, 0.2, 0.15, 0.1
FAST = 1e9  # Hz: no low-pass to speak of


def pixels(**changes: object) -> Pixels:
    plain = Pixels(
        on=np.full(COUNT, THETA_ON), off=np.full(COUNT, THETA_OFF), leak=np.zeros(COUNT),
        hot=np.empty(0, dtype=np.int64), dark=DARK, follower=FAST, per_lux=FAST, refractory=0.0, noise=0.0,
        noise_lux=1.0, noise_most=0.0, nominal=0.175, hot_rate=50.0,
    )  # fmt: skip
    return plain._replace(**changes)


class Bench:
    """Pixels that are shown one level after the other."""

    def __init__(self, p: Pixels, lux: float) -> None:
        self.p, self.time = p, 0.0
        levels = [np.zeros(COUNT) for _ in range(5)]
        none, turn = np.zeros(COUNT, dtype=np.int64), np.zeros(1, dtype=np.int64)
        self.memory = Memory(*levels, none, np.zeros(8), turn, np.full(2, np.inf))
        self.raw = raw_of(COUNT, 100_000)
        self.random = np.random.default_rng(1)
        settle(p, self.memory, np.full(COUNT, lux), 0.0)

    def show(self, lux: float | F64, step: float) -> None:
        lamps, light = np.empty((0, 6)), np.array(np.broadcast_to(lux, COUNT), dtype=np.float64)
        expose(self.p, self.memory, light, no_glow(), lamps, Beat(self.time, step), self.random, self.raw)
        self.time += step

    def ramp(self, first: float, change: float, steps: int, step: float) -> None:
        """Log light (with the dark current) goes straight from `first` by `change`."""
        for k in range(1, steps + 1):
            self.show(math.exp(first + change * k / steps) - DARK, step)

    def events(self, pixel: int = 0) -> tuple[F64, F64]:
        """Times and polarities of a pixel's events."""
        n = self.raw.used[0]
        own = self.raw.code[:n] >> 1 == pixel
        return self.raw.time[:n][own], self.raw.code[:n][own] & 1


START = math.log(100.0 + DARK)


@pytest.mark.parametrize(
    ("change", "count", "polarity"),
    [(0.19, 0, 1), (0.21, 1, 1), (1.37, 6, 1), (-0.14, 0, 0), (-0.16, 1, 0), (-1.37, 9, 0)],
)
@pytest.mark.parametrize("steps", [1, 7, 50])
def test_a_ramp_gives_as_many_events_as_thresholds_fit(
    change: float, count: int, polarity: int, steps: int
) -> None:
    bench = Bench(pixels(), 100.0)
    bench.ramp(START, change, steps, 0.35 / steps)
    for pixel in (0, COUNT - 1):
        times, signs = bench.events(pixel)
        assert len(times) == count
        assert np.all(signs == polarity)
        # at equal distances in time, as the crossings of a straight line are
        theta = THETA_ON if polarity else THETA_OFF
        assert times == pytest.approx(0.35 * theta / abs(change) * np.arange(1, count + 1), abs=1e-9)


def test_up_and_down_counts_both_ways() -> None:
    bench = Bench(pixels(), 100.0)
    bench.ramp(START, 1.0, 10, 0.01)
    bench.ramp(START + 1.0, -1.0, 10, 0.01)
    _, signs = bench.events()
    # five thresholds up leave V_m at 1.0 (4 where rounding misses the fifth); six thresholds of 0.15 fit down
    assert (signs == 1).sum() in {4, 5}
    assert (signs == 0).sum() in {5, 6}


def test_the_refractory_period_adds_to_every_interval() -> None:
    rate, refractory = 40.0, 2e-3  # of log light, 1/s: a threshold in 5 ms
    bench = Bench(pixels(refractory=refractory), 100.0)
    bench.ramp(START, rate * 0.1, 25, 4e-3)
    times, _ = bench.events()
    assert len(times) == int((0.1 - 5e-3) / (5e-3 + refractory)) + 1
    assert np.diff(times) == pytest.approx(5e-3 + refractory, abs=1e-9)


def test_a_long_refractory_period_forgets_what_happens_in_it() -> None:
    bench = Bench(pixels(refractory=0.05), 100.0)
    bench.ramp(START, 0.25, 1, 0.01)
    bench.ramp(START + 0.25, 3.0, 5, 0.005)  # all of it while the pixel is in reset
    for _ in range(10):
        bench.show(math.exp(START + 3.25) - DARK, 0.01)
    times, _ = bench.events()
    assert len(times) == 1


def test_log_light_is_low_passed_exactly() -> None:
    # a ramp that stops: V by its closed form, whatever the steps
    cutoff, slope = 10.0, 4.0
    tau = 1.0 / (2.0 * math.pi * cutoff)
    found = []
    for steps in (1, 10):
        bench = Bench(
            pixels(follower=cutoff, per_lux=1e12, on=np.full(COUNT, 9.0), off=np.full(COUNT, 9.0)), 100.0
        )
        bench.ramp(START, slope * 0.02, steps, 0.02 / steps)
        bench.show(math.exp(START + slope * 0.02) - DARK, 0.03)
        found.append(bench.memory.filtered[0] - START)
    lag = slope * tau * (1.0 - math.exp(-0.02 / tau))
    # cutoff of 10 Hz is reached to 1e-11 at 1e14 Hz from the light
    assert found == pytest.approx([slope * 0.02 - lag * math.exp(-0.03 / tau)] * 2, rel=1e-8)


def test_a_pixel_does_as_it_would_among_its_like() -> None:
    # neighbours that share their light now and then, some of them steady; each as in a picture of its light
    random = np.random.default_rng(5)
    light = np.repeat(random.uniform(5.0, 80.0, (40, COUNT // 2)), 2, axis=1)
    light[:, ::3] = np.repeat(light[::8, ::3], 8, axis=0)
    light[:, -4:] = 100.0
    slow = pixels(follower=300.0, per_lux=3.0, refractory=5e-4)
    mixed = Bench(slow, 100.0)
    for row in light:
        mixed.show(row, 5e-3)
    for pixel in (0, 1, 2, 31, COUNT - 1):
        alone = Bench(slow, 100.0)
        for lux in light[:, pixel]:
            alone.show(float(lux), 5e-3)
        ours, theirs = mixed.events(pixel), alone.events(pixel)
        assert np.array_equal(ours[0], theirs[0])
        assert np.array_equal(ours[1], theirs[1])
        assert len(ours[0]) > 10 or pixel == COUNT - 1
        for name in ("seen", "level", "filtered", "kept", "blind"):
            assert getattr(mixed.memory, name)[pixel] == getattr(alone.memory, name)[pixel]
