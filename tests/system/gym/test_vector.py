"""Environments in processes are those of one process, and an error of one is a line here."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
import pytest

from circuits.errors import ParameterError
from system.gym.registration import id_of

BUG: dict[str, Any] = {"map": "bug-open", "duration": "30ms"}


def test_environments_in_processes_are_those_of_one() -> None:
    name = f"system.gym:{id_of('Bug')}"
    alone = gymnasium.make_vec(name, num_envs=3, vectorization_mode="sync", **BUG)
    shared = gymnasium.make_vec(name, num_envs=3, workers=2, **BUG)
    try:
        seen = [each.reset(seed=7) for each in (alone, shared)]
        assert np.array_equal(seen[0][0], seen[1][0])
        actions = np.array([[1.0, 0.0], [0.0, 1.0], [0.5, -0.5]])
        for _ in range(5):  # their time is over after three steps, and they begin anew
            first, second = alone.step(actions), shared.step(actions)
            assert all(np.array_equal(a, b) for a, b in zip(first[:4], second[:4], strict=True))
            assert {k: list(v) for k, v in first[4].items()} == {k: list(v) for k, v in second[4].items()}
        with pytest.raises(ParameterError, match=r"\[0\] \(steering vector.*\): 2, must be a number from -1"):
            shared.step(np.array([[2.0, 0.0]] * 3))
        with pytest.raises(ParameterError, match="must be one for each of 3"):
            shared.step(np.zeros((2, 2)))
        assert shared.reset(seed=7)[0].shape == (3, 14)
    finally:
        shared.close()


def test_counts_of_environments_and_workers_are_above_0() -> None:
    with pytest.raises(ParameterError, match="3 environments on 0 workers, must be 1 at least"):
        gymnasium.make_vec(f"system.gym:{id_of('Bug')}", num_envs=3, workers=0, **BUG)
