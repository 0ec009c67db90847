"""A machine of two states on the chip goes through nengo's; `benchmarks/latching.py` has more, on dies."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest

from circuits.silicon.die import NOMINAL

BENCHMARKS = Path(__file__).resolve().parents[4] / "benchmarks"


@pytest.fixture
def latching() -> Iterator[Any]:
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(BENCHMARKS))
        yield import_module("latching")
    for name in ("latching", "_report"):
        sys.modules.pop(name, None)


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
