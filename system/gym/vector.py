"""Several environments of one robot, shared out among processes.

`gymnasium.make_vec(id, num_envs=N)` makes it, `workers=2` says of how many processes. Each has some of the
environments, as a `SyncVectorEnv` has them, so that a message is of many steps; what comes out is that of one
`SyncVectorEnv` of all.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from functools import partial
from multiprocessing import get_context
from multiprocessing.connection import Connection
from typing import Any

import gymnasium
import numpy as np
from gymnasium.vector.utils import batch_space

from circuits.errors import CircuitError, ParameterError
from system.gym.environment import Environment

_Told = tuple[Any, ...]


class Workers(gymnasium.vector.VectorEnv[Any, Any, Any]):
    """Environments in processes.

    Parameters
    ----------
    num_envs
        How many environments there are.
    workers
        How many processes; as many as there are cores to this one unless given, at most one an environment.
    given
        Of each environment, as of `Environment`.

    Raises
    ------
    ParameterError
        A count is not above 0, or an environment cannot be made.
    """

    def __init__(self, num_envs: int, workers: int | None = None, **given: Any) -> None:
        usual = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
        count = usual if workers is None else workers
        if num_envs < 1 or count < 1:
            raise ParameterError(f"vector: {num_envs} environments on {count} workers, must be 1 at least")
        one = Environment(**given)
        self.num_envs, self.render_mode = num_envs, one.render_mode
        self.metadata = {**one.metadata, "autoreset_mode": gymnasium.vector.AutoresetMode.NEXT_STEP}
        self.single_observation_space, self.single_action_space = one.observation_space, one.action_space
        self.observation_space = batch_space(one.observation_space, num_envs)
        self.action_space = batch_space(one.action_space, num_envs)
        self._parts = [np.asarray(part) for part in np.array_split(np.arange(num_envs), min(count, num_envs))]
        context = get_context("spawn")
        self._pipes, self._processes = [], []
        for part in self._parts:
            ours, theirs = context.Pipe()
            process = context.Process(target=_serve, args=(theirs, part.size, given), daemon=True)
            process.start()
            theirs.close()
            self._pipes.append(ours)
            self._processes.append(process)

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Put every robot at its start: those of a whole number `seed` at it and the numbers after it."""
        seeds: list[int | None] = [None] * self.num_envs
        if seed is not None:
            seeds = [seed + k for k in range(self.num_envs)] if isinstance(seed, int) else list(seed)
        told = self._asked(
            "reset", [{"seed": [seeds[k] for k in p], "options": options} for p in self._parts]
        )
        return np.concatenate([each[0] for each in told]), self._joined([each[1] for each in told])

    def step(self, actions: Any) -> tuple[Any, Any, Any, Any, dict[str, Any]]:
        """Go on by a step each, `actions` in the shape of their space; what has ended begins anew."""
        given = np.asarray(actions)
        if given.shape[:1] != (self.num_envs,):
            raise ParameterError(
                f"vector.actions: of shape {given.shape}, must be one for each of {self.num_envs}"
            )
        told = self._asked("step", [{"actions": given[part]} for part in self._parts])
        seen, rewards, ended, late = (np.concatenate([each[k] for each in told]) for k in range(4))
        return seen, rewards, ended, late, self._joined([each[4] for each in told])

    def close_extras(self, **_: Any) -> None:
        """End the processes."""
        for pipe, process in zip(self._pipes, self._processes, strict=True):
            if process.is_alive():
                pipe.send(None)
            process.join(5.0)
            pipe.close()

    def _asked(self, name: str, words: list[dict[str, Any]]) -> list[_Told]:
        """What each process answers; raises the first error of one, after all have answered."""
        for pipe, given in zip(self._pipes, words, strict=True):
            pipe.send((name, given))
        told = [pipe.recv() for pipe in self._pipes]
        errors = [each for each in told if isinstance(each, Exception)]
        if errors:
            raise errors[0]
        return told

    def _joined(self, told: list[dict[str, Any]]) -> dict[str, Any]:
        """What is said of all environments, an array a word, with a mask of those that it is said of."""
        found: dict[str, Any] = {}
        for part, each in zip(self._parts, told, strict=True):
            for name, values in each.items():
                kind = values.dtype if isinstance(values, np.ndarray) else np.dtype(object)
                if name not in found:
                    found[name] = np.zeros(self.num_envs, dtype=kind)
                found[name][part] = values
        return found


def _serve(pipe: Connection, count: int, given: Mapping[str, Any]) -> None:
    """Answer the words of a parent until it says None."""
    environments: Any = None
    while (asked := pipe.recv()) is not None:
        name, words = asked
        try:
            if environments is None:
                environments = gymnasium.vector.SyncVectorEnv([partial(Environment, **given)] * count)
            pipe.send(getattr(environments, name)(**words))
        except (CircuitError, gymnasium.error.Error) as error:
            pipe.send(error)
    pipe.close()
