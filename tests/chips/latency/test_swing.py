"""Where drains stand under the full law, and what leaks: against sums over the swing and the law itself."""

import numpy as np
import pytest

from chips.latency.design import REFERENCE
from chips.latency.swing import (
    detector_threshold,
    halfway,
    idle_inhibition,
    swing_current,
    taken_at,
)
from circuits.blocks.latency import coincidence, race
from circuits.lowering.on_die import standing
from circuits.silicon.process import AMI_1500, AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon

FULL = Silicon(AMI_1500, 60.0)
CELL = race.build()


def test_halfway_stands_for_the_whole_swing() -> None:
    d, gate = standing(CELL, FULL), np.array([1.0])
    volts = REFERENCE * (np.arange(200) + 0.5) / 200
    slowness = np.mean([1.0 / d.current("mp", gate, d.v_dd - v) for v in volts])
    assert swing_current(d, "mp", gate) == pytest.approx(1.0 / slowness, rel=1e-5)
    ends = [d.current("mp", gate, d.v_dd - v).item() for v in (0.0, REFERENCE)]
    assert ends[0] > 1.005 * ends[1]  # which would be off by that


def test_nothing_leaks_under_the_ideal_law() -> None:
    d = standing(CELL, Silicon(AMI_1500_IDEAL, 60.0))
    assert d.idle("mz", "mx", drain=1.0) == 0.0
    assert idle_inhibition(d, "inhibit0.", d.gate["v_inh"]) == 0.0
    assert swing_current(d, "mp", np.array(1.0)) == d.saturated("mp", np.array(1.0))


def test_an_inhibition_that_is_off_takes_less_than_its_switch_alone() -> None:
    d = standing(CELL, FULL)
    switch = d.current("inhibit0.ms", 0.0, halfway("n", d.v_dd)).item()
    weak, strong = (np.asarray(idle_inhibition(d, "inhibit0.", np.array(g))).item() for g in (0.0, 0.7))
    assert 0.0 < weak < 0.1 * switch  # which is 16 times as wide over its length
    # above it stands a node of some U_T, and its switch has little Early effect
    assert 0.9 * switch < strong < switch


def test_a_detector_takes_its_share_of_an_input() -> None:
    d = standing(coincidence.build(), FULL)
    at, gate = detector_threshold(FULL), d.below("v_exc")
    assert 1.0 < at < 3.0
    seen = d.current("input0.me", gate, d.v_dd - at)
    assert taken_at(d, gate, at) == pytest.approx(coincidence.SHARE * seen, rel=0.02)
