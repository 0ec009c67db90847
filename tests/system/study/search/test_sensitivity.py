"""Gradients are those of metrics that are known, and what is not defined is told."""

from __future__ import annotations

import math

import numpy as np
import pytest

from circuits.errors import ParameterError
from circuits.lowering.kernel import Machine
from circuits.silicon.die import Die
from system.options.silicon import SiliconChoice
from system.study.search.sensitivity import STEP, sensitivity, varying_labels
from system.study.table import Condition
from system.study.target import BlockTarget, Subject, open_target

HERE = "tests.system.study.search.test_sensitivity"
CONDITION = Condition("random", 27.0, 0)
DEVICE = 4


def thresholds(machine: Machine) -> float:
    """Linear in every threshold, one of them fifty times."""
    v_t0 = machine.kernel.transistors.v_t0
    return float(v_t0.sum() + 50.0 * v_t0[DEVICE])


def one_sided(machine: Machine) -> float:
    """Not defined above the nominal threshold of one device, refused below that of another."""
    v_t0, nominal = machine.kernel.transistors.v_t0, NOMINAL
    if v_t0[1] < nominal[1] - 1e-9:
        raise ZeroDivisionError("no slope")
    return math.nan if v_t0[0] > nominal[0] + 1e-9 else math.exp(float(v_t0[2]))


def target(metric: str, process: bool = True) -> BlockTarget:
    subject = Subject(
        "rebound-neuron", (f"{HERE}:{metric}",), silicon=SiliconChoice(process_variation=process)
    )
    found = open_target(subject)
    assert isinstance(found, BlockTarget)
    return found


NOMINAL = target("thresholds").machines(27.0)[0].kernel.transistors.v_t0


def test_a_linear_metric_has_its_coefficients() -> None:
    block, die = target("thresholds"), Die(number=1000)
    found = sensitivity(block, Die(), CONDITION)
    assert found.labels == block.labels()
    gradient = found.gradient[:, 0]
    local = [not label.startswith("process") for label in found.labels]
    assert np.argmax(np.abs(gradient) * local) == found.labels.index("rebound_neuron.inhibition.mi5.v_t0")
    value = block.measure(die, CONDITION).values[0]
    # linear, so that the gradient predicts any die; to rounding of a sum of volts over a step of millivolts
    assert found.nominal[0] + block.draws(die) @ gradient == pytest.approx(value, rel=1e-9)


def test_a_logarithm_has_the_relative_gradient() -> None:
    found = sensitivity(target("thresholds"), Die(), CONDITION)
    # of central differences the logarithm's differ by the square of the relative step, below 1e-3 here
    np.testing.assert_allclose(found.log_gradient, found.gradient / found.nominal, rtol=1e-3)


def test_a_set_corner_leaves_the_process_no_draws() -> None:
    block = target("thresholds")
    labels = varying_labels(block, "ss")
    assert len(labels) == len(block.labels()) - 4
    assert not any(label.startswith("process") for label in labels)


def test_what_is_not_defined_is_told() -> None:
    found = sensitivity(target("one_sided", process=False), Die(process=False), CONDITION)
    undefined = [
        label for label, g in zip(found.labels, found.gradient[:, 0], strict=True) if not np.isfinite(g)
    ]
    assert undefined == [found.labels[0], found.labels[1]]
    assert found.failures == (f"{found.labels[1]} -{STEP:g} sigma: ZeroDivisionError: no slope",)


def test_threads_change_nothing() -> None:
    once = sensitivity(target("thresholds"), Die(), CONDITION, 1)
    again = sensitivity(target("thresholds"), Die(), CONDITION, 4)
    np.testing.assert_array_equal(once.gradient, again.gradient)


def test_a_system_has_no_listed_draws() -> None:
    system = open_target(Subject("approach", ("calls",), system={"level": "behavioural", "duration": 0.5}))
    with pytest.raises(ParameterError, match="system"):
        sensitivity(system, Die(), CONDITION)
