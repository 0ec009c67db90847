"""Noise of the selection: its time beside the linear theory of the transistors, ties, draws, refusals."""

import numpy as np
import pytest

from chips.noise import SiliconNoise
from chips.selection.model import selection
from chips.selection.noise import no_selection_noise, noisy_decide, selection_noise
from chips.selection.whole_kernel import NOBODY
from circuits.blocks.selection.winner_take_all import RELEASE, STANDING, Params, build, decision_testbench
from circuits.devices.noise import WHITE_ONLY
from circuits.errors import ParameterError
from circuits.lowering.kernel import to_kernel
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.noise.event_jitter import event_jitter

SMALL, CELLS = Params(cells=8), 8
SILICON = Silicon(AMI_1500_IDEAL)
CHIP = selection(SILICON, SMALL)
WHITE, ALL = SiliconNoise(1, flicker=WHITE_ONLY), SiliconNoise(1)


def currents(contrast, risk):
    excite, risks = np.full(CELLS, 35e-9), np.full(CELLS, STANDING)
    excite[3], excite[4] = 50e-9, 50e-9 * (1.0 - contrast)
    risks[[2, 5]] = max(risk, STANDING)
    return excite, risks


def decisions(given, noise, count, first=0):
    own, scratch = selection_noise(CHIP, SILICON, noise), np.zeros((4, CELLS))
    return [noisy_decide(CHIP, own, first + k, *given, scratch) for k in range(count)]


@pytest.mark.parametrize("contrast", [0.1, 0.01])
@pytest.mark.parametrize("noise", [WHITE, ALL], ids=["white", "all"])
def test_its_time_scatters_as_that_of_the_transistors(contrast, noise):
    """Within 8 %: 1500 draws know 1.8 %, and the comparators and the risk's slow mirrors are left out."""
    given = currents(contrast, 5e-9)
    found = decisions(given, noise, 1500)
    assert {winner for winner, _, _ in found} == {3}
    times = np.array([time for _, time, _ in found])
    machine = to_kernel(decision_testbench(build(SMALL), *given, RELEASE + 2.0 * times.max(), 5.0), SILICON)
    jitter = event_jitter(machine, "line[3]", noise.flicker, rest=5e-3)
    assert times.std() / jitter.deviation == pytest.approx(1.0, abs=0.08)


def test_noise_decides_what_is_tied():
    """Two equal cells: either of them, and in a time, which there is none without noise."""
    excite, risk = currents(0.0, 0.0)
    scratch = np.zeros((4, CELLS))
    assert noisy_decide(CHIP, no_selection_noise(), 0, excite, risk, scratch)[1] == np.inf
    found = decisions((excite, risk), WHITE, 200)
    winners = np.array([winner for winner, _, _ in found])
    assert 70 < (winners == 3).sum() < 130  # four deviations of 200 fair coins
    assert set(winners) == {3, 4}
    assert all(np.isfinite(time) for _, time, _ in found)


def test_draws_are_of_seed_and_decision_alone():
    given = currents(0.01, 5e-9)
    ahead = decisions(given, WHITE, 5)
    assert decisions(given, WHITE, 2, first=3) == ahead[3:]
    assert len({time for _, time, _ in ahead}) == 5
    assert decisions(given, SiliconNoise(2, flicker=WHITE_ONLY), 1) != ahead[:1]
    quiet = noisy_decide(CHIP, no_selection_noise(), 0, *given, np.zeros((4, CELLS)))
    assert decisions(given, None, 3) == [quiet] * 3


def test_where_nobody_wins_noise_wakes_nobody():
    excite, risk = np.full(CELLS, 1e-9), np.full(CELLS, 50e-9)
    assert [winner for winner, _, _ in decisions((excite, risk), ALL, 20)] == [NOBODY] * 20


def test_larger_devices_have_less_flicker():
    small, large = (selection_noise(CHIP, SILICON, ALL, area) for area in (1.0, 4.0))
    assert large.excite == pytest.approx(0.25 * small.excite)
    assert large.projected == pytest.approx(0.25 * small.projected)
    with pytest.raises(ParameterError, match=r"selection\.area: -1 times the circuit's, must be > 0"):
        selection_noise(CHIP, SILICON, None, -1.0)
