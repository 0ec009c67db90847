"""What blocks measure, on the charge of a capacitor through a resistor, whose crossings are known."""

import math

import pytest

from circuits.blocks.drive import powered
from circuits.blocks.measure import (
    between,
    fall,
    high_time,
    last_rate,
    latency,
    low_time,
    peak,
    rise,
    spiked,
    whether,
)
from circuits.blocks.ports import SUPPLY, event_out
from circuits.circuit import Circuit, Port
from circuits.devices import Capacitor, Resistor
from circuits.devices.source import PiecewiseLinear
from circuits.solver.transient import Result, simulate
from circuits.testbench import Testbench

R, C = 1e6, 1e-9  # Ohm, F: a time constant of 1 ms
UP, DOWN, EDGE = 1e-3, 11e-3, 1e-9  # s


@pytest.fixture(scope="module")
def result() -> Result:
    """5 V through R into C from 1 ms to 11 ms, to within e^-10 of the way."""
    ports = (SUPPLY, Port("drive", "analog"), *event_out("spike"))
    devices = (
        Resistor("r", "drive", "spike", R),
        Capacitor("c", "spike", "0", C),
        Resistor("r_load", "vdd", "0", R),
    )
    circuit = Circuit("rc", ports, devices)
    wave = PiecewiseLinear((0.0, UP, UP + EDGE, DOWN, DOWN + EDGE), (0.0, 0.0, 5.0, 5.0, 0.0))
    bench = Testbench("rc", circuit, powered(5.0, {"drive": wave}), 20e-3, watch=("spike",))
    return simulate(bench)


def test_half_the_supply_is_passed_after_ln_2_time_constants(result: Result) -> None:
    # e^-10 of the way is missing where the fall begins; steps of the solver are interpolated
    assert rise(result, "spike") == pytest.approx(UP + R * C * math.log(2.0), abs=2e-6)
    assert fall(result, "spike") == pytest.approx(DOWN + R * C * math.log(2.0), abs=2e-6)
    assert high_time(result, "spike") == pytest.approx(DOWN - UP, abs=2e-6)
    assert latency(result, UP) == pytest.approx(R * C * math.log(2.0), abs=2e-6)
    assert spiked(result)


def test_a_peak_lies_between_the_steps() -> None:
    """A ramp of 1 V/ms goes up for 5 ms, and down: what follows it is highest ln(2 - e^-5) ms after that."""
    ports = (SUPPLY, Port("drive", "analog"), *event_out("out"))
    load = Resistor("r_load", "vdd", "0", R)
    devices = (Resistor("r", "drive", "out", R), Capacitor("c", "out", "0", C), load)
    ramp = PiecewiseLinear((0.0, 5e-3, 10e-3), (0.0, 5.0, 0.0))
    bench = Testbench("rc", Circuit("rc", ports, devices), powered(5.0, {"drive": ramp}), 10e-3)
    run, after = simulate(bench), R * C * math.log(2.0 - math.exp(-5.0))
    when, height = peak(run, "out")
    assert when == pytest.approx(5e-3 + after, abs=3e-7)
    assert height == pytest.approx(5.0 - after * 1e3, abs=1e-4)
    assert abs(run.time - when).min() > 1e-6
    assert peak(run, "out", 7e-3)[0] == 7e-3


def test_what_is_not_in_the_run_is_none(result: Result) -> None:
    assert low_time(result, "spike") is None
    assert rise(result, "vdd") is None
    assert high_time(result, "vdd") is None
    assert between(None, 1.0) is None
    assert between(1.0, None) is None
    assert last_rate(result.spikes["spike"]) is None


def test_an_outcome_is_whether_a_number_is_in_the_run(result: Result) -> None:
    def measures(run: Result) -> dict[str, float | None]:
        return {"rise_s": rise(run, "spike"), "second_s": None}

    assert whether(measures, "rise_s", "rises", "stays")(result) == "rises"
    assert whether(measures, "second_s", "twice", "once")(result) == "once"
