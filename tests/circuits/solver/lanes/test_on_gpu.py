"""Runs on a graphics processor beside runs in lanes: the text that is made for it, compiled here."""

from collections.abc import Iterator

import numpy as np
import pytest

from circuits.lowering.kernel import Machine, to_kernel
from circuits.lowering.on_dies import on_dies
from circuits.programs import gpu
from circuits.registry import load_block
from circuits.silicon.die import Die
from circuits.silicon.silicon import Silicon
from circuits.solver import many
from circuits.solver.lanes import on_gpu
from circuits.solver.lanes.simulate import simulate_each
from circuits.solver.many import spikes_on_gpu
from circuits.solver.transient import Result
from tests.circuits.programs.stand_in import COMPILER, stand_in

WITHIN = 1e-6  # s


@pytest.fixture
def stands_in(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    if COMPILER is None:
        pytest.skip("no C++ compiler, which stands in for a graphics processor")
    monkeypatch.setattr(gpu, "cupy", stand_in)
    gpu._compiled.cache_clear()
    yield
    gpu._compiled.cache_clear()


def dies_of(name: str, count: int) -> list[Machine]:
    block = load_block(name)
    machine = to_kernel(block.bench(), Silicon(block.process))
    return on_dies(machine, [Die(number=n) for n in range(count)])


def results(machines: list[Machine], place: str, **options: object) -> list[Result]:
    found = list(simulate_each(machines, place=place, **options))  # type: ignore[arg-type]
    assert all(isinstance(each, Result) for each in found)
    return [each for each in found if isinstance(each, Result)]


# 150 runs have 160 threads, which are no whole number of blocks of 128
@pytest.mark.parametrize(("name", "count"), [("axon-hillock", 150), ("nef-neuron", 3)])
@pytest.mark.usefixtures("stands_in")
def test_runs_are_those_of_the_lanes(name: str, count: int) -> None:
    machines = dies_of(name, count)
    for ours, lanes in zip(results(machines, "gpu"), results(machines, "cpu"), strict=True):
        assert ours.steps.accepted == pytest.approx(lanes.steps.accepted, rel=0.02)
        assert ours.steps.accepted == ours.time.size - 1
        assert ours.spikes.keys() == lanes.spikes.keys()
        for port, times in lanes.spikes.items():
            np.testing.assert_allclose(ours.spikes[port], times, rtol=0.0, atol=WITHIN)


@pytest.mark.usefixtures("stands_in")
def test_more_numbers_than_constants_have_room_for_stand_in_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    machines = dies_of("axon-hillock", 2)
    some = results(machines, "gpu")
    monkeypatch.setattr(gpu, "_CONSTANTS", 10)
    on_gpu._PROGRAMS.clear()
    for one, other in zip(some, results(machines, "gpu"), strict=True):
        np.testing.assert_array_equal(one.voltage, other.voltage)
    on_gpu._PROGRAMS.clear()


@pytest.mark.parametrize("room", [256, 3])
@pytest.mark.usefixtures("stands_in")
def test_spikes_of_many_dies_are_those_of_their_runs(monkeypatch: pytest.MonkeyPatch, room: int) -> None:
    monkeypatch.setattr(on_gpu, "_SPIKES", room)
    monkeypatch.setattr(many, "_LONG", 10**9)
    block = load_block("high-threshold-neuron")
    machine, dies = to_kernel(block.bench(), Silicon(block.process)), [Die(number=n) for n in range(70)]
    found = spikes_on_gpu(machine, dies, rtol=1e-5)
    runs = results(on_dies(machine, dies), "cpu", rtol=1e-5)
    # a run that fills a thread's room cannot go on there
    assert found.again.tolist() == [k for k, r in enumerate(runs) if r.spikes["spike"].size >= room]
    assert found.failed == {}
    assert found.time.size > 0
    for k, lanes in enumerate(runs):
        for j, port in enumerate(found.ports):
            own = found.time[(found.die == k) & (found.port == j)]
            np.testing.assert_allclose(own, lanes.spikes[port], rtol=0.0, atol=WITHIN)
        first = lanes.spikes["spike"][0] if lanes.spikes["spike"].size else np.nan
        assert found.first("spike")[k] == pytest.approx(first, abs=WITHIN, nan_ok=True)
        assert found.steps[k, 0] == pytest.approx(lanes.steps.accepted, rel=0.02)


@pytest.mark.usefixtures("stands_in")
def test_runs_that_take_more_steps_are_begun_again_and_the_longest_left_to_the_processor(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    block = load_block("high-threshold-neuron")
    machine, dies = to_kernel(block.bench(), Silicon(block.process)), [Die(number=n) for n in range(40)]
    monkeypatch.setattr(many, "_LONG", 10**9)
    whole = spikes_on_gpu(machine, dies, rtol=1e-5)
    assert whole.again.size == 0
    # of 37 runs of some 1,300 steps, and three that spike over and over while there is a sound: if they went
    # on so to the end they would have some 23,700, 17,400 and 25,800
    monkeypatch.setattr(many, "_SHORT", 3000)
    monkeypatch.setattr(many, "_LONG", 20_000)
    found = spikes_on_gpu(machine, dies, rtol=1e-5)
    assert found.again.tolist() == [13, 33]
    there = np.setdiff1d(np.arange(len(dies)), found.again)
    assert (whole.steps[there, :2].sum(axis=1) > many._SHORT).sum() == 1
    np.testing.assert_array_equal(found.steps[there], whole.steps[there])
    here = np.isin(found.die, there)
    np.testing.assert_array_equal(found.time[here], whole.time[np.isin(whole.die, there)])
    np.testing.assert_array_equal(found.die, whole.die)
    np.testing.assert_array_equal(found.port, whole.port)
    np.testing.assert_allclose(found.time, whole.time, rtol=0.0, atol=WITHIN)


@pytest.mark.parametrize("blocks", [16, 2])
@pytest.mark.usefixtures("stands_in")
def test_runs_without_room_are_done_again_or_by_themselves(
    monkeypatch: pytest.MonkeyPatch, blocks: int
) -> None:
    # 32 threads have two or three runs each, with room for one of some 3,000 points, or for none
    monkeypatch.setattr(on_gpu, "_MEMORY", 1)
    monkeypatch.setattr(on_gpu, "_BLOCKS", blocks)
    machines = dies_of("axon-hillock", 80)
    for ours, lanes in zip(results(machines, "gpu"), results(machines, "cpu"), strict=True):
        assert ours.steps.accepted == ours.time.size - 1
        assert (np.diff(ours.time) > 0.0).all()
        if blocks == 2:  # all are left to lanes
            np.testing.assert_array_equal(ours.voltage, lanes.voltage)
        np.testing.assert_allclose(ours.spikes["spike"], lanes.spikes["spike"], rtol=0.0, atol=WITHIN)
