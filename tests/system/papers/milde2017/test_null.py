"""Null robots in the place of the Pushbot: what each experiment's rules let them pass, of made-up runs."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from system.experiment import Report
from system.papers.milde2017 import (
    chase,
    clutter,
    fig6,
    fig7,
    moving,
    office,
    pairs,
    table1,
    target,
    temperature,
    variability,
)
from system.papers.milde2017.avoided import avoided
from system.papers.milde2017.null import ROBOTS, runs_of
from system.pushbot.campaign import Summary
from system.statement import Statement
from system.verdict.null import PAPER, Null, nulls_of

FREE: Summary = {
    "collided": 0.0, "crossed": 1.0, "between": 0.0, "distance_cm": 5.0, "passed": 1.0, "path_m": 20.0,
    "time_s": 60.0, "stood": 0.0, "walked_into": 0.0, "reached": 1.0, "touched_block": 0.0,
    "touched_robot": 0.0, "touched_wall": 0.0, "touched_visible": 0.0, "touched_early": 0.0,
}  # fmt: skip
HIT: Summary = FREE | {"collided": 1.0, "touched_visible": 1.0, "touched_block": 1.0, "touched_early": 1.0}


def runs(count: int, **told: float | None) -> list[Summary]:
    return [FREE | told for _ in range(count)]


def held(rows: Sequence[Statement], nulls: Sequence[Null]) -> dict[str, int]:
    """Rows that hold, by ours and the nulls' names."""
    scores = Report(tuple(rows), lambda _: None, nulls=tuple(nulls)).scores
    return {score.name: score.held for score in scores if score.name != PAPER}


def test_who_stands_touches_no_block_but_gets_round_none() -> None:
    found = {"pair": runs(20), "triple": runs(20), "triple-loose": runs(20)}
    assert held(pairs.rows(found), nulls_of(pairs.rows, pairs._nulls(found))) == {
        "ours": 5, "always collides": 0, "never moves": 3, "drives straight on": 1,
    }  # fmt: skip


def test_two_cups_do_not_tell_who_avoids_them() -> None:
    told = {(world, f): runs(100) for f in moving.FACTORS for world in (moving.pushed, moving.standing)}
    told |= {(moving.scene_of, moving.OWN): runs(100)}
    found = {name: moving._pairs(each) for name, each in runs_of(ROBOTS, told).items()}
    assert held(moving.rows(moving._pairs(told)), nulls_of(moving.rows, found)) == {
        "ours": 5, "always collides": 5, "never moves": 5,
    }  # fmt: skip


def test_light_and_colour_are_met_by_all_but_the_row_that_asks_for_the_other() -> None:
    found = {(a, b): runs(10) for a in fig7.LIGHTS for b in fig7.BLOCKS}
    found |= {("normal", "yellow"): [HIT] * 10, ("very-dark", "yellow"): [HIT] * 10}
    nulls = {name: avoided(each) for name, each in runs_of(fig7.NULLS, found).items()}
    assert held(fig7.rows(avoided(found)), nulls_of(fig7.rows, nulls)) == {
        "ours": 5, "always collides": 4, "never moves": 4, "always gets past": 4,
    }  # fmt: skip


def test_a_target_is_reached_by_no_null() -> None:
    found = {"target": runs(10), "obstacle-against-target": runs(10)}
    nulls = nulls_of(lambda each: target.rows(*each.values()), runs_of(target.NULLS, found))
    assert held(target.rows(*found.values()), nulls) == {
        "ours": 3, "always collides": 0, "never moves": 1, "drives straight on": 1,
    }  # fmt: skip


def test_the_papers_own_runs_meet_the_rules() -> None:
    shown = {name: [pairs.PAPER_RUN] * pairs.PAPER_RUNS for name in pairs.SCENES}
    assert all(row.agrees for row in pairs.rows(shown))
    assert [row.shown for row in target.rows(target.PAPER, target.PAPER[:1])] == [
        "10 of 10 (69 to 100 %)", "8 of 10 (44 to 97 %)", "1 of 1 (3 to 100 %)"
    ]  # fmt: skip
    assert all(row.agrees for row in target.rows(target.PAPER, target.PAPER[:1]))


