"""Oscillators run as in ngspice: the full form, over 20 dies, is `benchmarks/oscillators.py`."""

from __future__ import annotations

import pytest

from circuits.silicon.die import Die
from tests.circuits.solver.oscillators import OSCILLATORS

pytestmark = pytest.mark.usefixtures("kept_ngspice")

ALL = OSCILLATORS["oscillators"]()
ALLOWED = OSCILLATORS["ALLOWED"]  # percent of the period, what the benchmark claims


@pytest.mark.parametrize("k", range(len(ALL)))
def test_period_and_spikes_are_ngspice_s(k: int) -> None:
    die = Die(number=None if k % 2 else 1003)
    results = OSCILLATORS["run"](ALL[k], die)
    own, peer = (OSCILLATORS["period"](result) for result in results)
    assert 100.0 * abs(own / peer - 1.0) < ALLOWED
    sizes = [result.spikes["spike"].size for result in results]
    assert min(sizes) >= 6
    assert abs(sizes[0] - sizes[1]) <= 1
    assert results[0].disturbance == results[1].disturbance
