"""A machine of two states on the chip goes through nengo's; `benchmarks/latching.py` has more, on dies."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest

from circuits.silicon.die import NOMINAL
from tests.benchmark import benchmark


@pytest.fixture
def latching() -> Iterator[Any]:
    with benchmark("latching") as found:
        yield found


@pytest.mark.filterwarnings("ignore::nengo.exceptions.NengoWarning")
def test_a_clocked_machine_has_nengos_states_and_values(
    latching: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(latching, "PERIODS", 3)
    made = latching.ring(1)
    wanted, size = latching.signs(latching.by_nengo, made(1))
    assert wanted == "+--++-"
    states, own = latching.signs(latching.on(NOMINAL), made(1))
    assert states == wanted
    assert own == pytest.approx(size, rel=0.05)
