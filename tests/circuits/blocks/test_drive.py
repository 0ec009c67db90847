"""Sources of a testbench: the supply first, levels and waves by node."""

import pytest

from circuits.blocks.drive import current_into, elements, powered, step, train
from circuits.circuit import Port
from circuits.devices.source import Constant, PiecewiseLinear, Source
from circuits.errors import ParameterError
from circuits.event import pulse


def test_the_supply_stands_first_and_a_source_is_called_as_its_node() -> None:
    wave = pulse((1e-3,), 5.0)
    assert powered(5.0, {"event": wave, "v_mem": 1.0}) == (
        Source("vdd", "vdd", Constant(5.0)),
        Source("event", "event", wave),
        Source("v_mem", "v_mem", Constant(1.0)),
    )
    assert current_into("i_in", 1e-9) == Source("i_in", "i_in", Constant(1e-9), "current")


def test_elements_that_nobody_drives_are_at_ground() -> None:
    assert elements(Port("spike", "event", "in", (3,)), {1: 5.0}) == {
        "spike[0]": 0.0, "spike[1]": 5.0, "spike[2]": 0.0,
    }  # fmt: skip
    assert elements(Port("spike", "event"), {0: 5.0}) == {"spike": 5.0}


def test_a_step_stands_before_and_after() -> None:
    assert step(1e-3, 2e-3, 0.5, 1.5) == PiecewiseLinear((0.0, 1e-3, 2e-3), (0.5, 0.5, 1.5))


def test_a_train_has_its_rate_and_no_train_is_refused() -> None:
    assert train("events", 3.0, 100.0, 1e-3) == pytest.approx((1e-3, 11e-3, 21e-3), rel=1e-12)
    with pytest.raises(ParameterError, match=r"events: 0, must be"):
        train("events", 0.0, 100.0, 1e-3)
    with pytest.raises(ParameterError, match=r"rate: 0 Hz"):
        train("events", 3.0, 0.0, 1e-3)
