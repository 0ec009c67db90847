"""Draws of noise currents: normals from words, independent halves of a step, levels of refinement."""

import numpy as np
import pytest

from circuits.circuit import Circuit, Port
from circuits.devices import Capacitor, Resistor
from circuits.devices.noise import WHITE_ONLY
from circuits.lowering.kernel import to_kernel
from circuits.solver.noise.steps import DEEPEST, LARGE_ERROR, SMALL_ERROR, _halve, allowed_error, normal_pair
from circuits.solver.noise.transient import _draws, _plan
from circuits.solver.operating_point import operating_point
from circuits.testbench import Testbench

COUNT = 400  # resistors side by side, each with a draw of its own


def test_normals_of_words() -> None:
    words = np.random.default_rng(1).integers(0, 2**32, (20_000, 2), dtype=np.uint32)
    pairs = np.array([normal_pair(a, b) for a, b in words])
    # 20,000 pairs: a mean scatters by 0.7 %, a variance by 1 %, a kurtosis by 3.5 %; four of these
    assert np.abs(pairs.mean(axis=0)).max() < 0.03
    assert pairs.var(axis=0) == pytest.approx([1.0, 1.0], abs=0.04)
    assert (pairs**4).mean(axis=0) == pytest.approx([3.0, 3.0], abs=0.14 * 3)
    assert abs(np.corrcoef(pairs.T)[0, 1]) < 0.03
    for word in (0, 2**32 - 1):
        assert np.isfinite(normal_pair(word, word)).all()


def test_halves_are_independent_and_keep_the_whole() -> None:
    devices = [Resistor(f"r{k}", "y", "0", 1e3) for k in range(COUNT)]
    circuit = Circuit("many", (Port("y", "analog", "out"),), (*devices, Capacitor("c", "y", "0", 1e-12)))
    machine = to_kernel(Testbench("many", circuit, (), 1.0))
    point = operating_point(machine)
    plan = _plan(point, WHITE_ONLY, 1e-6, machine.kernel.columns)
    draws = _draws(machine, plan, 3, 0)
    first, second, whole = [], [], []
    for number in range(20):
        draws.counters[0, :] = np.uint32(number)
        for level in range(3):
            # the whole of a level: any numbers of the variance that the level has
            random = np.random.default_rng((number, level))
            draws.unit[level] = 2.0 ** (0.5 * level) * random.standard_normal(COUNT)
            _halve(plan, draws, level, number)
            scale = 2.0 ** (-0.5 * level)
            whole.append(scale * draws.unit[level])
            first.append(scale * draws.unit[level + 1])
            second.append(scale * draws.other[level + 1])
    a, b, both = (np.concatenate(x) for x in (first, second, whole))
    np.testing.assert_allclose(0.5 * (a + b), both, atol=1e-12)
    # twice the variance in half the time, so that charges are those of a Brownian path; 24,000 numbers know a
    # variance to 0.9 % and a correlation to 0.65 %: four of these
    assert [a.var(), b.var()] == pytest.approx([2.0, 2.0], rel=0.04)
    assert abs(np.corrcoef(a, b)[0, 1]) < 0.026


def test_errors_are_refined_away_only_so_far() -> None:
    allowed = [allowed_error(level) for level in range(DEEPEST + 1)]
    assert allowed[:SMALL_ERROR] == [1.0] * SMALL_ERROR
    assert allowed[SMALL_ERROR] == 10.0
    assert 1e3 < allowed[LARGE_ERROR] < np.inf
    assert allowed == sorted(allowed)
