"""Estimates of a configuration against scipy's quantiles and simulated Poisson events."""

from __future__ import annotations

import math
from concurrent.futures import ThreadPoolExecutor
from contextlib import nullcontext
from pathlib import Path
from threading import Event

import numpy as np
import pytest

from circuits.errors import ParameterError
from system.forest import campaign as forest_campaign
from system.forest.campaign import Case, Limits, Tally, differ_p, fly_all, mean_avoided
from system.openspace.flight import Sample
from system.openspace.law import Bat
from system.study.campaign import ALONE, Execution, Workers

FAST = Case(Bat(max_speed=5.0), 1700)


def tally(avoided: int, collisions: int, censored: int = 0) -> Tally:
    def sample(n: int, *, collided: bool) -> Sample:
        return Sample(n, collided, 1, 0.0, 0.0, 0, 1, 0, 0, 0)

    each = [sample(0, collided=True)] * collisions + [sample(0, collided=False)] * censored
    return Tally(Case(), (sample(avoided, collided=False), *each))


def test_the_interval_covers_what_it_says() -> None:
    random = np.random.default_rng(1)
    hits = sum(100.0 in mean_avoided(1000, int(random.poisson(10.0))).interval for _ in range(1000))
    # exact intervals of counts cover at least 95 %, here 96.5 %; 3.5 standard errors below 95 % is 926
    assert hits > 926


def test_published_ends_of_a_poisson_interval() -> None:
    # Garwood (1936): with 10 events 4.795 to 18.39
    found = mean_avoided(1000, 10)
    assert found.value == 100.0
    assert 1000 / found.interval.high == pytest.approx(4.795, abs=1e-3)
    assert 1000 / found.interval.low == pytest.approx(18.39, abs=5e-3)


def test_without_a_collision_there_is_a_lower_end() -> None:
    found = mean_avoided(1000, 0)
    assert math.isinf(found.value)
    assert math.isinf(found.interval.high)
    assert found.interval.low == pytest.approx(1000 / 3.689, rel=1e-3)


def test_configurations_that_differ() -> None:
    assert differ_p(tally(1000, 100), tally(2000, 100)) < 1e-5
    assert differ_p(tally(1000, 100), tally(1050, 100)) > 0.5
    assert differ_p(tally(1000, 0), tally(1000, 0)) == 1.0
    # equal means in unequal exposures
    assert differ_p(tally(1000, 10), tally(10_000, 100)) == pytest.approx(1.0, abs=0.3)


def fly_case(case: Case, limits: Limits, execution: Execution = ALONE) -> Tally:
    return fly_all(execution, "ours", {"one": case}, limits, lambda _: None)["one"]


def test_a_configuration_ends_at_its_collisions_whoever_flies() -> None:
    limits = Limits(13, 10_000_000)
    with ThreadPoolExecutor(2) as executor:
        two = Workers(executor.submit, 4, Event())
        found = fly_case(FAST, limits, Execution(workers=lambda: nullcontext(two)))
    one = fly_case(FAST, limits)
    assert one == found
    assert one.collisions == 13
    assert one.samples[-1].collided
    assert one.censored == 0
    assert one.mean.value == one.avoided / 13


def test_a_configuration_ends_at_its_pings() -> None:
    found = fly_case(Case(Bat(max_speed=0.5), 100), Limits(200, 4000))
    assert 4000 - 10 < found.pings <= 4000
    assert found.censored > 0


def test_more_collisions_lengthen_a_kept_campaign(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file, pings = tmp_path / "a.jsonl", 10_000_000
    few = fly_case(FAST, Limits(13, pings), Execution(file))
    groups = len(file.read_text().splitlines()) - 1
    more = fly_case(FAST, Limits(21, pings), Execution(file, resume=True))
    assert more == fly_case(FAST, Limits(21, pings))
    assert more.samples[:13] == few.samples
    monkeypatch.setattr(forest_campaign, "fly_sample", None)
    assert fly_case(FAST, Limits(21, pings), Execution(file, resume=True)) == more  # none is flown again
    assert len(file.read_text().splitlines()) - 1 > groups >= 13
    with pytest.raises(ParameterError, match="other numbers"):
        fly_case(Case(Bat(max_speed=4.0), 1700), Limits(13, pings), Execution(file, resume=True))


def test_other_seeds_are_other_samples() -> None:
    one, other = (fly_case(FAST, Limits(5, 10**6, first)) for first in (0, 50))
    assert one.samples != other.samples


@pytest.mark.parametrize("limits", [(0, 100), (1, 5)])
def test_limits_that_are_none(limits: tuple[int, int]) -> None:
    with pytest.raises(ParameterError, match="limits: "):
        Limits(*limits)
