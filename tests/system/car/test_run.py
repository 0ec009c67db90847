"""The robot system: options, runs that repeat, senses one by one, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest

from circuits.arrays import F64
from circuits.errors import ParameterError
from circuits.silicon.die import Die
from system.car.numbers import ARCS
from system.car.run import ENDS, SUMMARY, SYSTEM, Trace, run, sonar_of, summarise
from system.car.scenario import Scenario
from system.car.sonar import Sonar, _ranges
from system.openspace.population import forget, hear_ping
from system.openspace.state import ECHOES
from tests.refusals import refusals

PINGS = 60


def short(**options: object) -> Trace:
    return run(Scenario(**{"forest": "dense", "pings": PINGS, **options}))  # type: ignore[arg-type] # fields of mixed types


def test_a_run_repeats_and_a_seed_changes_it() -> None:
    one, same, other = short(seed=3), short(seed=3), short(seed=4)
    assert np.array_equal(one.drive.log, same.drive.log)
    assert one.drive.counts == same.drive.counts
    assert not np.array_equal(one.forest.place, other.forest.place)


def test_the_senses_see_the_same_forest() -> None:
    flight, exact = short(seed=3), short(seed=3, ranges="exact")
    assert np.array_equal(flight.forest.place, exact.forest.place)
    assert flight.drive.log[0, 1:4] == pytest.approx(exact.drive.log[0, 1:4])
    assert flight.scenario.senses == dict.fromkeys(("occlusion", "multipath", "soft_pings"), True)
    assert exact.scenario.senses == dict.fromkeys(("occlusion", "multipath", "soft_pings"), False)


def test_each_sense_can_be_switched_off() -> None:
    usual = short(seed=5)
    assert usual.drive.counts["soft_pings"] > 0
    assert usual.drive.counts["occluded"] > 0
    assert short(seed=5, soft_pings=False).drive.counts["soft_pings"] == 0
    assert short(seed=5, occlusion=False).drive.counts["occluded"] == 0


def test_a_die_of_the_chip_has_its_own_ranges() -> None:
    logs = [short(seed=3, ranges="chip", die=d).drive.log for d in (Die(), Die(number=1000))]
    assert logs[0].shape != logs[1].shape or not np.array_equal(*logs)


def test_the_summary() -> None:
    found = summarise(short(seed=3))
    assert tuple(found) == tuple(SUMMARY)
    assert sum(found[name] or 0.0 for name in ENDS) == 1.0
    assert found["pings"] == PINGS


def test_speed_and_rate_are_the_robots() -> None:
    s = SYSTEM.scenario(vmax=0.05, ping_rate=6.0, start="-0.5m,0.1m", forest="open")
    assert (s.robot.max_speed, s.robot.ping_rate, s.start) == (0.05, 6.0, (-0.5, 0.1))
    trace = run(s.__class__(robot=s.robot, start=s.start, forest="open", pings=1))
    assert trace.path[0] == pytest.approx([-0.5, 0.1])
    assert trace.drive.time >= 1.0 / 6.0
    assert len(trace.arcs.curvature) == ARCS


def test_a_study_has_the_chip() -> None:
    assert SYSTEM.study_options("behavioural", "ideal", {"forest": "open"}) == {
        "ranges": "chip", "forest": "open", "bias_kind": "ideal",
    }  # fmt: skip
    with pytest.raises(ParameterError, match="level"):
        SYSTEM.study_options("transistor", None, {})
    with pytest.raises(ParameterError, match="map: not an option"):
        SYSTEM.study_options("behavioural", None, {"map": "x"})


test_what_is_refused = refusals(
    ParameterError,
    lambda options: Scenario(**options),
    [
        ({"forest": "wood"}, "forest: wood, must be corridor, open or dense"),
        ({"ranges": "radar"}, "ranges: radar, must be flight, exact or chip"),
        ({"ranges": "exact", "multipath": True}, "multipath: not with `ranges=exact`"),
        ({"ranges": "chip", "codes": "best"}, "codes: best, must be calibrated, default, or a file"),
        ({"codes": "default"}, "codes: default, no chip is in the loop"),
        ({"bias_kind": "ideal"}, "bias_kind: ideal, no chip is in the loop"),
        ({"temperature_c": 40.0}, "temperature_c: 40.0, no chip is in the loop"),
        ({"die": Die(number=3)}, "die: .*, no chip is in the loop"),
        ({"pings": 0}, "pings: 0, must be >= 1"),
        ({"seed": -1}, "seed: -1, must be >= 0"),
    ],
)


@pytest.mark.parametrize("options", [{"vmax": 0.0}, {"ping_rate": -3.0}, {"vmax": float("nan")}])
def test_rates_are_positive(options: dict[str, float]) -> None:
    with pytest.raises(ParameterError, match="must be > 0 and finite"):
        SYSTEM.scenario(**options)


@pytest.mark.parametrize("text", ["", "1", "1,2,3", "a,b", "1,nan", "1e,2"])
def test_a_place_is_two_numbers(text: str) -> None:
    with pytest.raises(ParameterError, match=r"start: .*must be (X,Y|a length in m)"):
        SYSTEM.scenario(start=text)


def test_a_ping_reads_ranges_at_the_temperature_of_its_time() -> None:
    chip = {"ranges": "chip", "die": Die(number=1000), "silicon_noise": "off"}
    warming = Scenario(**chip, course=((0.0, 27.0), (10.0, 37.0)))  # type: ignore[arg-type]
    at, unsure = sonar_of(warming, np.random.default_rng(0))
    assert at is not None
    for time, celsius in ((0.0, 27.0), (10.0, 37.0)):
        still = Scenario(**chip, temperature_c=celsius)  # type: ignore[arg-type]
        expected, doubts = sonar_of(still, np.random.default_rng(0))
        assert expected is not None
        assert np.array_equal(read(at(time)), read(expected(time)))
        assert unsure == doubts or time > 0.0
    assert not np.array_equal(read(at(0.0)), read(at(10.0)))


def read(sonar: Sonar) -> F64:
    """Readings of a ping's echoes on a chip at rest, s."""
    heard = np.linspace(2e-3, 20e-3, 5)
    forget(sonar.population)
    sonar.population.echo[:5, 0] = heard
    hear_ping(sonar.population, 0.5, 5)
    return sonar.population.echo[:5, 1].copy()


def test_echoes_of_a_ping_for_which_there_is_no_room_are_missed() -> None:
    at, _ = sonar_of(Scenario(ranges="chip", die=Die(number=1000)), np.random.default_rng(0))
    assert at is not None
    found, missed = _ranges(at(0.0), np.linspace(3e-3, 12e-3, ECHOES + 10), 0.0)
    assert np.isnan(found[ECHOES:]).all()
    assert missed == np.isnan(found).sum() >= 10
