"""The closed loop on a chip: it avoids, says what it did, repeats itself, and refuses bad input."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from circuits.errors import CircuitError
from circuits.silicon.die import NOMINAL, Die
from system.papers.conditions import IDEAL_CURRENTS
from system.plot import save_picture, silicon_text
from system.pushbot.brain import GYRO_ANGLE, GyroInputs
from system.pushbot.campaign import drive_each, trials
from system.pushbot.drive import Readings
from system.pushbot.loop import all_spikes, rates
from system.pushbot.run import SUMMARY, SYSTEM, Trace, make_brain, run, run_with, summarise
from system.pushbot.scenario import Scenario, scene_of
from system.study.statistics.share import Share
from system.worlds.camera.event import joined
from tests.pictures import figure_of_files, leaving, legend_of
from tests.refusals import refusals

BASE = Scenario(seed=3, die=Die(number=3), **IDEAL_CURRENTS)


@pytest.fixture(scope="module")
def trace() -> Trace:
    return run(BASE)


def test_it_goes_round_a_blue_block(trace: Trace) -> None:
    found = summarise(trace)
    assert tuple(found) == tuple(SUMMARY)
    assert found["collided"] == 0.0
    assert found["crossed"] == 1.0
    assert found["distance_cm"] is not None
    assert found["distance_cm"] > 0.0
    path = np.array(trace.drive.path)
    # a straight way ahead would run into it
    assert np.abs(path[-1, 2] - path[0, 2]) > 0.0625


def test_one_drive_wins_on_the_side_away_from_the_stronger_obstacle_population(trace: Trace) -> None:
    # until it has turned by 10 degrees; past the block it sees the arena's walls
    path = np.array(trace.drive.path)
    turned = float(path[np.argmax(np.abs(path[:, 3]) > 0.17), 0])
    _, found = rates(trace.brain.network, trace.record, turned)
    left, right = found["DL"].sum(), found["DR"].sum()
    assert max(left, right) > 3.0 * min(left, right)
    assert (left > right) == (path[-1, 2] > path[0, 2])
    assert (left > right) == (found["OR"].sum() > found["OL"].sum())


def test_before_the_block_it_is_quiet_and_drives_at_the_factor_s_speed(trace: Trace) -> None:
    time, found = rates(trace.brain.network, trace.record, 1.0)
    _, whole = rates(trace.brain.network, trace.record, float(trace.drive.path[-1][0]))
    highest = max(whole[name].max() for name in ("DL", "DR"))
    for name in ("DL", "DR"):
        # some far events come in, now and then several at a time: at the worst a ninth of what the drive
        # reaches at the block (31 Hz of 273 in 50 ms)
        assert found[name][:-6].mean() < 10.0
        assert found[name][:-6].max() < 0.2 * highest
    assert found["target"].sum() == 0.0
    # 0.35 m/s at a factor of 0.5 on the nominal die; the refractory period's bias is a die's own
    at = np.searchsorted(np.array(trace.drive.path)[:, 0], (0.8, 1.0))
    x = np.array(trace.drive.path)[at, 1]
    assert (x[1] - x[0]) / 0.2 == pytest.approx(0.35, rel=0.2)
    assert time[-1] == pytest.approx(1.0)


def test_exc_goes_on_to_the_end(trace: Trace) -> None:
    _, found = rates(trace.brain.network, trace.record, float(trace.drive.path[-1][0]))
    assert found["exc"][:-1].min() > 100.0


def test_the_same_key_gives_the_same_run_and_another_seed_another(trace: Trace) -> None:
    short = replace(BASE, duration=0.5)
    first, again, other = (
        run_with(trace.brain, s, scene_of(s), s.read()) for s in (short, short, replace(short, seed=4))
    )
    assert first.drive.path == again.drive.path
    assert np.array_equal(all_spikes(first.record)[0], all_spikes(again.record)[0])
    assert first.record.inputs != other.record.inputs


def test_a_run_ends_after_its_way(trace: Trace) -> None:
    scenario = replace(BASE, way=0.2)
    short = run_with(trace.brain, scenario, scene_of(scenario), scenario.read())
    path = np.array(short.drive.path)
    length = np.hypot(*np.diff(path[:, 1:3], axis=0).T).sum()
    # a look of 50 ms at most beyond, at 0.4 m/s
    assert 0.2 <= short.drive.way < 0.22
    assert short.drive.way == pytest.approx(length, rel=1e-4)
    assert short.drive.path == trace.drive.path[: len(path)]


def test_a_campaign_is_single_runs(trace: Trace) -> None:
    scenarios = trials(replace(BASE, duration=0.3), 2, 1, first=3)
    found = drive_each(scenarios, make=lambda _: trace.brain)
    alone = run_with(trace.brain, scenarios[1], scene_of(scenarios[1]), scenarios[1].read())
    assert found[1] == summarise(alone)
    assert str(Share(1, 4)).startswith("1 of 4 (")


def test_the_chip_is_made_in_the_process_that_is_named() -> None:
    brain = make_brain(replace(BASE, process="coach-180", codes="default"))
    assert brain.chip.silicon.process.pair_a_vt == pytest.approx(6.9e-9, rel=0.01)
    with pytest.raises(CircuitError, match="process: coach, must be one of"):
        run(replace(BASE, process="coach"))


def test_the_modified_architecture_runs() -> None:
    scenario = replace(BASE, modified=True, duration=3.0)
    made = run_with(make_brain(scenario), scenario, scene_of(scenario), scenario.read())
    names = {p.name for p in made.brain.network.populations}
    assert {"GL", "GR"} <= names
    assert all_spikes(made.record)[0].size > 0


def test_turn_factor_is_that_of_the_architecture_unless_given() -> None:
    turns = [
        replace(BASE, modified=modified, turn_factor=given).read().factors.turn
        for modified in (False, True)
        for given in (None, 1.5)
    ]
    assert turns == [0.5, 1.5, 2.0, 1.5]


def test_a_gyro_population_fires_in_a_turn_to_its_side() -> None:
    brain = make_brain(replace(BASE, modified=True, die=NOMINAL))
    assert brain.turning is not None
    inputs = brain.turning()(Readings(joined([]), np.array([[0.0, 1.0]])), 0.0, 0.5)
    spikes, _ = brain.chip.run(brain.chip.at_rest(), 0.6, inputs)
    left, right = (np.isin(spikes.neurons, brain.network[name].neurons).sum() / 8.0 for name in ("GL", "GR"))
    # a robot turns at 1.2 rad/s at most; weaker events than those of the plain network must still do
    assert left > 80.0
    assert right == 0.0


def test_gyro_events_count_the_angle() -> None:
    scenario = replace(BASE, modified=True)
    gyro = GyroInputs(make_brain(scenario).network, 1)
    left = set(gyro.network["GL"].neurons)
    samples = [np.array([[0.0, 1.0]]), *[np.empty((0, 2))] * 3]
    found = [gyro(Readings(joined([]), s), 0.05 * k, 0.05 * (k + 1)) for k, s in enumerate(samples)]
    # 0.2 rad in all, to 16 neurons each; what is left over waits
    assert sum(f.times.size for f in found) == pytest.approx(16 * 0.2 / GYRO_ANGLE, abs=16)
    assert all(set(f.neurons.tolist()) <= left for f in found)


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"scene": "clutter", "way": 0.1, "duration": 5.0}, "succeeded: way of 0.1 m driven"),
        ({"scene": "clutter", "duration": 0.5}, "succeeded: time of 0.5 s over"),
        ({"duration": 0.5}, "failed: time of 0.5 s over"),
        ({}, "succeeded: passed the line of its obstacles"),
        ({"colour": "white"}, "failed: touched block[0]"),
    ],
)
def test_a_run_has_one_reason(change: dict[str, Any], reason: str) -> None:
    assert SYSTEM.account(run(replace(BASE, **change))).headline == reason


def test_the_picture_can_be_drawn(trace: Trace, tmp_path: Path) -> None:
    path = tmp_path / "run.png"
    save_picture(str(path), lambda figure: SYSTEM.draw(trace, figure))
    assert path.stat().st_size > 10_000


def test_the_picture_says_what_it_shows(trace: Trace) -> None:
    figure = figure_of_files()
    SYSTEM.draw(trace, figure)
    above = next(ax for ax in figure.axes if ax.get_ylabel() == "y (m)")
    on = silicon_text(trace.scenario.die, trace.scenario.temperature_c, trace.scenario.bias_kind)
    assert f"ROLLS on {on}" in above.get_title()
    assert {"path", "robot at its start and at 1, 2, ...", "v, forward"} <= legend_of(figure)
    ticks = {t.get_text() for ax in figure.axes for t in ax.get_yticklabels()}
    assert {"OL\nobstacle left", "DR\ndrive right", "sp\nspeed"} <= ticks
    assert any("spikes a neuron" in ax.get_ylabel() for ax in figure.axes)
    assert leaving(figure) == []


test_bad_input_is_refused = refusals(
    CircuitError,
    lambda change: run(replace(Scenario(), **change)),
    [
        ({"speed_factor": 0.0}, "speed_factor: 0, must be above 0"),
        ({"turn_factor": -1.0}, "turn_factor"),
        ({"way": 0.0}, "way: 0 m, must be > 0"),
        ({"scene": "nowhere"}, "scene nowhere: unknown"),
        ({"exc": 60}, "population.target: 128 neurons, must be <="),
        ({"dropped": 1.0}, "dropped"),
        ({"colour": "pink"}, "colour: pink"),
    ],
)
