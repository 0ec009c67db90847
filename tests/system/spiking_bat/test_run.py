"""Scenarios of flights by spikes: the forests of the analog model, and a die of one's own."""

import numpy as np
import pytest

from circuits.errors import ParameterError
from circuits.silicon.die import Die
from system.forest import run as forest
from system.openspace.law import arcs_of
from system.spiking_bat.run import ChipChoice, LatencyScenario, document, place, run, scenario_of, summarise


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


def test_a_course_of_temperature_is_flown_and_said() -> None:
    course = ((0.0, 27.0), (0.3, 40.0))
    warm, still = (
        run(LatencyScenario("latency-chip", seed=1003, pings=5, chip=ChipChoice(bias_kind="gate", course=c)))
        for c in (course, ())
    )
    assert document(warm)["temperature_C"] == course
    assert document(still)["temperature_C"] == 27.0
    # with fixed gates currents grow with temperature: other latencies, other ways
    assert not np.array_equal(warm.flown.path, still.flown.path)
    unit = ChipChoice(bias_kind="gate", course=course, units=((16, 5),))
    assert run(LatencyScenario("latency-chip", seed=1003, pings=5, chip=unit)).flown.pings == 5
