"""The behavioural model as a target has the transistor level's answer, within the model's own error."""

from __future__ import annotations

import pytest

from circuits.errors import ParameterError
from circuits.silicon.die import Die
from system.study.search.behavioural_target import BehaviouralTarget
from system.study.table import Condition
from system.study.target import BlockTarget, Subject

HERE = Condition("random", 27.0, 0)


def test_the_model_is_the_transistor_level_on_dies_near_the_nominal_one() -> None:
    target = BlockTarget(Subject("rebound-neuron", ("best_delay", "width", "t_inh"), bias_set="robust"))
    model = BehaviouralTarget(target)
    die = Die(number=0, process=False)
    slow, fast = target.measure(die, HERE), model.measure(die, HERE)
    assert slow.outcome == fast.outcome == "works"
    # what the model's benchmark allows its edges: 2 % of t_inh
    assert fast.values == pytest.approx(slow.values, abs=0.02 * slow.values[2])
    assert model.labels() == target.labels()
    counted = Subject("rebound-neuron", ("spikes_per_echo",))
    with pytest.raises(ParameterError, match="use transistor"):
        BehaviouralTarget(BlockTarget(counted))
