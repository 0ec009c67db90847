"""Pixels by themselves: counts, times, refractory period, bandwidth, leak and noise."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from system.dvs_lamp import no_glow
from system.dvs_pixel import Beat, Memory, Pixels, bandwidth, expose, noise_rate, raw_of, settle

F64 = NDArray[np.float64]

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

    def show(self, lux: float, step: float) -> None:
        lamps = np.empty((0, 6))
        expose(self.p, self.memory, np.full(COUNT, lux), no_glow(), lamps, Beat(self.time, step), self.random,
               self.raw)  # fmt: skip
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


def test_less_light_is_slower() -> None:
    # 1/f = 1/300 + 1/(3 lux)
    assert bandwidth(300.0, 3.0, 100.0) == pytest.approx(150.0)
    assert bandwidth(300.0, 3.0, 1.0) == pytest.approx(300.0 / 101.0)


def test_leak_makes_on_events_at_its_rate() -> None:
    rate = 2.0  # Hz
    bench = Bench(pixels(leak=np.full(COUNT, rate * THETA_ON)), 100.0)
    for _ in range(1000):
        bench.show(100.0, 5e-3)
    for pixel in (0, 40):
        times, signs = bench.events(pixel)
        # 5 s at 2 Hz: the tenth at the very end may be missing
        assert len(times) in {9, 10}
        assert np.all(signs == 1)
        # found at a column's turn, every 40 ms
        assert np.diff(times) == pytest.approx(0.5, abs=0.041)


@pytest.mark.parametrize(("lux", "rate"), [(0.0, 10.0), (1.0, 5.0), (9.0, 1.0)])
def test_noise_falls_with_light(lux: float, rate: float) -> None:
    p = pixels(noise=10.0, noise_most=10.0, on=np.full(COUNT, 0.175), off=np.full(COUNT, 0.175))
    assert noise_rate(p, lux) == pytest.approx(rate)
    bench = Bench(p, lux)
    bench.memory.next_noise[0] = 0.0
    for _ in range(2000):
        bench.show(lux, 5e-3)
    expected = rate * COUNT * 10.0
    # Poisson: four sigma; both polarities alike
    assert bench.raw.used[0] == pytest.approx(expected, abs=4.0 * math.sqrt(expected))
    on = (bench.raw.code[: bench.raw.used[0]] & 1).sum()
    assert on == pytest.approx(0.5 * expected, abs=4.0 * math.sqrt(expected))


def test_hot_pixels_fire_alone() -> None:
    bench = Bench(pixels(hot=np.array([5], dtype=np.int64)), 100.0)
    bench.memory.next_noise[1] = 0.0
    for _ in range(1000):
        bench.show(100.0, 5e-3)
    assert set((bench.raw.code[: bench.raw.used[0]] >> 1).tolist()) == {5}
    assert bench.raw.used[0] == pytest.approx(250, abs=4.0 * math.sqrt(250))


def test_events_beyond_the_buffer_count_as_lost() -> None:
    bench = Bench(pixels(), 100.0)
    bench.raw = raw_of(COUNT, 100)
    bench.ramp(START, 1.1, 1, 0.01)
    assert bench.raw.used.tolist() == [100, 5 * COUNT - 100]