def test_drift_is_met_by_no_null_and_crashes_by_one_that_stands() -> None:
    found = {(kind, t): runs(10) for kind in temperature.KINDS for t in temperature.TEMPERATURES}
    found |= {("gate", t): [HIT] * 10 for t in temperature.ENDS}
    nulls = {name: avoided(each) for name, each in runs_of(ROBOTS, found).items()}
    ours = temperature.rows(avoided(found))
    assert held(ours, nulls_of(temperature.rows, nulls)) == {
        "ours": 2, "always collides": 0, "never moves": 0,
    }  # fmt: skip
    normal = {"normal": runs(20)}
    assert held(office.rows(normal), nulls_of(office.rows, runs_of(ROBOTS, normal))) == {
        "ours": 1, "always collides": 0, "never moves": 1,
    }  # fmt: skip


def test_a_coin_takes_both_sides() -> None:
    found = {"die 9400, sensor": runs(5) + runs(5, passed=-1.0), "other dies": runs(9) + runs(9, passed=-1.0)}
    nulls = {**runs_of(variability.ALWAYS, found), variability.COIN: variability._tossed(found)}
    assert held(variability.rows(found), nulls_of(variability.rows, nulls)) == {
        "ours": 2, "always collides": 0, "never moves": 0, "always goes left": 0, "tosses a coin": 2,
    }  # fmt: skip


def test_a_field_that_always_looks_ahead_is_on_what_is_ahead() -> None:
    found = runs(5, on_target=0.9, ahead=0.85, in_view=1.0, touched=0.0, time=15.0)
    nulls = {name: each["chase"] for name, each in runs_of(chase.NULLS, {"chase": found}).items()}
    assert held(chase.rows(found), nulls_of(chase.rows, nulls)) == {
        "ours": 1, "always collides": 0, "never moves": 0, "always looks straight ahead": 1,
    }  # fmt: skip
    apart = [run | {"on_target": share} for run, share in zip(found, (0.8, 0.9, 1.0, 0.9, 0.8), strict=True)]
    # a standard deviation of 0.084, of which five runs tell 1.68
    assert chase.notes(apart)[-1].endswith("off by 0.14 from 0.8")
    assert chase.notes(apart[:1])[-1].endswith("one run tells no spread")


def test_networks_that_are_the_same_are_not_told_apart() -> None:
    every = {(name, speed): runs(30) for name in clutter.NETWORKS for speed in clutter.SPEEDS}
    found = every | {(n, v): [HIT] * 30 for n, v in every if n != "modified"}
    nulls = {**runs_of(ROBOTS, found), clutter.ALIKE: clutter._alike(found)}
    scores = held(clutter.rows(found), nulls_of(clutter.rows, nulls))
    assert scores["ours"] == 14
    assert (scores["always collides"], scores["never moves"]) == (6, 0)  # it drives, and stands
    assert scores[clutter.ALIKE] == 6
    assert "30 scenes that differ tell 0.75" in clutter._power(found)
    assert "0 scenes that differ tell nan" in clutter._power({key: runs(1, path_m=0.0) for key in found})


@pytest.mark.parametrize(("distance", "collided"), [(0.0, 1.0), (7.0, 0.0)])
def test_one_answer_a_colour_is_a_distance_or_a_collision(distance: float, collided: float) -> None:
    assert table1._answer(distance)["collided"] == collided
    assert table1._constant("yellow") == 0.0
    assert table1._constant("blue") == pytest.approx(np.mean(table1.PAPER["blue"]))


def test_populations_that_fire_alike_show_no_winner() -> None:
    total = {"OL": 1.0, "OR": 9.0, "DL": 9.0, "DR": 0.5}
    ours = fig6.Seen(total, np.linspace(0.35, 0.05, 20), 4.0, 0.0)
    assert held(fig6.rows(ours), nulls_of(fig6.rows, fig6._nulls(ours))) == {
        "ours": 5, "drives straight on": 0, "turns on the spot": 1, "never moves": 1,
    }  # fmt: skip
