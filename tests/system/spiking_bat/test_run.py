"""Scenarios of flights by spikes: the forests of the analog model, and a die of one's own."""

from dataclasses import replace

import numpy as np
from matplotlib.figure import Figure

from circuits.errors import CircuitError
from circuits.silicon.die import Die
from system.cli.run import described
from system.forest import run as forest
from system.openspace.law import arcs_of
from system.spiking_bat.run import SYSTEM, account, place, run, summarise
from system.spiking_bat.scenario import Scenario
from tests.refusals import refusals


def test_forest_and_start_are_the_analog_models() -> None:
    scenario = Scenario(seed=1001)
    analog = forest.run(forest.Scenario(seed=1001, pings=2)).first
    found, start = place(scenario, arcs_of(scenario.bat))
    assert np.array_equal(found.place, analog.forest.place)
    assert start == analog.start


def test_a_chip_flies_and_says_what_was_lost() -> None:
    die = Die(number=1000)
    trace = run(Scenario("chip", seed=1003, pings=20, die=die, bias_kind="ideal", codes="calibrated"))
    found = summarise(trace)
    assert found["pings"] <= 20.0
    assert {"lost", "overflowed", "undecided"} <= set(found)
    figure = Figure(layout="constrained")
    SYSTEM.draw(replace(trace, scenario=replace(trace.scenario, codes=None)), figure)
    assert "die A/1000, 27 °C, biases of kind ideal, calibrated codes" in figure.axes[0].get_title()


def test_a_chip_flies_under_the_full_law_with_every_kind_of_bias() -> None:
    """Its process is the scenario's; usual codes give the design's times, so that ways begin alike."""
    given = {"seed": 1003, "pings": 4, "die": Die(number=1000)}
    ways = [
        run(Scenario("chip", bias_kind=kind, codes=codes, law="full", **given)).flown
        for kind, codes in (("gate", "default"), ("ideal", "calibrated"), ("generator", "calibrated"))
    ]
    assert [flown.pings for flown in ways] == [4, 4, 4]
    ideal = run(Scenario("chip", bias_kind="gate", codes="default", law="ideal", **given)).flown
    assert not np.array_equal(ways[0].path, ideal.path)


test_what_is_refused = refusals(
    CircuitError,
    lambda given: SYSTEM.scenario(**given),
    [
        ({"codes": "calibrated"}, "codes: calibrated, no chip is in the loop; add `brain=chip`"),
        ({"die": Die(number=3)}, "die: .*, no chip is in the loop"),
        ({"unit": [(16, 5)]}, "unit: .*, no chip is in the loop"),
        ({"brain": "chip", "codes": "none"}, "codes: none, must be calibrated, default, or a file"),
        ({"brain": "analog"}, "brain: analog, must be network, chip or lif"),
        ({"brain": "chip", "unit": ["16"]}, "unit: .*must be MEMORY,UNIT"),
        ({"brain": "chip", "unit": ["16,5"], "area": 2.0}, "area: not with `unit`"),
        ({"map": "a.csv", "obstacles": 5}, "obstacles: not with `map`"),
        ({"vmax": 0.0}, "vmax: 0 m/s, must be > 0 and finite"),
        ({"selection": "chip"}, "spiking-bat.scenario.selection: unknown"),
    ],
)


def test_a_course_of_temperature_is_flown_and_said() -> None:
    course = ((0.0, 27.0), (0.3, 40.0))
    warm, still = (run(Scenario("chip", seed=1003, pings=5, course=c)) for c in (course, ()))
    assert described(SYSTEM, warm.scenario)["temperature_C"] == course
    assert described(SYSTEM, still.scenario)["temperature_C"] == 27.0
    assert account(warm).ran_on["temperature_C"] == "27 at 0 s, 40 at 0.3 s"
    # with fixed gates currents grow with temperature: other latencies, other ways
    assert not np.array_equal(warm.flown.path, still.flown.path)
    unit = Scenario("chip", seed=1003, pings=5, course=course, units=((16, 5),))
    assert run(unit).flown.pings == 5
