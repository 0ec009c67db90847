"""The contract of a system, over the registry: every one of them says how a run went in the same words."""

from __future__ import annotations

from functools import cache
from typing import Any

import pytest
from matplotlib.figure import Figure

from system.registry import SYSTEMS, load_system
from system.system import ENTRIES, METRICS, Account, summary_of

# options of a short run of each
SHORT: dict[str, dict[str, Any]] = {
    "approach": {"level": "behavioural", "duration": 1.2},
    "rover": {"goal": (4, 10)},
    "forest": {"pings": 60},
    "robot": {"pings": 20},
    "head": {"duration": 2.0},
    "bug": {"map": "bug-open", "duration": 4.0},
    "pushbot": {"duration": 0.4},
    "rolls": {"duration": 0.2},
}


@cache
def traced(name: str) -> Any:
    system = load_system(name)
    return system.run(system.scenario(**SHORT[name]))


@pytest.mark.parametrize("name", SYSTEMS)
def test_a_summary_begins_with_the_runs_account(name: str) -> None:
    system = load_system(name)
    found = system.summarise(traced(name))
    assert tuple(found)[: len(ENTRIES)] == ENTRIES
    assert isinstance(found["succeeded"], bool)
    assert found["reason"]
    assert "\n" not in found["reason"]
    for entry in ("emergency_share", "standing_share"):
        assert found[entry] is None or 0.0 <= found[entry] <= 1.0
    assert found["ran_on"]
    assert system.success


@pytest.mark.parametrize("name", SYSTEMS)
def test_what_a_study_can_ask_for_is_a_number_of_the_summary(name: str) -> None:
    system = load_system(name)
    assert set(METRICS) <= set(system.metrics)
    assert set(system.study_metrics) <= set(system.metrics)
    found = system.summarise(traced(name))
    for metric in system.metrics:
        assert found[metric] is None or float(found[metric]) == found[metric]


@pytest.mark.parametrize("name", SYSTEMS)
def test_the_picture_has_the_reason(name: str) -> None:
    system, figure = load_system(name), Figure()
    system.draw(traced(name), figure)
    titles = [ax.get_title() for ax in figure.axes] + [figure.get_suptitle()]
    assert any(system.account(traced(name)).headline in title for title in titles)


def test_an_account_in_a_line() -> None:
    account = Account(succeeded=False, reason="collided with a pipe", ran_on={"ranges": "exact"})
    assert account.headline == "failed: collided with a pipe"
    assert summary_of(account, {"pings": 3.0})["pings"] == 3.0
