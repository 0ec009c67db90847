"""Scenarios of flights by spikes: the forests of the analog model, and a die of one's own."""

import numpy as np
import pytest

from circuits.die import Die
from circuits.errors import ParameterError
from system import forest
from system.curved_openspace import arcs_of
from system.latency_run import ChipChoice, LatencyScenario, place, run, scenario_of, summarise


def test_forest_and_start_are_the_analog_models() -> None:
    scenario = LatencyScenario(seed=1001)
    analog = forest.run(forest.Scenario(seed=1001, pings=2)).first
    found, start = place(scenario, arcs_of(scenario.bat))
    assert np.array_equal(found.place, analog.forest.place)
    assert start == analog.start


def test_a_chip_flies_and_says_what_was_lost() -> None:
    choice = ChipChoice(die=Die(number=1003), bias_kind="generator", codes="calibrated")
    trace = run(LatencyScenario("latency-chip", seed=1003, pings=20, chip=choice))
    found = summarise(trace)
    assert found["pings"] <= 20.0
    assert {"lost", "overflowed", "undecided"} <= set(found)


def test_options_of_other_models_are_refused() -> None:
    with pytest.raises(ParameterError, match=r"--codes: only with --model latency-chip"):
        scenario_of({"model": "latency-network", "codes": "usual"})
    with pytest.raises(ParameterError, match=r"--selection: not with --model latency-chip"):
        scenario_of({"model": "latency-chip", "selection": "chip"})
    with pytest.raises(ParameterError, match=r"--codes: none, must be usual or calibrated"):
        ChipChoice(codes="none")
