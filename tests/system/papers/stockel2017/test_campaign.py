"""The campaign of Bug robots: conditions, statements that can fail, picture."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import pytest

from system.papers.stockel2017 import campaign
from system.papers.stockel2017.campaign import (
    DESIGN,
    Condition,
    Outcome,
    by_name,
    conditions,
    described,
    drive_one,
    outcome,
)
from system.study.statistics.share import Share
from tests.system.papers.conftest import Draw

ALL = Outcome(Share(10, 10), (55.0,) * 10, (1.2,) * 10, 0)
NONE = Outcome(Share(0, 10), (), (), 7)


def found() -> dict[Condition, Outcome]:
    """As expected, but nowhere else measured."""
    every = {c: ALL for agent in DESIGN for c in conditions(agent)}
    base = Condition("bug0", DESIGN["bug0"])
    for t in (25.0, 29.0):
        every[replace(base, kind="gate", temperature_c=t)] = NONE
    every[Condition("bug2", 1665)] = NONE
    return every


def test_each_condition_is_there_once() -> None:
    every = conditions("bug0")
    assert len(every) == len(set(every)) == 30
    assert Condition("bug0", DESIGN["bug0"]) in every


def test_names_tell_all_conditions_apart() -> None:
    assert list(by_name().values()) == [c for agent in DESIGN for c in conditions(agent)]


def test_a_condition_says_where_it_was_calibrated_and_solved() -> None:
    base = Condition("bug2", DESIGN["bug2"], temperature_c=37.0)
    said = {
        use: (s.calibrated_c, s.solved)
        for use in (campaign.HELD, campaign.SOLVED, campaign.CALIBRATED)
        for s in [replace(base, use=use).scenario(900)]
    }
    assert said == {"held": (27.0, 27.0), "solved": (27.0, 37.0), "calibrated": (37.0, 37.0)}
    assert base.scenario(900).temperature_c == 37.0
    assert base.scenario(900).design == "improved"


def test_statements_hold_and_fail() -> None:
    assert [r.name for r in campaign.rows(found()) if not r.agrees] == []
    assert [r.name for r in campaign.rows(dict.fromkeys(found(), ALL)) if r.agrees] == [
        "bug0_calibrated_7_and_47_degC_ideal_share",
        "bug0_calibrated_7_and_47_degC_gate_share",
        "bug0_area_1_16_share",
    ]
    assert not any(r.agrees for r in campaign.rows(dict.fromkeys(found(), NONE)))


def test_robots_that_always_reach_meet_the_rules_of_enough_and_none_of_fewer() -> None:
    nulls = campaign._nulls(found())
    assert tuple(null.name for null in nulls) == campaign.EXPERIMENT.nulls
    never, always, drawn = (sum(bool(row.agrees) for row in null.rows) for null in nulls)
    assert (never, always) == (0, 3)
    assert drawn < len(campaign.rows(found()))


def test_a_die_drives_and_a_warm_one_does_not(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(campaign, "DURATION", 70.0)
    base = Condition("bug0", DESIGN["bug0"], kind="gate")
    there = outcome([drive_one((described(base), 901))])
    assert there.share == Share(1, 1)
    assert str(there).startswith("1 of 1 (")
    assert there.ratios[0] >= 1.0
    warm = drive_one((described(replace(base, temperature_c=32.0)), 901))
    assert not warm.reached
    cold = drive_one((described(replace(base, use=campaign.SOLVED, temperature_c=7.0)), 901))
    assert (cold.reached, cold.refused) == (False, 1)
    assert outcome([warm, cold]).share == Share(0, 2)
    assert outcome([warm, cold]).refused == 1


def test_it_draws(drawn: Callable[[Draw], int]) -> None:
    assert drawn(lambda figure: campaign._draw(found(), figure)) > 10_000
