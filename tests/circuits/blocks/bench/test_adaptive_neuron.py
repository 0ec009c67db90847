"""Spikes come faster with the input, rest for the refractory time, and grow rarer with the adaptation."""

import numpy as np
import pytest

from circuits.bias import rebias
from circuits.blocks.bench.adaptive_neuron import BLOCK, Params
from circuits.blocks.bench.bias import MASTERS, code_current
from circuits.errors import ParameterError
from circuits.silicon.die import Die
from circuits.silicon.process import ROLLS_180
from circuits.silicon.silicon import Silicon
from circuits.solver.transient import Result, simulate


def run(biases: dict[str, float], die: Die | None = None, **knobs: float | None) -> Result:
    bench = BLOCK.bench(rebias(BLOCK.build(), biases), **knobs)
    return simulate(bench, Silicon(ROLLS_180) if die is None else Silicon(ROLLS_180, die=die))


def test_more_input_is_more_spikes() -> None:
    intervals = []
    for fine in (10, 32):
        current = code_current(MASTERS[3], fine, 3.4, 1.0)
        intervals.append(BLOCK.measures(run({"i_dc": current}, duration=30e-3))["interval_s"])
    assert intervals[1] < 0.9 * intervals[0]


def test_the_refractory_time_is_charge_over_current() -> None:
    times = []
    for fine in (1, 2):
        current = code_current(MASTERS[2], fine, 4.0, 4.0)
        result = run({"i_ref": current}, duration=160e-3)
        found = BLOCK.measures(result)["refractory_s"]
        times.append(found * current)
        high = result["v_refr"].max()
        # v_refr falls from there to where the reset lets the membrane go, between 0.1 and 0.5 V
        assert 1e-12 * (high - 0.6) < found * current < 1e-12 * high
    assert times[0] == pytest.approx(times[1], rel=0.05)


def test_spikes_are_whole_on_every_die() -> None:
    for number in range(1000, 1004):
        result = run({}, Die(number=number), duration=12e-3)
        if result.spikes["spike"].size:
            assert result["spike"].max() > 1.2
            assert result["v_refr"].max() > 1.4


def test_adaptation_makes_intervals_longer() -> None:
    plain, adapted = run({}), run({}, adapt=1.0)
    assert BLOCK.measures(plain)["adaptation"] == pytest.approx(1.0, abs=1e-3)
    assert (BLOCK.measures(adapted)["adaptation"] or 0.0) > 1.005
    assert np.diff(adapted.spikes["spike"])[-1] > np.diff(plain.spikes["spike"])[-1]


def test_without_an_input_it_stays_silent() -> None:
    result = run({"i_dc": 1e-13})
    assert BLOCK.outcome(result) == "none"
    assert BLOCK.measures(result)["interval_s"] is None


def test_what_cannot_be() -> None:
    with pytest.raises(ParameterError, match=r"refractory_capacitance: 0 F, must be > 0"):
        Params(refractory_capacitance=0.0)
