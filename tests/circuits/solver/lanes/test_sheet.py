"""What transistors do at many vectors of voltages side by side, against the solver's law at each of them."""

import numpy as np
import pytest

from circuits.lowering.kernel import to_kernel
from circuits.registry import load_block
from circuits.silicon.die import Die
from circuits.silicon.silicon import Silicon
from circuits.solver.lanes.sheet import fill, new_sheet, take
from circuits.solver.newton import add_others, allocate, evaluate
from circuits.vectors.vector import WIDTH

NAMES = ("rebound-neuron", "dpi-synapse-bench", "onset-neuron", "winner-take-all")
CURRENT = 1e-11  # of what both ends of a channel carry each way; both laws' logarithms are within 1e-13


def random_rows(machine, count):
    rng = np.random.default_rng(7)
    voltage = rng.uniform(-0.2, 2.0, (count, machine.kernel.columns))
    voltage[:, -1] = 0.0
    return voltage


@pytest.mark.parametrize("name", NAMES)
def test_a_lane_has_what_the_solver_evaluates(name):
    block = load_block(name)
    machine = to_kernel(block.bench(), Silicon(block.process, 40.0, Die(number=1)))
    k, voltage = machine.kernel, random_rows(machine, WIDTH + 3)
    t, n = k.transistors, k.transistors.sign.size
    sheet, own, other, every = new_sheet(k), allocate(k), allocate(k), np.arange(n)
    for first in (0, WIDTH):
        fill(k, every, voltage, first, sheet)
        for row in range(first, min(first + WIDTH, len(voltage))):
            evaluate(k, voltage[row], own)
            take(k, sheet, row - first, voltage[row], other)
            carried = t.specific_current * (own.transistor.value[:n] ** 2 + own.transistor.value[n:] ** 2)
            there = sheet.current[:, row - first]
            apart = np.abs(there[:n] - own.current[:n])
            assert (apart <= CURRENT * np.maximum(carried, np.abs(own.current[:n]))).all()
            np.testing.assert_allclose(there[n:], own.current[n : 3 * n], rtol=1e-11, atol=1e-28)
            slopes = np.abs(other.slope[: 3 * n] - own.slope[: 3 * n]).reshape(3, n)
            # in no more than what the larger end has: the factors of all effects are of order 1
            assert (slopes <= 20.0 * CURRENT * carried / 0.025).all()
            own.current[: 3 * n] = 0.0
            add_others(k, voltage[row], own)
            np.testing.assert_array_equal(other.residual, own.residual)
            np.testing.assert_array_equal(other.slope[7 * n :], own.slope[7 * n :])
            # E is 1 + rest, of the Early voltage that rises with inversion
            rise = 1.0 + t.early_rise * (own.transistor.value[:n] + own.transistor.value[n:])
            rest = t.early * np.abs(voltage[row, t.terminal[0]] - voltage[row, t.terminal[2]]) / rise
            np.testing.assert_allclose(sheet.early[:, row - first], rest / (1.0 + rest), rtol=1e-11)


def test_transistors_that_are_left_out_stay_as_they_were():
    block = load_block("rebound-neuron")
    machine = to_kernel(block.bench(), Silicon(block.process))
    k, voltage, sheet = machine.kernel, random_rows(machine, WIDTH), new_sheet(machine.kernel)
    fill(k, np.array([3]), voltage, 0, sheet)
    own = allocate(k)
    evaluate(k, voltage[5], own)
    assert sheet.current[3, 5] == pytest.approx(own.current[3], rel=1e-9)
    assert not np.delete(sheet.current[: k.transistors.sign.size], 3, axis=0).any()
