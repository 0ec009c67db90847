"""Testbenches: their length, and sources that cannot stand together."""

import math

import pytest

from circuits.circuit import Bias, Circuit, Port
from circuits.devices import Resistor, Source
from circuits.devices.source import Constant
from circuits.errors import ParameterError, TopologyError, UnknownNameError
from circuits.lowering.kernel import to_kernel
from circuits.testbench import Testbench

DIVIDER = Circuit(
    "divider",
    (Port("top", "supply"), Port("level", "bias", shape=(2,)), Port("out", "analog", "out")),
    (
        Resistor("r1", "top", "out", 1e3),
        Resistor("r2", "out", "level[0]", 1e3),
        Resistor("r3", "out", "level[1]", 1e3),
    ),
    biases=(Bias("levels", "level", "voltage", (0.5, 1.0)),),
)


def bench(*sources: Source) -> Testbench:
    return Testbench("bench", DIVIDER, sources, 1.0)


@pytest.mark.parametrize("stop", [0.0, -1.0, math.nan])
def test_stop_must_be_positive(stop: float) -> None:
    with pytest.raises(ParameterError, match=r"bench\.stop: .* must be > 0"):
        Testbench("bench", DIVIDER, (), stop)


def test_a_run_without_an_end_is_allowed() -> None:
    assert Testbench("bench", DIVIDER, (), math.inf).stop == math.inf


def test_biases_that_nothing_drives_are_set() -> None:
    machine = to_kernel(bench(Source("v", "top", Constant(5.0)), Source("mine", "level[1]", Constant(2.0))))
    assert machine.source_names == ("v", "mine", "level[0]")
    assert [float(v[0]) for _, v in machine.polylines] == [5.0, 2.0, 0.5]


def test_two_sources_on_a_node_are_a_supply_loop() -> None:
    with pytest.raises(TopologyError, match="second: supply loop with first at node top; remove one"):
        to_kernel(bench(Source("first", "top", Constant(5.0)), Source("second", "top", Constant(5.0))))


def test_a_current_source_beside_a_voltage_source_is_no_loop() -> None:
    both = (Source("v", "top", Constant(5.0)), Source("i", "top", Constant(1e-3), "current"))
    assert to_kernel(bench(*both)).source_names[:2] == ("v", "i")


def test_two_sources_of_one_name_are_refused() -> None:
    with pytest.raises(TopologyError, match="v: duplicate source name"):
        to_kernel(bench(Source("v", "top", Constant(5.0)), Source("v", "out", Constant(1e-3), "current")))


def test_an_unknown_port_is_named() -> None:
    with pytest.raises(UnknownNameError, match="divider port up: unknown; known are level, out, top"):
        to_kernel(bench(Source("v", "up", Constant(5.0))))


def test_an_element_outside_the_port_is_named() -> None:
    with pytest.raises(TopologyError, match=r"divider\.level\[2\]: index outside"):
        to_kernel(bench(Source("v", "top", Constant(5.0)), Source("w", "level[2]", Constant(5.0))))
    with pytest.raises(TopologyError, match=r"divider\.top\[0\]: index outside"):
        to_kernel(bench(Source("v", "top[0]", Constant(5.0))))


def test_a_bad_waveform_is_named() -> None:
    with pytest.raises(ParameterError, match="v: a time or value is not finite"):
        to_kernel(bench(Source("v", "top", Constant(math.nan))))
