"""Events of the chip against the closed forms, and against a membrane that is stepped."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from chips.latency.chip import LatencyChip
from chips.latency.errors import usual_design
from chips.latency.kernel import Charge, Race, crossing, integrate, last_spike, move, race, recall, reset
from chips.latency.law import evaluation_latency, race_latency
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon

CHIP = LatencyChip(usual_design(), silicon=Silicon(AMI_1500_IDEAL))
N, UNITS = 33, 15


@given(
    st.lists(st.tuples(st.floats(0.0, 0.05), st.floats(-1.0, 1.0)), min_size=1, max_size=8),
    st.floats(1e-3, 0.05),
)
@settings(max_examples=40)
def test_a_membrane_is_at_its_charge_where_small_steps_are(
    events: list[tuple[float, float]], charge: float
) -> None:
    time, change = (np.array([e[k] for e in events]) for k in range(2))
    found = crossing(time.copy(), change.copy(), len(events), charge)
    step = 2e-5
    grid = step * np.arange(round((min(found, 0.1)) / step))
    level = highest = 0.0
    for current in (change * (time <= grid[:, None])).sum(axis=1):
        level = max(level + step * float(current), 0.0)
        highest = max(highest, level)
    # every event acts up to a step late, and the last step is cut short
    rounding = step * (len(events) + 1) * np.abs(change).sum()
    assert highest <= charge + rounding
    if found < 0.1:
        assert level >= charge - rounding


def test_latencies_are_those_of_equation_9() -> None:
    spike = np.empty(N)
    arrive, memory = np.array([3e-3, 5e-3, 6e-3, 6e-3]), np.array([4, 7, 4, 4])
    integrate(CHIP.lumped, CHIP.new_memory(), arrive, memory, spike)
    # the charge at the latency is the threshold to rounding
    assert spike[4] == pytest.approx(evaluation_latency([3e-3, 6e-3, 6e-3], 1.0 / 8e-3), rel=1e-9)
    assert spike[7] == pytest.approx(13e-3, rel=1e-9)
    assert math.isinf(spike[0])


def test_inputs_beyond_the_synapses_are_counted() -> None:
    memory = CHIP.new_memory()
    integrate(CHIP.lumped, memory, np.full(10, 3e-3), np.full(10, 2), np.empty(N))
    assert memory.counts.tolist() == [2, 0]


def test_the_race_is_that_of_equation_10() -> None:
    out = np.full(N, math.inf)
    out[15], out[18] = 20e-3, 25e-3
    layers = Race(np.empty(N), np.empty(N), np.empty(N))
    emergency = race(CHIP.lumped, CHIP.new_memory(), out, Charge(16, 5e-3, -1, 0.0), layers)
    assert math.isinf(emergency)
    for p in (14, 16, 20):
        weights = 0.21 / 58e-3 * np.exp(-0.5 * (p - np.array([15, 18])) ** 2)
        inhibitions = [(t, w) for t, w in zip((20e-3, 25e-3), weights, strict=True)]
        near = [(t, float(w)) for (t, w), q in zip(inhibitions, (15, 18), strict=True) if abs(p - q) <= 3]
        charge = 0.08 * math.exp(-((p - 16) ** 2) / 64.0)
        # the reset's and the pulse's 10 us: 0.02 and 0.04 % of a latency
        assert layers.free[p] == pytest.approx(race_latency(1.0 / 58e-3, charge, near), rel=2e-3)
    won = np.flatnonzero(np.isfinite(layers.first))
    assert layers.first[won].max() < layers.first[won].min() + 1.35e-3


def test_a_barred_way_makes_an_emergency() -> None:
    layers = Race(np.empty(N), np.empty(N), np.empty(N))
    out = np.full(N, 5e-3)
    assert race(CHIP.lumped, CHIP.new_memory(), out, Charge(-1, 0.0, -1, 0.0), layers) == pytest.approx(
        68e-3, rel=1e-3
    )


def test_what_coincides_is_repeated_until_a_reset() -> None:
    memory, given_ = CHIP.new_memory(), np.full((N, UNITS), np.nan)
    detected, out, spike = np.empty((N, UNITS)), np.empty(N), np.full(N, math.inf)
    tap = float(np.cumsum(CHIP.lumped.tap)[3])
    spike[5] = tap + 1e-3
    recall(CHIP.lumped, memory, 0.1, spike, given_, detected, out)
    assert out[5] == pytest.approx(tap + 1e-3, abs=20e-6)
    assert np.flatnonzero(np.isfinite(detected[5])).tolist() == [2, 3]  # within 3 ms of both, 3 ms apart
    spike[5] = math.inf
    for k in (2, 3):
        recall(CHIP.lumped, memory, 0.1 * k, spike, given_, detected, out)
        assert out[5] == pytest.approx(tap, abs=20e-6)
    reset(memory, CHIP.lumped.tonic, 0.39)
    recall(CHIP.lumped, memory, 0.4, spike, given_, detected, out)
    assert not np.isfinite(detected).any()


def test_inh_spikes_at_its_period_from_its_release_on() -> None:
    memory = CHIP.new_memory()
    memory.release[0, 0], memory.last[0, 0] = 1.0, 0.7
    assert last_spike(memory, 0, 0, 10e-3, 1.005) == 0.7
    assert last_spike(memory, 0, 0, 10e-3, 1.0351) == pytest.approx(1.03)


def test_what_is_left_of_a_hold_or_a_period_goes_on_at_the_new_current() -> None:
    memory, warm = CHIP.new_memory(), CHIP.at(40.0).lumped
    cold = CHIP.lumped
    now = 0.5
    memory.release[0, 0] = now + 60e-3  # held for 60 ms more
    memory.release[0, 1] = now - 2.5 * cold.tonic[0, 1]  # half through its third period
    move(memory, cold, warm, now)
    assert memory.release[0, 0] - now == pytest.approx(60e-3 * warm.hold[0, 0] / cold.hold[0, 0])
    assert memory.release[0, 0] - now < 55e-3
    assert now - memory.release[0, 1] == pytest.approx(0.5 * warm.tonic[0, 1])
    assert memory.last[0, 1] == pytest.approx(now - 0.5 * cold.tonic[0, 1])
    # there and back again
    move(memory, warm, cold, now)
    assert memory.release[0, 0] - now == pytest.approx(60e-3)
    assert now - memory.release[0, 1] == pytest.approx(0.5 * cold.tonic[0, 1])


@pytest.mark.parametrize(("heard", "alarm"), [(35e-3, False), (20e-3, True)])
def test_all_ways_barred_are_an_emergency_near_by_alone(heard: float, alarm: bool) -> None:
    # every memory at 35 ms, 0.7 of an arc's length away, or at 20 ms, 0.2; by equation (10) the middle cell
    # spikes at (58 - 2.5 0.21 t - 0.18 58) / (1 - 2.5 0.21) ms: 62, before the emergency's 68, or 78
    layers = Race(np.empty(N), np.empty(N), np.empty(N))
    given = Charge(16, 5e-3, int(CHIP.lumped.group[16]), 10e-3)
    emergency = race(CHIP.lumped, CHIP.new_memory(), np.full(N, heard), given, layers)
    assert math.isfinite(emergency) is alarm
    assert layers.free[16] == pytest.approx(78e-3 if alarm else 62e-3, rel=0.02)
