"""Batches over dies: re-targeting equals lowering, order and workers do not matter, failures are samples."""

import threading
from dataclasses import replace

import numpy as np
import pytest

from circuits.bias import rebias
from circuits.blocks.sonar import rebound_neuron
from circuits.circuit import BiasKind, Circuit, Port
from circuits.devices import Resistor, Source
from circuits.devices.source import Constant, Driven
from circuits.errors import ParameterError, SolverError
from circuits.lowering.kernel import Machine, on_die, to_kernel
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.batch import map_dies, rest_near, samples
from circuits.solver.operating_point import operating_point
from circuits.solver.transient import Runner
from circuits.testbench import Testbench

NEURON = rebound_neuron.build()
DIES = [Die(number=k) for k in range(1000, 1012)]
BODY = replace(
    AMI_1500_IDEAL,
    n=replace(AMI_1500_IDEAL.n, law="ekv-gamma"),
    p=replace(AMI_1500_IDEAL.p, law="ekv-gamma", junction_leakage=1e-9, early_field=5e6),
)


def machine_of(circuit: Circuit, silicon: Silicon) -> Machine:
    sources = (
        Source("vdd", "vdd", Constant(5.0)),
        Source("call", "call", Driven(0.0)),
        Source("echo", "echo", Driven(0.0)),
    )
    return to_kernel(Testbench("neuron", circuit, sources, 1.0, watch=("spike",)), silicon)


def leaves(value: object) -> list[np.ndarray]:
    return [x for v in value for x in leaves(v)] if isinstance(value, tuple) else [np.asarray(value)]


@pytest.mark.parametrize("kind", ["gate", "ideal", "generator"])
@pytest.mark.parametrize(
    "silicon",
    [
        Silicon(AMI_1500_IDEAL),
        Silicon(process=BODY, temperature_c=40.0, place=(("chip", ()), ("neuron", (3,)))),
        Silicon(AMI_1500_IDEAL, die=Die("B", 3, "ff")),
    ],
)
def test_a_machine_on_a_die_equals_lowering_there(kind: BiasKind, silicon: Silicon) -> None:
    circuit = rebias(NEURON, kind=kind)
    base = machine_of(circuit, silicon)
    for die in (Die(), Die(number=5), Die("C", 5, "sf", process=False), Die(number=5, mismatch=False)):
        lowered, moved = machine_of(circuit, replace(silicon, die=die)), on_die(base, die)
        for a, b in zip(leaves(lowered.kernel), leaves(moved.kernel), strict=True):
            assert a.dtype == b.dtype
            assert a.tobytes() == b.tobytes()
        for a, b in zip(leaves(lowered.polylines), leaves(moved.polylines), strict=True):
            assert a.tobytes() == b.tobytes()
        assert moved.silicon == lowered.silicon


def test_a_machine_without_transistors_goes_to_any_die() -> None:
    circuit = Circuit("divider", (), (Resistor("a", "in", "out", 1e3), Resistor("b", "out", "0", 1e3)))
    bench = Testbench(
        "divider",
        replace(circuit, ports=(Port("in", "analog"),)),
        (Source("in", "in", Constant(2.0)),),
        1.0,
    )
    for machine in (on_die(to_kernel(bench), die) for die in DIES[:2]):
        assert operating_point(machine)["out"] == pytest.approx(1.0)


def waveform(machine: Machine) -> bytes:
    """5 ms after a call, all points and the final state as bytes."""
    runner = Runner(machine, ("v_mem",), 1e-3)
    state = runner.begin(operating_point(machine))
    line = (np.array([0.0, 1e-7, 1e-5, 1.01e-5]), np.array([0.0, 5.0, 5.0, 0.0]))
    state, segment = runner.advance(state, 5e-3, {"call": line}, stop_at_event=False)
    return segment.time.tobytes() + segment.voltage.tobytes() + state.voltage.tobytes()


def test_bits_are_the_same_for_any_workers_order_and_subset() -> None:
    machine = machine_of(NEURON, Silicon(AMI_1500_IDEAL))
    one = map_dies(waveform, machine, DIES, workers=1)
    assert [s.die for s in one] == DIES
    assert len({s.value for s in one}) == len(DIES)
    for workers in (2, 5):
        assert map_dies(waveform, machine, DIES, workers=workers) == one
    assert map_dies(waveform, machine, DIES[::-1], workers=2) == one[::-1]
    assert map_dies(waveform, machine, DIES[3:4]) == one[3:4]
    fresh = [waveform(machine_of(NEURON, Silicon(AMI_1500_IDEAL, die=die))) for die in DIES[:2]]
    assert fresh == [s.value for s in one[:2]]


def test_a_rest_state_near_the_nominal_one_is_the_die_s_own() -> None:
    machine = machine_of(NEURON, Silicon(AMI_1500_IDEAL))
    nominal = operating_point(machine)
    for there in (on_die(machine, die) for die in DIES):
        near, cold = rest_near(there, nominal), operating_point(there)
        np.testing.assert_allclose(near.voltage, cold.voltage, rtol=0.0, atol=1e-9)
        assert near.machine is there
        lost = replace(nominal, voltage=np.full_like(nominal.voltage, np.nan))
        np.testing.assert_array_equal(rest_near(there, lost).voltage, cold.voltage)


def number(machine: Machine) -> int:
    k = machine.silicon.die.number or 0
    if k == 1003:
        raise SolverError("neuron: no operating point\n give a start")
    if k == 1005:
        raise KeyError
    return k


def test_a_sample_that_fails_is_reported_and_the_others_go_on() -> None:
    machine = machine_of(NEURON, Silicon(AMI_1500_IDEAL))
    done: list[int] = []
    found = map_dies(number, machine, DIES, workers=2, progress=done.append)
    assert [s.value for s in found] == [None if k in {1003, 1005} else k for k in range(1000, 1012)]
    reasons = {s.die.number: s.reason for s in found if s.reason}
    assert reasons == {1003: "neuron: no operating point give a start", 1005: "KeyError"}
    assert done == list(range(1, 13))


def test_samples_come_as_they_are_asked_for() -> None:
    """Dies may have no end, and closing the iterator drops those that were not begun."""
    machine, begun, lock = machine_of(NEURON, Silicon(AMI_1500_IDEAL)), [], threading.Lock()

    def note(m: Machine) -> int:
        with lock:
            begun.append(m.silicon.die.number)
        return 0

    stream = samples(note, machine, (Die(number=k) for k in iter(int, 1)), workers=2)
    assert [next(stream).value for _ in range(20)] == [0] * 20
    stream.close()  # type: ignore[attr-defined]  # it is a generator
    assert len(begun) < 40
    assert map_dies(note, machine, []) == []


def test_workers_are_at_least_one() -> None:
    with pytest.raises(ParameterError, match="workers: 0, must be at least 1"):
        samples(number, machine_of(NEURON, Silicon(AMI_1500_IDEAL)), DIES, workers=0)
