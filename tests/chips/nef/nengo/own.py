"""A plugin of pytest that runs nengo's own tests on our simulator: their fixtures, and what became of each.

Started by `test_own` in a process of its own. `NENGO_OWN` names the file that it writes, JSON rows of name,
outcome, names of the classes of what was raised, and its first line.
"""

from __future__ import annotations

import json
import logging
import os
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any
from unittest.mock import MagicMock

import nengo
import numpy as np
import pytest

from chips.nef.nengo.simulator import Simulator as Ours

NEURONS = [
    nengo.Direct, nengo.RectifiedLinear, nengo.SpikingRectifiedLinear, nengo.LIFRate, nengo.LIF,
    nengo.AdaptiveLIFRate, nengo.AdaptiveLIF, nengo.Izhikevich, nengo.Sigmoid, nengo.Tanh,
]  # fmt: skip
ROWS: list[tuple[str, str, list[str], str]] = []


@pytest.fixture(name="Simulator")
def _simulator() -> Callable[..., Any]:
    return lambda *given, **named: Ours(*given, chip=None, **named)


@pytest.fixture
def seed(request: Any) -> int:
    return zlib.crc32(request.node.name.partition("[")[0].encode()) % 2**31


@pytest.fixture
def rng(seed: int) -> np.random.RandomState:
    return np.random.RandomState(seed)


@pytest.fixture(name="plt")
def _plt() -> MagicMock:
    """What nengo's tests draw on, of which nobody sees anything, as in nengo's own runs without `--plots`."""
    return MagicMock()


@pytest.fixture
def logger() -> logging.Logger:
    return logging.getLogger("nengo's own tests")


@pytest.fixture
def allclose() -> Callable[..., bool]:
    def close(
        a: Any, b: Any, rtol: float = 1e-5, atol: float = 1e-8, xtol: int = 0, *, equal_nan: bool = False,
        delay: int = 0, **_: Any,
    ) -> bool:  # fmt: skip
        a, b = np.broadcast_arrays(np.atleast_1d(a), np.atleast_1d(b))
        a, b = a[delay:], b[: len(b) - delay]
        found = np.isclose(a, b, rtol, atol, equal_nan)
        for k in range(1, xtol + 1):
            found[k:] |= np.isclose(a[k:], b[:-k], rtol, atol, equal_nan)
            found[:-k] |= np.isclose(a[:-k], b[k:], rtol, atol, equal_nan)
        return bool(found.all())

    return close


def pytest_generate_tests(metafunc: Any) -> None:
    """Neuron types by which nengo's tests are repeated."""
    positive = [kind for kind in NEURONS[1:] if not kind.negative]
    for name, kinds in (
        ("AnyNeuronType", NEURONS), ("NonDirectNeuronType", NEURONS[1:]), ("PositiveNeuronType", positive),
    ):  # fmt: skip
        if name in metafunc.fixturenames:
            metafunc.parametrize(name, kinds)


def pytest_collection_modifyitems(items: list[Any]) -> None:
    """Keep the tests that take a simulator."""
    items[:] = [each for each in items if "Simulator" in each.fixturenames]


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item: Any, call: Any) -> Any:
    """Keep what became of a test."""
    report = yield
    if report.when == "call" or report.outcome != "passed":
        error = call.excinfo
        kinds = [] if error is None else [each.__name__ for each in error.type.__mro__]
        text = "" if error is None else (str(error.value).splitlines() or [""])[0]
        ROWS.append((item.name, report.outcome, kinds, text))
    return report


def pytest_sessionfinish() -> None:
    """Write what became of all."""
    Path(os.environ["NENGO_OWN"]).write_text(json.dumps(ROWS))
