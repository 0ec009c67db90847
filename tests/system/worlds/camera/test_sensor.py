"""The sensor on its way: silicon, determinism, polarity, light and lights."""

from __future__ import annotations

import math
import pickle
from dataclasses import replace

import numpy as np
import pytest

from circuits.errors import ParameterError
from circuits.silicon.die import Die
from system.worlds.arena.file import load_scene
from system.worlds.arena.scene import Led, recoloured
from system.worlds.camera.event import Events, joined
from system.worlds.camera.sensor import (
    Dvs,
    Eye,
    Segment,
    Sensor,
    advance,
    open_eye,
    picture,
    pixels_of,
    sensor_of,
)
from tests.refusals import refusals

QUIET = Dvs(noise=0.0, leak=0.0, hot_share=0.0)
BARE = replace(load_scene("single-block"), walls=())  # a block on white, before white


def opened(
    dvs: Dvs = QUIET, *, scene: str = "single-block", seed: int = 1, die: int | None = 1003
) -> tuple[Sensor, Eye]:
    place = BARE if scene == "bare" else load_scene(scene, seed=seed)
    sensor = sensor_of(dvs, place, Die(number=die))
    return sensor, open_eye(sensor, seed, place.start)


def same(a: Events, b: Events) -> bool:
    return (
        all(np.array_equal(getattr(a, n), getattr(b, n)) for n in ("time", "x", "y", "on"))
        and a.lost == b.lost
    )


def test_thresholds_scatter_as_they_should_and_are_the_dies() -> None:
    dvs = Dvs()
    p, again, other = (pixels_of(dvs, Die(number=k)) for k in (1003, 1003, 1004))
    count = 128 * 128
    for theta, mean in ((p.on, 0.242), (p.off, 0.211)):
        # four sigma of the mean and of the deviation of so many normal draws
        assert theta.mean() == pytest.approx(mean, abs=4.0 * 0.03 / math.sqrt(count))
        assert theta.std() == pytest.approx(0.03, rel=4.0 / math.sqrt(2.0 * count))
    assert abs(np.corrcoef(p.on, p.off)[0, 1]) < 4.0 / math.sqrt(count)
    assert np.array_equal(p.on, again.on)
    assert not np.array_equal(p.on, other.on)
    assert len(p.hot) == pytest.approx(2e-4 * count, abs=4.0 * math.sqrt(2e-4 * count))


def test_the_nominal_die_has_no_mismatch() -> None:
    p = pixels_of(Dvs())
    assert np.all(p.on == 0.242)
    assert np.all(p.off == 0.211)
    assert len(p.hot) == 0


def test_nothing_moves_nothing_happens() -> None:
    sensor, eye = opened()
    assert len(advance(sensor, eye, Segment(0.1))) == 0


def test_a_seed_is_a_run_and_a_die_is_another_thing() -> None:
    runs = [
        advance(*opened(Dvs(), seed=seed, die=die), Segment(0.2, 0.35, 0.3))
        for seed, die in ((1, 1003), (1, 1003), (2, 1003), (1, 1004))
    ]
    assert len(runs[0]) > 100
    assert same(runs[0], runs[1])
    assert not same(runs[0], runs[2])
    assert not same(runs[0], runs[3])


def test_a_way_in_parts_is_the_way() -> None:
    whole = advance(*opened(Dvs(), scene="target"), Segment(0.2, 0.35, 0.3))
    sensor, eye = opened(Dvs(), scene="target")
    parts = joined([advance(sensor, eye, Segment(0.005 * n, 0.35, 0.3)) for n in (1, 3, 16, 20)])
    assert same(whole, parts)


def test_states_pickle() -> None:
    sensor, eye = opened(Dvs())
    advance(sensor, eye, Segment(0.05, 0.35))
    copy = pickle.loads(pickle.dumps(eye))
    assert same(advance(sensor, eye, Segment(0.05, 0.35)), advance(sensor, copy, Segment(0.05, 0.35)))


def test_events_are_in_order_and_in_time() -> None:
    events = advance(*opened(Dvs()), Segment(0.2, 0.35, 1.0))
    assert np.all(np.diff(events.time) >= 0.0)
    assert events.time.min() >= 0.0
    assert events.time.max() <= 0.2 + 256 / 200e3
    assert events.x.min() >= 0
    assert events.y.max() < 128


def test_a_dark_block_coming_nearer_makes_off_events_at_its_edges() -> None:
    sensor, eye = opened(scene="bare")
    events = advance(sensor, eye, Segment(1.0, 0.35))
    assert (~events.on).mean() > 0.95
    scale = sensor.camera.focal / (
        1.4 - 0.0125 - 0.4 - 0.04 - 0.35
    )  # pixels per m at the front's last distance
    assert np.all(np.abs(events.x - 63.5) <= 0.5 + 0.0125 * scale)
    assert events.y.min() >= math.floor(64.0 - 0.075 * scale)
    assert events.y.max() <= math.floor(64.0 + 0.025 * scale)


def test_events_are_the_edges_way_times_their_contrast() -> None:
    # nominal die, no refractory period, fast pixels: no pixel goes back on this way, so that the change of
    # each between both pictures, in whole thresholds, is the number of its events
    dvs = replace(QUIET, refractory=0.0, follower=1e9, per_lux=1e9)
    sensor, eye = opened(dvs, scene="bare", die=None)
    before = picture(sensor, eye)
    events = advance(sensor, eye, Segment(1.0, 0.35))
    after = picture(sensor, eye)
    change = np.log(after + dvs.dark) - np.log(before + dvs.dark)
    expected = np.floor(-change[change < -1e-9] / dvs.threshold_off + 1e-6).sum()
    assert (~events.on).sum() == pytest.approx(expected, abs=2)  # crossings within rounding of the end


