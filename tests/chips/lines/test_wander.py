"""Lines of a chip that wander: sizes, what they share, the mean of a ripple, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest

from chips.latency.design import bias_circuit
from chips.latency.errors import usual_design
from chips.latency.model import usual_biases
from chips.lines.wander import Swing, joined, still, swing_of, swung, wander_draws, wander_of
from chips.noise import SiliconNoise
from circuits.circuit import BiasKind, Circuit
from circuits.devices.noise import WHITE_ONLY
from circuits.errors import ParameterError
from circuits.generator.ripple import Ripple
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500
from circuits.silicon.silicon import Silicon

SILICON = Silicon(AMI_1500, die=Die(number=3))
NAMES = ("i_tonic", "i_hold", "i_block", "i_inhibit")  # three pFETs' lines, and four nFETs'
RIPPLE = Ripple(20e-3, 50.0)


def biases(kind: BiasKind) -> Circuit:
    return bias_circuit(usual_biases(usual_design(), kind, AMI_1500))


def test_draws_have_the_size_that_is_stated_and_lines_share_their_masters() -> None:
    noise = SiliconNoise(4)
    wander = wander_of(biases("generator"), NAMES, SILICON, noise)
    lines = wander_draws(wander, SILICON, noise, "chip", 1e-3)
    reach = lines.reach(np.arange(7), np.full(7, 10e-3), np.full(7, 25.0))
    found = np.array([lines.changes(reach, lines.drawn(k), 0.1 * k) for k in range(3000)])
    # 3,000 draws know a deviation to 1.3 %
    assert found.std(axis=0) == pytest.approx(lines.spread(reach), rel=0.06)
    assert np.abs(found.mean(axis=0) / found.std(axis=0)).max() < 0.08
    white, slow = reach.white[:, None] * wander.follow_white, reach.slow[:, None] * wander.follow
    alike = white @ white.T + slow @ slow.T
    asked = alike * 25.0**2 / np.outer(lines.spread(reach), lines.spread(reach))
    apart = ~np.eye(7, dtype=bool)
    assert np.corrcoef(found.T)[apart] == pytest.approx(asked[apart], abs=0.08)
    assert asked[apart].max() > 0.2
    again = [lines.changes(reach, lines.drawn(7), 0.0) for _ in range(2)]
    assert np.array_equal(*again)
    assert not np.array_equal(again[0], lines.changes(reach, lines.drawn(8), 0.0))


def test_white_noise_is_held_by_the_line_s_capacitor() -> None:
    noise = SiliconNoise(4, flicker=WHITE_ONLY)
    lines = wander_draws(wander_of(biases("generator"), NAMES, SILICON, noise), SILICON, noise, "chip", 1e-5)
    short, long = (lines.reach(np.array([1]), np.array([t]), np.ones(1)) for t in (1e-5, 10.0))
    rate = lines.wander.rate[1]
    assert 10.0 / 10.0 < rate < 0.01 / 1e-5
    # k T / C of its own: as much as it ever moves; and S / (2 T)
    assert short.white[0] == pytest.approx(np.sqrt(0.25 * rate), rel=0.01)
    assert long.white[0] == pytest.approx(np.sqrt(0.05), rel=0.02)


def test_a_ripple_is_the_mean_of_a_sine() -> None:
    swing, supply = Swing(2.0 * np.pi * 50.0, 0.4), np.array([3e-4 * np.exp(0.7j)])
    for begin, time in ((0.0, 3e-3), (0.0123, 27e-3)):
        t = np.linspace(begin, begin + time, 20001)
        mean = np.trapezoid(3e-4 * np.sin(swing.pace * t + 0.4 + 0.7), t) / time
        assert swung(swing, supply, begin, np.array([time]))[0] == pytest.approx(mean, rel=1e-6)
    assert not swung(Swing(0.0, 0.0), supply, 0.0, np.ones(1)).any()


def test_a_run_has_one_phase() -> None:
    one, other = (swing_of(SiliconNoise(seed, ripple=RIPPLE)) for seed in (1, 2))
    assert one == swing_of(SiliconNoise(1, ripple=RIPPLE))
    assert one.pace == other.pace == pytest.approx(2.0 * np.pi * 50.0)
    assert one.phase != other.phase


def test_other_kinds_stand_still_and_refuse_a_ripple() -> None:
    for kind in ("gate", "ideal"):
        wander = wander_of(biases(kind), NAMES, SILICON, SiliconNoise(1))
        assert not wander.white.any()
        assert wander.white.size == 7
        assert wander.follow.shape == (7, 0)
        with pytest.raises(
            ParameterError, match=rf"latency_chip\.i_tonic: ripple of 20 mV at 50 Hz on a bias of kind {kind}"
        ):
            wander_of(biases(kind), NAMES, SILICON, SiliconNoise(1, ripple=RIPPLE))
    with pytest.raises(ParameterError, match=r"i_\w+: ripple of 2000 mV .* moves its line by .* mV, must be"):
        wander_of(biases("generator"), NAMES, SILICON, SiliconNoise(1, ripple=Ripple(2.0, 50.0)))


def test_lines_of_two_circuits_are_those_of_one_chip() -> None:
    wander = wander_of(biases("generator"), NAMES, SILICON, SiliconNoise(1))
    both = joined([still(2), wander])
    assert both.white.tolist() == [0.0, 0.0, *wander.white]
    assert np.array_equal(both.follow[2:], wander.follow)
    assert not both.follow[:2].any()
