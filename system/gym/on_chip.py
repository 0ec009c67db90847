"""A chip between an environment and its actions, as a wrapper of Gymnasium.

Each `step` lets the chip act; an action that is given goes over the chip's. See `system.play.policy`.
"""

from __future__ import annotations

from typing import Any, SupportsFloat

import gymnasium
import numpy as np

from system.play.policy import ChipPolicy


class OnChip(gymnasium.Wrapper[Any, Any, Any, Any]):
    """An environment whose actions a chip takes.

    Parameters
    ----------
    environment
        Any environment.
    policy
        The chip with its encoder and decoder (`ChipPolicy`); each `reset` begins it anew.
    """

    def __init__(self, environment: gymnasium.Env[Any, Any], policy: ChipPolicy) -> None:
        super().__init__(environment)
        self.policy, self._seen = policy, None

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Begin environment and chip anew, and return what the environment does.

        Parameters
        ----------
        seed
            Number of the environment's world, None for one that it draws.
        options
            Options of the environment.
        """
        self.policy.begin()
        self._seen, told = self.env.reset(seed=seed, options=options)
        return self._seen, told

    def step(self, action: Any) -> tuple[Any, SupportsFloat, bool, bool, dict[str, Any]]:
        """Let the chip go on by a window and act; an `action` that is not None goes over its own."""
        own = self.policy(self._seen)
        taken = own if action is None else action
        if isinstance(self.env.action_space, gymnasium.spaces.Box):
            space = self.env.action_space
            taken = np.asarray(taken, dtype=space.dtype).reshape(space.shape)
        self._seen, reward, terminated, truncated, told = self.env.step(taken)
        return self._seen, reward, terminated, truncated, {**told, "chip_action": own}
