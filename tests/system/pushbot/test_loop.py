"""When a target counts as lost, and what a lost one changes."""

from dataclasses import replace

import numpy as np

from chips.rolls.chip import Spikes
from system.papers.conditions import IDEAL_CURRENTS
from system.pushbot.brain import Architecture, brain_of, strengthened
from system.pushbot.loop import is_lost
from system.pushbot.run import make_brain, run_with
from system.pushbot.scenario import Scenario, scene_of
from system.worlds.camera.event import Events

NETWORK = brain_of(Architecture(target=True)).network
FIELD = NETWORK["target"].neurons


def events(column: int, row: int, count: int) -> Events:
    return Events(
        np.linspace(0.0, 0.05, count), np.full(count, column), np.full(count, row), np.ones(count, np.bool_)
    )


def test_a_target_is_lost_without_a_bump_or_without_its_events() -> None:
    bump = Spikes(np.linspace(0.0, 0.05, 50), np.full(50, FIELD[40]))
    assert not is_lost(NETWORK, events(41, 70, 30), bump)
    assert is_lost(NETWORK, events(41, 30, 30), bump)  # of the lower half
    assert is_lost(NETWORK, events(60, 70, 30), bump)
    assert is_lost(NETWORK, events(41, 70, 3), bump)
    assert is_lost(NETWORK, events(41, 70, 30), Spikes(np.empty(0), np.empty(0, np.int64)))


def test_raised_weights_are_the_field_s_alone() -> None:
    changed = strengthened(NETWORK).levels() != NETWORK.levels()
    inside = np.zeros((256, 256), dtype=np.bool_)
    inside[np.ix_(FIELD, FIELD)] = True
    assert changed[inside].any()
    assert not changed[~inside].any()


def test_lateral_weights_are_raised_where_there_is_nothing_to_see() -> None:
    base = Scenario(scene="single-block", target=True, raise_lateral=True, duration=0.3)
    trace = run_with(make_brain(base), base, scene_of(base), base.read())
    assert trace.record.raised > 0.1
    plain = replace(base, raise_lateral=False)
    assert run_with(make_brain(plain), plain, scene_of(plain), plain.read()).record.raised == 0.0


def test_spikes_can_drive_the_motors() -> None:
    base = Scenario(readout="spikes", duration=0.5, **IDEAL_CURRENTS)
    trace = run_with(make_brain(base), base, scene_of(base), base.read())
    assert len(trace.record.commands) == 100  # one a step of 5 ms
    path = np.array(trace.drive.path)
    # speed factor 0.5 is about 0.35 m/s; of the last 0.2 s
    speed = (path[-1, 1] - path[-41, 1]) / 0.2
    assert abs(speed - 0.35) < 0.07
