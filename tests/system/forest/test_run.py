"""The forest as a system: scenario, summary, picture, study."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from circuits.errors import CircuitError
from circuits.silicon.die import Die
from system.cli.command_line import main
from system.forest.run import SUMMARY, SYSTEM, Trace, run, summarise
from system.forest.scenario import Scenario
from system.openspace.map import SIDE
from system.openspace.senses import Sensing
from system.plot import save_picture
from tests.refusals import command_refusals, refusals


@pytest.fixture(scope="module")
def trace() -> Trace:
    return run(Scenario(pings=3000, rows=3000, seed=2))


def test_the_summary(trace: Trace) -> None:
    found = summarise(trace)
    assert tuple(found) == tuple(SUMMARY)
    assert found["pings"] is not None
    assert 0 < found["pings"] <= 3000
    assert found["collided"] in {0.0, 1.0}


def test_the_path_stays_on_the_torus(trace: Trace) -> None:
    assert len(trace.path) == len(trace.first.log) + 1
    assert trace.path.min() >= 0.0
    assert trace.path.max() <= SIDE


def test_dies_and_seeds_are_forests_of_their_own() -> None:
    scenarios = [Scenario(pings=1, seed=s, die=d) for s, d in ((0, Die()), (1, Die()), (0, Die("A", 0)))]
    places = [run(s).first.forest.place for s in scenarios]
    assert not np.array_equal(places[0], places[1])
    assert not np.array_equal(places[0], places[2])
    assert np.array_equal(places[2], run(scenarios[2]).first.forest.place)


def test_options_of_the_command_line() -> None:
    found = SYSTEM.scenario(vmax=1.5, ping_rate=10.0, start="3m, 4.5m", obstacles=900)
    assert found.bat.max_speed == 1.5
    assert found.bat.ping_rate == 10.0
    assert found.start == (3.0, 4.5)
    assert found.obstacles == 900


def test_an_escape_is_the_programs_and_the_chips_alike_and_none_is_the_papers() -> None:
    plain = SYSTEM.on_silicon(ideal=True, escape=0)
    assert plain.arcs.escape == 0
    assert SYSTEM.on_silicon(ideal=True).arcs.escape == SYSTEM.on_silicon().arcs.escape == 2


test_bad_scenarios_are_refused = refusals(
    CircuitError,
    lambda options: SYSTEM.scenario(**options),
    [
        ({"vmax": 0.0}, "vmax: 0 m/s, must be > 0"),
        ({"vmax": float("nan")}, "vmax: nan"),
        ({"ping_rate": -2.0}, "ping_rate: -2 Hz, must be > 0"),
        ({"vmax": 30.0}, "vmax: 30 m/s at 5 Hz is 6 m between pings, must be at most the 5 m"),
        ({"ping_rate": 1e-9}, "must be at most the 5 m that a ping shows"),
        ({"start": "3"}, 'start: "3", must be X,Y'),
        ({"start": "3m,50m"}, 'start: "3m,50m", must be from 0m to below 50m'),
        ({"start": "3m,4"}, "start: .*must be a length in m; write the unit too, as in 4m"),
        ({"start": "3m,1e"}, "start: .*must be a length in m"),
        ({"map": "a.csv", "obstacles": 5}, "obstacles: not with `map`"),
        ({"obstacles": 0}, "obstacles: 0, must be at least 1"),
        ({"obstacles": 9000}, "obstacles: 9000, must fit"),
        ({"pings": 0}, "pings: 0"),
        ({"seed": -1}, "seed: -1"),
        ({"temperature_c": 85.0}, "temperature_c: 85 degC, must be 27: no chip is in the"),
    ],
)


def test_senses_of_the_command_line() -> None:
    options: dict[str, Any] = {
        "ranges": "chip",
        "selection": "chip",
        "azimuth_noise": 2.0,
        "area": 4.0,
        "vmax": 1.0,
    }
    found = SYSTEM.scenario(**options, weights="speed")
    sensing = found.sensing
    assert (sensing.ranges, sensing.selection, sensing.ranging_area) == ("chip", "chip", 4.0)
    assert sensing.azimuth_noise == pytest.approx(np.radians(2.0))
    assert found.bat.ping_bias < SYSTEM.scenario(**options).bat.ping_bias
    with pytest.raises(CircuitError, match="area: no chip is in the loop"):
        SYSTEM.scenario(area=4.0)


def test_silicon_reaches_the_flight() -> None:
    options = {"sensing": Sensing("chip", "chip"), "pings": 300, "rows": 300, "seed": 5}
    cold, warm, again = (run(Scenario(**options, temperature_c=t)) for t in (10.0, 27.0, 27.0))  # type: ignore[arg-type]
    assert summarise(warm) == summarise(again)
    assert not np.array_equal(cold.first.log[:40], warm.first.log[:40])


def test_it_draws(trace: Trace, tmp_path: Path) -> None:
    picture = tmp_path / "path.png"
    save_picture(str(picture), lambda figure: SYSTEM.draw(trace, figure))
    assert picture.stat().st_size > 30_000  # an empty figure has 3 kB, a forest alone more


def test_a_study_with_chips(capsys: pytest.CaptureFixture[str]) -> None:
    options = (
        "montecarlo",
        "forest",
        "-n",
        "2",
        "--metric",
        "avoided",
        "--metric",
        "heard",
        "--no-process-variation",
    )
    chips = ("--param", "ranges=chip", "--param", "selection=chip", "--param", "pings=300", "--json")
    chips += ("--param", "codes=default")  # a calibration of die 1001 takes seconds
    assert main((*options, *chips)) == 0
    values = json.loads(capsys.readouterr().out)["values"]
    assert min(values["heard"]) > 0.0


def test_a_study_of_the_forest(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    path = tmp_path / "wood.csv"
    random = np.random.default_rng(3)
    path.write_text("x_m,y_m\n" + "".join(f"{x},{y}\n" for x, y in SIDE * random.random((2200, 2))))
    options = ("montecarlo", "forest", "-n", "4", "--metric", "avoided", "--metric", "collided", "--json")
    programs = ("--param", "ranges=exact", "--param", "selection=ideal")
    assert main((*options, *programs, "--param", f"map={path}")) == 0
    values = json.loads(capsys.readouterr().out)["values"]
    assert set(values) == {"succeeded", "avoided", "collided"}
    assert values["collided"] == [1.0] * 4  # unplaced obstacles as dense as these leave no way for long
    assert len(set(values["avoided"])) > 1  # a start a die


test_what_a_study_of_the_forest_has_not = command_refusals(
    "montecarlo",
    "forest",
    "-n",
    "2",
    rows=[
        ("--level transistor", "level: transistor, is no choice of forest"),
        (
            "--param ranges=exact --param selection=ideal --bias-kind gate",
            "--bias-kind: gate, no chip is in the loop",
        ),
        ("--param unit=1us", "unit: not an option of forest"),
    ],
)
