"""Runs in lanes beside runs one by one."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from circuits.circuit import Circuit, Port
from circuits.devices import Capacitor, Diode, Resistor, Source
from circuits.devices.source import PiecewiseLinear
from circuits.lowering.kernel import Machine, to_kernel
from circuits.lowering.on_dies import on_dies
from circuits.registry import load_block
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500
from circuits.silicon.silicon import Silicon
from circuits.solver.batch import map_dies
from circuits.solver.lanes.simulate import fits, simulate_each
from circuits.solver.sweep.continuation import with_source
from circuits.solver.transient import Result, simulate
from circuits.testbench import Testbench

WITHIN = 1e-6  # s


def machine_of(name: str) -> Machine:
    block = load_block(name)
    return to_kernel(block.bench(), Silicon(block.process))


def results(machines: list[Machine], **options: object) -> list[Result]:
    found = list(simulate_each(machines, **options))  # type: ignore[arg-type]
    assert all(isinstance(each, Result) for each in found)
    return [each for each in found if isinstance(each, Result)]


def same(one: Result, other: Result) -> bool:
    """Whether two results are the same to the bit."""
    equal = [np.array_equal(one.spikes[n], other.spikes[n]) for n in one.spikes]
    equal += [np.array_equal(one.time, other.time), np.array_equal(one.voltage, other.voltage)]
    equal += [np.array_equal(one.operating_point.voltage, other.operating_point.voltage)]
    return all(equal) and one.steps == other.steps


@pytest.mark.parametrize(
    ("name", "dies"), [("rebound-neuron", 40), ("lso-neuron", 4), ("axon-hillock", 8), ("wavefront-cell", 8)]
)
def test_classes_and_edges_are_those_of_runs_one_by_one(name: str, dies: int) -> None:
    block = load_block(name)
    machines = on_dies(machine_of(name), [Die(number=n) for n in range(dies)])
    for ours, alone in zip(
        results(machines, rtol=1e-5), (simulate(m, rtol=1e-5) for m in machines), strict=True
    ):
        assert block.outcome(ours) == block.outcome(alone)
        assert ours.spikes.keys() == alone.spikes.keys()
        for port, times in alone.spikes.items():
            np.testing.assert_allclose(ours.spikes[port], times, rtol=0.0, atol=WITHIN)
        np.testing.assert_allclose(ours.operating_point.voltage, alone.operating_point.voltage, atol=1e-9)
        assert ours.disturbance == alone.disturbance
        assert ours.time[-1] == pytest.approx(alone.time[-1])
        assert ours.nodes == alone.nodes
        np.testing.assert_allclose(ours.voltage[-1], alone.voltage[-1], atol=1e-4)


def test_a_die_has_its_bits_whatever_stands_beside_it() -> None:
    machines = on_dies(machine_of("rebound-neuron"), [Die(number=n) for n in range(19)])
    every = results(machines, rtol=1e-4)
    for order in ([18], [3, 0], [*range(18, -1, -1)]):
        for k, again in zip(order, results([machines[k] for k in order], rtol=1e-4), strict=True):
            assert same(again, every[k])


def test_a_die_has_its_bits_where_the_room_for_points_is_full(monkeypatch: pytest.MonkeyPatch) -> None:
    machines = on_dies(machine_of("high-threshold-neuron"), [Die(number=n) for n in range(20)])
    wide = results(machines, rtol=1e-5)
    monkeypatch.setattr("circuits.solver.lanes.places._POINTS", 7)
    monkeypatch.setattr("circuits.solver.lanes.places._ROOM", 1)
    for one, other in zip(wide, results(machines, rtol=1e-5), strict=True):
        assert same(one, other)


def test_a_die_has_its_bits_however_many_workers_there_are() -> None:
    machine = machine_of("high-threshold-neuron")
    work = partial(simulate, rtol=1e-5, record=("v_mem",) if "v_mem" in machine.names else None)
    dies = [Die(number=n) for n in range(70)]
    one, two = (map_dies(work, machine, dies, workers) for workers in (1, 2))
    assert [sample.die for sample in one] == dies
    for a, b in zip(one, two, strict=True):
        assert a.value is not None
        assert b.value is not None
        assert same(a.value, b.value)


def test_runs_with_parameters_of_their_own_go_together() -> None:
    warm = [
        to_kernel(load_block("axon-hillock").bench(), Silicon(temperature_c=t)) for t in (0.0, 27.0, 60.0)
    ]
    for ours, machine in zip(results(warm, rtol=1e-5), warm, strict=True):
        alone = simulate(machine, rtol=1e-5)
        assert ours.machine is machine
        for port, times in alone.spikes.items():
            np.testing.assert_allclose(ours.spikes[port], times, rtol=0.0, atol=WITHIN)


def test_thresholds_follow_the_supply_of_each() -> None:
    machine = machine_of("axon-hillock")
    supply = machine.source_names.index("vdd")
    low = [with_source(machine, supply, v) for v in (1.8, 1.5)]
    for ours, alone in zip(results(low, rtol=1e-5), (simulate(m, rtol=1e-5) for m in low), strict=True):
        assert ours.uncrossed == alone.uncrossed
        for port, times in alone.spikes.items():
            np.testing.assert_allclose(ours.spikes[port], times, rtol=0.0, atol=WITHIN)


def test_a_signal_that_swings_below_its_threshold_is_told() -> None:
    machine = machine_of("axon-hillock")
    circuit = machine.testbench.circuit
    ports = tuple(replace(p, threshold=2.5) if p.name == "spike" else p for p in circuit.ports)
    bench = replace(machine.testbench, circuit=replace(circuit, ports=ports))
    never = to_kernel(bench, machine.silicon)
    (ours,) = results([never], rtol=1e-5)
    assert ours.uncrossed.keys() == {"spike"}
    swing, alone = ours.uncrossed["spike"], simulate(never, rtol=1e-5).uncrossed["spike"]
    assert (swing.low, swing.high) == pytest.approx((alone.low, alone.high), abs=1e-3)
    assert swing.threshold == 2.5


def test_long_runs_record_every_point_in_order() -> None:
    machine = machine_of("rebound-neuron")
    (ours,), alone = results([machine], rtol=1e-6), simulate(machine, rtol=1e-6)
    assert (np.diff(ours.time) > 0.0).all()
    assert ours.voltage.shape == (ours.time.size, len(machine.names))
    assert ours.steps.accepted == ours.time.size - 1
    assert ours.uncrossed == alone.uncrossed
    at = np.linspace(0.0, machine.testbench.stop, 500)
    v = machine.names.index("v_mem")
    there = np.interp(at, alone.time, alone.voltage[:, v])
    np.testing.assert_allclose(np.interp(at, ours.time, ours.voltage[:, v]), there, atol=1e-3)


def test_what_has_no_form_for_lanes_is_told_by_the_structure() -> None:
    assert fits(machine_of("rebound-neuron"))
    assert not fits(machine_of("onset-neuron"))  # an amplifier
    endless = machine_of("rebound-neuron")
    assert not fits(replace(endless, testbench=replace(endless.testbench, stop=np.inf)))


def test_a_diode_is_not_for_lanes_and_a_coupled_pair_of_resistors_is_as_alone() -> None:
    """The latter has no rates by its capacitor alone, and is done again by itself."""
    ports = (Port("v_in", "supply"), Port("a", "analog", "out"), Port("b", "analog", "out"))
    resistors = (Resistor("r1", "v_in", "a", 1e6), Resistor("r2", "b", "0", 1e6))
    source = Source("in", "v_in", PiecewiseLinear((0.0, 1e-6), (0.0, 1.0)))
    found = []
    for device in (Capacitor("c", "a", "b", 10e-12), Diode("d", "a", "b")):
        bench = Testbench("pair", Circuit("pair", ports, (*resistors, device)), (source,), 1e-4)
        found.append(to_kernel(bench, Silicon(AMI_1500)))
    coupled, diode = found
    assert (fits(coupled), fits(diode)) == (True, False)
    (ours,) = results([coupled])
    alone = simulate(coupled)
    np.testing.assert_allclose(ours.voltage[-1], alone.voltage[-1], atol=1e-6)
