"""Random circuits are the same by their number, and can be solved."""

import pytest

from circuits.circuit import GROUND
from circuits.devices import Resistor
from circuits.silicon.silicon import Silicon
from netlists.ngspice.random_circuit import DEVICES, LIFT, random_testbench


def test_a_number_is_a_circuit_whatever_else_is_drawn() -> None:
    first = repr(random_testbench(7, Silicon()))
    random_testbench(8, Silicon())
    assert repr(random_testbench(7, Silicon())) == first
    assert repr(random_testbench(8, Silicon())) != first


@pytest.mark.parametrize("number", range(40))
def test_it_has_few_devices_and_currents_that_go_somewhere(number: int) -> None:
    bench = random_testbench(number, Silicon())
    currents = [s for s in bench.sources if s.quantity == "current"]
    assert len(bench.circuit.devices) >= 1
    assert len(bench.circuit.devices) + len(currents) <= DEVICES[1]
    resistors = [d for d in bench.circuit.devices if isinstance(d, Resistor)]
    lift = sum(abs(s.waveform.value) for s in currents) * sum(r.resistance for r in resistors)  # type: ignore[union-attr]
    assert lift <= LIFT
    tied = {GROUND, *(s.node for s in bench.sources if s.quantity == "voltage")}
    for source in currents:
        assert any({r.a, r.b} & (tied | {source.node}) for r in resistors)
