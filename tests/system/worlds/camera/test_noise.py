"""Events that nothing seen has made: leak, noise and hot pixels."""

from __future__ import annotations

import math

import numpy as np
import pytest

from system.worlds.camera.pixel import noise_rate
from tests.system.worlds.camera.test_expose import COUNT, THETA_ON, Bench, pixels


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
