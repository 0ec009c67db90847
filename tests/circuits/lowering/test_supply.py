"""Events rise through half of the supply that their circuit is wired to."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from circuits.circuit import Circuit, Instance, InstanceArray, Node, Port
from circuits.devices import Resistor, Source
from circuits.devices.source import Constant, PiecewiseLinear
from circuits.errors import ParameterError
from circuits.lowering.kernel import to_kernel
from circuits.lowering.supply import half_supply, spike_levels
from circuits.registry import block_names, load_block
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.transient import simulate
from circuits.testbench import Testbench
from tests.circuits.solver.oscillators import OSCILLATORS

LOW = 1.8
RING = OSCILLATORS["ring"](AMI_1500_IDEAL, 3, 0.3e-6).circuit


def bench(circuit: Circuit, **supplies: float) -> Testbench:
    sources = tuple(Source(name, name, Constant(v)) for name, v in supplies.items())
    watch = tuple(p.name for p in circuit.ports if p.direction == "out")
    return Testbench(circuit.name, circuit, sources, 0.3e-6, watch)


def test_a_circuit_on_another_supply_spikes_at_half_of_it() -> None:
    result = simulate(bench(RING, vdd=LOW))
    assert result.machine.silicon.process.v_dd == 5.0
    assert result.spikes["spike"].size > 10
    first = result.spikes["spike"][5]
    assert np.interp(first, result.time, result["spike"]) == pytest.approx(0.9, abs=0.02)
    assert half_supply(result.machine) == 0.9


def test_a_port_states_its_own_threshold() -> None:
    ports = tuple(replace(p, threshold=0.3) if p.name == "spike" else p for p in RING.ports)
    machine = to_kernel(bench(replace(RING, ports=ports), vdd=LOW))
    np.testing.assert_array_equal(spike_levels(machine), [[0.3], [0.8 * 0.3]])
    with pytest.raises(ParameterError, match=r"ring_of_3\.spike\.threshold: nan V"):
        replace(RING, ports=tuple(replace(p, threshold=float("nan")) for p in RING.ports[1:]))


def test_two_parts_on_two_supplies_have_a_threshold_each() -> None:
    parts = (
        Instance("low", RING, {"vdd": "v_core", "spike": "one"}),
        InstanceArray("high", RING, (2,), {"vdd": "v_io", "spike": "two"}),
    )
    ports = (
        Port("v_core", "supply"), Port("v_io", "supply"), Port("one", "event", "out"),
        Port("two", "event", "out", (2,)),
    )  # fmt: skip
    machine = to_kernel(bench(Circuit("chip", ports, instances=parts), v_core=LOW, v_io=5.0))
    np.testing.assert_array_equal(spike_levels(machine)[0], [0.9, 2.5, 2.5])
    one = replace(machine.testbench, watch=("two[1]", "one"))
    np.testing.assert_array_equal(spike_levels(to_kernel(one))[0], [2.5, 0.9])


def test_a_supply_below_ground_counts() -> None:
    circuit = Circuit(
        "split",
        (Port("vdd", "supply"), Port("vss", "supply"), Port("y", "event", "out")),
        (Resistor("r1", "vdd", "y", 1e3), Resistor("r2", "y", "vss", 1e3)),
    )
    machine = to_kernel(bench(circuit, vdd=1.0, vss=-3.0))
    np.testing.assert_allclose(spike_levels(machine), [[-1.0], [-3.0 + 0.8 * 2.0]])


def test_a_supply_that_rises_counts_in_full() -> None:
    ramp = Source("vdd", "vdd", PiecewiseLinear((0.0, 1e-8), (0.0, LOW)))
    machine = to_kernel(Testbench("ramp", RING, (ramp,), 0.3e-6, ("spike",)))
    assert spike_levels(machine)[0].tolist() == [0.9]


def test_without_a_supply_that_is_driven_the_process_has_the_say() -> None:
    devices = (Resistor("r", "a", "y", 1e3), Resistor("s", "y", "0", 1e3))
    circuit = Circuit("wire", (Port("a", "analog"), Port("y", "event", "out")), devices)
    machine = to_kernel(bench(circuit, a=1.0))
    assert spike_levels(machine)[0].tolist() == [2.5]


@pytest.mark.parametrize("name", block_names())
def test_blocks_on_the_process_s_supply_have_half_of_it_to_the_bit(name: str) -> None:
    block = load_block(name)
    silicon = Silicon(block.process)
    machine = to_kernel(block.bench(), silicon)
    levels, half = spike_levels(machine), 0.5 * silicon.process.v_dd
    assert half_supply(machine) == half
    assert set(levels[0]) <= {half}
    assert set(levels[1]) <= {0.8 * half}


def test_a_signal_that_swings_below_its_threshold_is_told() -> None:
    ports = tuple(replace(p, threshold=2.5) if p.name == "spike" else p for p in RING.ports)
    result = simulate(bench(replace(RING, ports=ports), vdd=LOW))
    assert result.spikes["spike"].size == 0
    swing = result.uncrossed["spike"]
    assert (swing.low, swing.high) == (result["spike"].min(), result["spike"].max())
    assert "never crosses its threshold of 2.5 V" in str(swing)
    assert not simulate(bench(RING, vdd=LOW)).uncrossed


def test_a_signal_that_is_not_recorded_is_told_as_well() -> None:
    ports = tuple(replace(p, threshold=2.5) if p.name == "spike" else p for p in RING.ports)
    testbench = bench(replace(RING, ports=ports), vdd=LOW)
    assert simulate(testbench, record=()).uncrossed == simulate(testbench).uncrossed


def test_silence_is_not_told() -> None:
    assert not simulate(replace(bench(RING, vdd=LOW), begin="at_rest")).uncrossed


def test_node_arrays_inside_are_followed_by_element() -> None:
    inner = Circuit(
        "two", (Port("va", "supply"), Port("vb", "supply"), Port("out", "event", "out", (2,))),
        instances=(
            Instance("a", RING, {"vdd": "va", "spike": "out[0]"}),
            Instance("b", RING, {"vdd": "vb", "spike": "out[1]"}),
        ),
        nodes=(Node("spare", (1,)),),
    )  # fmt: skip
    outer = Circuit(
        "outer", (Port("core", "supply"), Port("io", "supply"), Port("out", "event", "out", (2,))),
        instances=(Instance("x", inner, {"va": "core", "vb": "io", "out": "out"}),),
    )  # fmt: skip
    machine = to_kernel(replace(bench(outer, core=LOW, io=5.0), watch=("out",)))
    np.testing.assert_array_equal(spike_levels(machine)[0], [0.9, 2.5])
