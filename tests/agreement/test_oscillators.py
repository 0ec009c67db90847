"""Oscillators run as in ngspice: the full form is `benchmarks/oscillators.py`, over 20 dies, rings of 7 too.

Those do what rings of 3 and 5 do; the solver alone begins them in `test_beginning.py`.
"""

from __future__ import annotations

import pytest

from circuits.silicon.die import Die
from tests.circuits.solver.oscillators import OSCILLATORS

pytestmark = pytest.mark.usefixtures("kept_ngspice")

ALL = OSCILLATORS["oscillators"]()
ALLOWED = OSCILLATORS["ALLOWED"]  # percent of the period, what the benchmark claims


@pytest.mark.parametrize("k", [k for k, each in enumerate(ALL) if each.testbench.circuit.name != "ring_of_7"])
def test_period_and_spikes_are_ngspice_s(k: int) -> None:
    die = Die(number=None if k % 2 else 1003)
    results = OSCILLATORS["run"](ALL[k], die)
    own, peer = (OSCILLATORS["period"](result) for result in results)
    assert 100.0 * abs(own / peer - 1.0) < ALLOWED
    sizes = [result.spikes["spike"].size for result in results]
    assert min(sizes) >= 6
    assert abs(sizes[0] - sizes[1]) <= 1
    assert results[0].disturbance == results[1].disturbance
