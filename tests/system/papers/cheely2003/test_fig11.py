"""Figure 11 of Cheely & Horiuchi 2003: its rows of runs that are made up, and of bats that never change."""

from __future__ import annotations

from system.papers.cheely2003 import fig11

RUN: fig11.Summary = {
    "call_rate_first_Hz": 10.0, "call_rate_last_Hz": 50.0, "call_amplitude_first_V": 2.0,
    "call_amplitude_last_V": 1.0, "shortest_interval_s": 0.04, "longest_best_delay_s": 0.028,
    "held_fraction": 0.95,
}  # fmt: skip
MIXED = RUN | {"held_fraction": 0.3}


def agree(first: fig11.Summary, second: fig11.Summary) -> list[bool | None]:
    return [row.agrees for row in fig11.rows(first, second)]


def test_its_rows_ask_for_change_and_for_the_isolation() -> None:
    assert agree(RUN, MIXED) == [True] * 5
    assert agree(MIXED, RUN) == [True, True, True, False, False]
    assert agree(RUN | {"call_rate_last_Hz": None, "shortest_interval_s": 0.01}, MIXED)[::2] == [
        False, False, True
    ]  # fmt: skip


def test_a_bat_that_never_changes_meets_what_asks_for_no_change() -> None:
    target, clutter = ([fig11._constant(each, held) for each in (RUN, MIXED)] for held in (1.0, 0.0))
    assert agree(*target) == [False, False, True, True, False]
    assert agree(*clutter) == [False, False, True, False, True]
