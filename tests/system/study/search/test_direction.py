"""What stands behind biases is moved by lines, and each of its draws gets its part."""

import numpy as np
import pytest

from circuits.lowering.bias_moves import behind_bias
from circuits.lowering.kernel import Machine
from circuits.silicon.die import Die
from system.options.silicon import SiliconChoice
from system.study.search.direction import Directions
from system.study.search.sensitivity import sensitivity
from system.study.table import Condition
from system.study.target import BlockTarget, Subject, open_target

HERE = "tests.system.study.search.test_direction"
CONDITION = Condition("random", 27.0, 0)


def lines(machine: Machine) -> float:
    """Linear in a threshold of the circuit, and in the voltages of all lines, with weights of their own."""
    given = machine.polylines[len(machine.testbench.sources) :]
    voltages = [float(value[0]) for _, value in given]
    weighed = sum((k + 1) * v for k, v in enumerate(voltages))
    return weighed + float(machine.kernel.transistors.v_t0[0])


@pytest.mark.parametrize(("kind", "near"), [("ideal", 5e-3), ("generator", 0.03)])
def test_a_line_is_one_direction_and_tells_any_die(kind: str, near: float) -> None:
    subject = Subject("transamp-n", (f"{HERE}:lines",), bias_kind=kind,  # type: ignore[arg-type]
                      silicon=SiliconChoice(process_variation=False))  # fmt: skip
    target = open_target(subject)
    assert isinstance(target, BlockTarget)
    found = sensitivity(target, Die(process=False), CONDITION)
    circuit = [label for label in found.labels if not behind_bias(label)]
    currents = [bias for bias in target.choice.circuit.biases if bias.kind == kind]
    assert len(found.below) == len(circuit) + len(currents) < len(found.labels)
    gradient = found.gradient[:, 0]
    spread = float(np.linalg.norm(gradient))
    told, measured = [], []
    for number in range(1000, 1008):
        die = Die(number=number, process=False)
        told.append(found.nominal[0] + target.draws(die) @ gradient)
        measured.append(target.measure(die, CONDITION).values[0])
    assert np.std(measured) > 0.3 * spread
    # what is left is the second order of current factors and of mirrors
    np.testing.assert_allclose(told, measured, atol=near * spread)


def test_a_slope_that_is_not_defined_takes_its_own_draws_alone() -> None:
    moved = Directions(("a", "line"), np.eye(2, 3), np.array([[1.0, 0.0], [0.0, 0.6], [0.0, 0.8]]))
    np.testing.assert_allclose(moved.gradient(np.array([2.0, 5.0])), [2.0, 3.0, 4.0])
    np.testing.assert_array_equal(moved.gradient(np.array([2.0, np.nan])), [2.0, np.nan, np.nan])
