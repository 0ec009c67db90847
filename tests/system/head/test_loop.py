"""The loop: a neck of finite speed, pings that are lost, spikes that come too late."""

from dataclasses import replace

import numpy as np
import pytest

from chips.lso.model import head_on
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from system.head.loop import ChipAt, Log, Neck, follow, longest_step, usual_spikes
from system.head.numbers import Motion, SonarHead
from system.head.world import way_of

NUMBERS = SonarHead(ear_noise=0.0, glint=0.0)
CHIP = head_on(Silicon(AMI_1500_IDEAL))


def followed(numbers: SonarHead, duration: float = 1.0, kind: str = "step", **motion: float) -> Log:
    target = Motion(**{"step_at": 0.2, "swing": 0.0} | motion)
    random = np.random.default_rng(0)
    return follow(
        numbers, lambda _: (CHIP, None), way_of(kind, target, duration + 1.0, random), duration, random
    )


def test_the_neck_turns_at_its_speed_and_stops() -> None:
    neck = Neck(0.1, 1.0, 0.5)
    assert [neck.at(t, 2.0) for t in (1.0, 1.1, 1.2, 3.0)] == pytest.approx([0.1, 0.3, 0.5, 0.5])
    assert Neck(0.5, 0.0, 0.1).at(0.1, 2.0) == pytest.approx(0.3)


def test_the_head_turns_to_the_side_and_in_whole_steps() -> None:
    log = followed(NUMBERS)
    assert np.all(log.heard[:2] == 0)  # straight ahead: nothing to tell the ears apart
    assert log.heard[3, 0] > 0 == log.heard[3, 1]
    steps = log.head[-5:] / NUMBERS.neck_step  # it is at rest by then
    assert steps == pytest.approx(np.round(steps), abs=1e-9)
    assert abs(log.error[-1]) < abs(log.error[3])


def test_a_slow_neck_is_late_and_a_short_one_ends() -> None:
    slow = followed(replace(NUMBERS, neck_speed=0.1))
    assert slow.counts["neck_late"] > 3
    short = followed(replace(NUMBERS, neck_most=np.radians(10.0)))
    assert short.counts["neck_ends"] > 0
    assert np.abs(short.head).max() <= np.radians(10.0) + 1e-12


@pytest.mark.parametrize(
    ("change", "distance", "why"),
    [({}, 0.3, "blanked"), ({}, 6.0, "faint"), ({"decision": 0.05}, 1.0, "late")],
)
def test_lost_pings_are_counted(change: dict[str, float], distance: float, why: str) -> None:
    log = followed(replace(NUMBERS, **change), distance=distance)
    assert log.counts[why] == len(log.time) == log.lost.count(why)
    assert not log.heard.any()
    assert not log.head.any()


def test_what_is_behind_the_head_is_lost() -> None:
    turned = replace(NUMBERS, gain=np.radians(60.0), neck_speed=100.0)
    log = followed(turned, azimuth=np.radians(60.0), kind="sine", duration=3.0)
    assert log.counts["behind"] == log.lost.count("behind") > 0


def test_spikes_after_the_decision_are_in_vain() -> None:
    # 6 ms after the call the echo is there, its spikes come until 10 ms
    log = followed(replace(NUMBERS, decision=0.08))
    assert log.counts["late_spikes"] > 0
    assert len(log.spikes) == log.heard.sum() + log.counts["late_spikes"]


def test_steps_that_outlast_the_period_are_counted() -> None:
    # at 15 Hz a period is 67 ms; steps of 70 ms are of no die that was seen
    slow = CHIP._replace(excite_step=np.full_like(CHIP.excite_step, 70e-3))
    way = way_of("step", Motion(), 2.0, np.random.default_rng(0))
    found = [
        follow(replace(NUMBERS, ping_rate=15.0), at, way, 1.0, np.random.default_rng(0)).counts["steps_over"]
        for at in (lambda _: (slow, None), lambda _: (CHIP, None))
    ]
    assert found == [15, 0]


def test_the_longest_step_is_of_the_level_units_that_spiked() -> None:
    level = np.full(CHIP.excite.shape, np.inf)
    assert longest_step(CHIP, level) == 0.0
    level[0, 2] = 1e-3
    expected = 1e-3 + max(CHIP.excite_step[0, 2], CHIP.inhibit_step[1, 2])
    assert longest_step(CHIP, level) == pytest.approx(expected)


def test_one_ear_knows_what_is_usual() -> None:
    assert usual_spikes(NUMBERS, CHIP, 0.7) > usual_spikes(NUMBERS, CHIP) > usual_spikes(NUMBERS, CHIP, 1.4)


def test_each_ping_hears_with_the_chip_at_its_time() -> None:
    warm = head_on(Silicon(AMI_1500_IDEAL, temperature_c=47.0))
    way = way_of("step", Motion(step_at=0.2, swing=0.0), 2.0, np.random.default_rng(0))

    def heard(at: ChipAt) -> Log:
        return follow(NUMBERS, at, way, 1.0, np.random.default_rng(0))

    cold, hot = (heard(lambda _, chip=chip: (chip, None)) for chip in (CHIP, warm))
    moving = heard(lambda time: (CHIP if time < 0.45 else warm, None))
    early = cold.time < 0.45
    for side in range(2):
        spikes, mine = (log.spikes[log.spikes[:, 1] == side, 0] for log in (cold, moving))
        assert np.array_equal(spikes[spikes < 0.45], mine[mine < 0.45])
    assert np.array_equal(cold.head[early], moving.head[early])
    # the first ping at the other temperature: a level unit's comparator is slower or faster
    first = np.flatnonzero(~early)[0]
    levels = [log.levels[(log.levels[:, 0] >= log.time[first])][0, 0] for log in (cold, moving)]
    assert levels[0] != levels[1]
    assert hot.levels[0, 0] - hot.time[0] != cold.levels[0, 0] - cold.time[0]
