"""Many dies at once are the dies one by one, to the bit."""

from dataclasses import replace

import numpy as np

from circuits.bias import rebias
from circuits.blocks.sonar import rebound_neuron
from circuits.lowering.kernel import Machine, on_die, to_kernel
from circuits.lowering.on_dies import on_dies
from circuits.silicon.die import Corner, Die
from circuits.silicon.silicon import Silicon


def assert_same(machine: Machine, dies: list[Die]) -> None:
    for one, other in zip(on_dies(machine, dies), [on_die(machine, d) for d in dies], strict=True):
        assert one.silicon == other.silicon
        for a, b in zip(one.kernel.transistors, other.kernel.transistors, strict=True):
            assert np.array_equal(a, b)
        for (t, v), (at, av) in zip(one.polylines, other.polylines, strict=True):
            assert np.array_equal(t, at)
            assert np.array_equal(v, av)
        assert np.array_equal(one.kernel.charge.value, other.kernel.charge.value)


def test_dies_of_all_kinds() -> None:
    machine = to_kernel(rebound_neuron.BLOCK.bench(), Silicon(die=Die(number=3)))
    numbers = (0, 1000, 2**40)
    corner: Corner = "ss"
    for kind in (Die(), Die("B"), Die(corner=corner), Die(mismatch=False), Die(process=False)):
        assert_same(machine, [replace(kind, number=n) for n in numbers])
    assert on_dies(machine, []) == []


def test_dies_that_are_not_alike_and_dies_with_more_than_plain_draws() -> None:
    machine = to_kernel(rebound_neuron.BLOCK.bench(), Silicon())
    edited = Die(number=7).with_("rebound_neuron/mn1", "v_t0", 0.01)
    assert_same(machine, [Die(number=1), Die("B", 1), Die(), edited, Die(number=1, variation="full")])
    assert_same(machine, [edited, replace(edited, number=8)])


def test_a_place_on_a_chip_and_biases_that_stand_on_the_die() -> None:
    bench = rebound_neuron.BLOCK.bench()
    placed = Silicon(place=(("ranging_chip", ()), ("neuron", (2,))))
    assert_same(to_kernel(bench, placed), [Die(number=n) for n in (5, 6)])
    ideal = replace(bench, circuit=rebias(bench.circuit, kind="ideal"))
    assert_same(to_kernel(ideal, Silicon()), [Die(number=n) for n in (5, 6)])