def test_colours_make_events_by_contrast() -> None:
    scenes = {colour: recoloured(BARE, colour) for colour in ("blue", "red", "yellow")}
    scenes["faint"] = replace(BARE, bodies=tuple(replace(b, reflectance=0.72) for b in BARE.bodies))
    counts = {}
    for colour, scene in scenes.items():
        sensor = sensor_of(QUIET, scene, Die(number=1003))
        eye = open_eye(sensor, 1, BARE.start)
        counts[colour] = len(advance(sensor, eye, Segment(1.0, 0.35)))
    assert counts["blue"] > 1.8 * counts["red"]  # 8 thresholds of contrast to 3
    assert counts["red"] > 1.5 * counts["yellow"]  # and to 2
    assert counts["red"] > 3.0 * counts["faint"]  # which is below the mean threshold
    assert counts["yellow"] > counts["faint"]


def test_events_go_with_the_way_and_not_with_time() -> None:
    counts = [len(advance(*opened(scene="bare"), Segment(0.35 / v, v))) for v in (0.35, 0.07)]
    # the same pictures pass at a fifth of the speed; slow pixels see a little more of them
    assert counts[1] == pytest.approx(counts[0], rel=0.1)


def test_darkness_is_noisy() -> None:
    counts = []
    for light in ("normal", "very-dark"):
        scene = replace(BARE, light=1.0 if light == "very-dark" else 500.0)
        sensor = sensor_of(Dvs(hot_share=0.0), scene, Die(number=1003))
        counts.append(len(advance(sensor, open_eye(sensor, 1, scene.start), Segment(0.5))))
    assert counts[1] > 10 * counts[0] > 0


def test_the_led_is_the_brightest_place_and_blinks_at_200_hz() -> None:
    scene = load_scene("target")
    sensor = sensor_of(QUIET, scene, Die(number=1003))
    eye = open_eye(sensor, 1, scene.start)
    advance(sensor, eye, Segment(0.05))
    events = advance(sensor, eye, Segment(0.5))
    ahead, left = 2.0 - 0.5 - 0.04, 0.4
    x = 64.0 - sensor.camera.focal * left / ahead
    y = 64.0 + sensor.camera.focal * (0.11 - 0.075) / ahead
    assert len(events) > 0
    # blurred by 0.8 pixels it makes events up to three pixels from its middle
    assert np.abs(events.x + 0.5 - x).max() < 3.5
    assert np.abs(events.y + 0.5 - y).max() < 3.5
    assert (events.x.mean() + 0.5, events.y.mean() + 0.5) == pytest.approx((x, y), abs=0.5)
    # on events follow the light going on, off events its going off after 75 % of 5 ms
    phase = events.time % 5e-3
    assert np.median(phase[events.on]) < 3.75e-3
    assert np.median(phase[~events.on]) > 3.75e-3
    one = (events.x == events.x[0]) & (events.y == events.y[0])
    assert len(np.unique(np.floor(events.time[one & events.on] / 5e-3))) == pytest.approx(100, abs=1)


def test_a_block_before_the_led_hides_it() -> None:
    scene = load_scene("target")
    robot = replace(scene.bodies[0], at=(2.0, 0.8), led=Led(height=0.09))
    block = replace(load_scene("pair").bodies[0], at=(1.4, 0.8))
    for bodies, sees in (((robot, block), False), ((robot,), True)):
        place = replace(scene, bodies=bodies)
        sensor = sensor_of(QUIET, place, Die(number=1003))
        events = advance(sensor, open_eye(sensor, 1, place.start), Segment(0.1))
        assert (len(events) > 0) is sees


def test_a_fast_turn_loses_events_on_a_slow_bus() -> None:
    slow = replace(QUIET, bus_rate=5e3, bus_depth=16)
    events = advance(*opened(slow), Segment(0.2, 0.0, 2.0))
    free = advance(*opened(replace(QUIET, bus_rate=1e9)), Segment(0.2, 0.0, 2.0))
    assert events.lost > 0
    assert len(events) == pytest.approx(0.2 * 5e3 + 16, abs=60)  # busy from soon after the start on
    assert len(events) + events.lost == len(free)


@pytest.mark.parametrize("duration", [0.0, 0.004, 0.0124, -1.0])
def test_segments_are_whole_steps(duration: float) -> None:
    with pytest.raises(ParameterError, match=r"^duration: .* s, must be a whole number of sensor steps"):
        advance(*opened(), Segment(duration, 0.35))


test_numbers_are_checked = refusals(
    ParameterError,
    lambda changes: Dvs(**changes),
    [
        ({"threshold_on": 0.0}, r"dvs\.threshold_on: 0, must be > 0"),
        ({"noise": -1.0}, r"dvs\.noise: -1, must be >= 0"),
        ({"hot_share": 1.0}, r"dvs\.hot_share: 1, must be"),
        ({"field": math.pi}, r"dvs\.field: 180 degrees"),
        ({"bus_rate": math.inf}, r"dvs\.bus_rate: inf"),
    ],
)
